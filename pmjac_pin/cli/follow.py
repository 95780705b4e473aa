"""``pmjac follow``."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from pmjac_pin.cli.exit_status import INTERRUPTED
from pmjac_pin.cli.options import Choice, Force, NameOption, check_output, output_option
from pmjac_pin.cli.output import Json, Verdict
from pmjac_pin.errors import Interrupted
from pmjac_pin.files.output_file import write_files
from pmjac_pin.files.user_path import user_path
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.follow.follow import follow
from pmjac_pin.studies.follow.tool_course import TOOL_COORDINATES
from pmjac_pin.studies.follow.trajectory import Trajectory
from pmjac_pin.studies.follow.waypoints_file import read_waypoints
from pmjac_pin.words.blocks import Verbatim
from pmjac_pin.words.plain import to_json
from pmjac_pin.words.progress_bar import progress_bar
from pmjac_pin.words.trajectory_report import trajectory_blocks, trajectory_csv, trajectory_told

_WRITTEN = (".csv", ".json")


@Parameter(name="*")
@dataclass(frozen=True)
class Way:
    """Which way to go, and how."""

    waypoints: Annotated[
        str,
        Parameter(
            help="A file with a column a motor, by its name, or of the tool's x, y, z, angle; and "
            "t for times: CSV or TOML."
        ),
    ]
    from_: Annotated[
        str,
        Parameter(name="--from", help="The pose from which the first point is closed (home)."),
    ] = "home"
    samples: Annotated[
        int | None, Parameter(help="How many poses to tell of, evenly in t; by default all.")
    ] = None
    pass_: Annotated[
        bool, Parameter(name="--pass", help="Go on through poses where branches cross.")
    ] = False
    certified: Annotated[bool, Parameter(help="Prove each step by interval arithmetic.")] = False

    def followed(self, mechanism: Mechanism) -> Trajectory:
        """Follow it, with a bar where somebody watches."""
        given = read_waypoints(user_path(self.waypoints))
        with progress_bar("t") as progress:
            return follow(
                mechanism,
                given.columns,
                start=self.from_,
                coordinates=_of_the_tool(given.columns, mechanism),
                times=given.times,
                samples=self.samples,
                enforce_limits=mechanism.spec.enforce_limits,
                singularity="pass" if self.pass_ else "stop",
                certified=self.certified,
                progress=progress,
            )


def _of_the_tool(columns: Iterable[str], mechanism: Mechanism) -> tuple[str, ...] | None:
    """Return the columns where they are the tool's coordinates; None where they are motors."""
    names = tuple(columns)
    known = set(TOOL_COORDINATES) - set(mechanism.actuated)
    return names if names and known.issuperset(names) else None


def follow_command(
    mechanism: NameOption,
    /,
    *,
    way: Way,
    output: Annotated[str | None, output_option("Write the poses, too: a .csv or .json.")] = None,
    force: Force = False,
    json: Json = False,
    choice: Choice = Choice(),
) -> Verdict:
    """Follow a path of the motors, or of the tool, on one mode, and tell what happens on it."""
    if output is not None:
        check_output(output, _WRITTEN, force)
    try:
        found, status = way.followed(choice.load(mechanism)), 0
    except Interrupted as interrupt:
        found, status = interrupt.done, INTERRUPTED
    if not (found.reached or status):
        status = 1
    if output is not None:
        in_csv = output.endswith(".csv")
        data = trajectory_csv(found) if in_csv else f"{to_json(trajectory_told(found))}\n"
        write_files({Path(output): data.encode()}, replace=force)
    if json:
        return Verdict(trajectory_told(found), status)
    written = [] if output is None else [Verbatim(output)]
    return Verdict([*trajectory_blocks(found), *written], status)
