"""The options that several commands share: which mechanism, adjusted how, at which pose."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeAlias, TypeVar

from cyclopts import Parameter

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, OutputError, quoted
from pmjac_pin.files.output_file import check_new
from pmjac_pin.files.user_path import shown_path
from pmjac_pin.loading import load
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.values.lapack import lapack

lapack()  # as long as Ctrl-C ends all silently, not when the first loop is closed

NameOption: TypeAlias = Annotated[
    str,
    Parameter(help="A name that pmjac list shows, or the path of a model file, URDF, MJCF or SDF."),
]
At: TypeAlias = Annotated[
    str | None, Parameter(help="Motor values, m or rad, such as 0.5,1,2 or l1=0.5,l2=1,l3=2.")
]
FrameOption: TypeAlias = Annotated[
    str, Parameter(help="Of the twist: LOCAL, WORLD or LOCAL_WORLD_ALIGNED (default).")
]

Force: TypeAlias = Annotated[bool, Parameter(help="Replace files that exist.")]
Read = TypeVar("Read")


def output_option(told: str) -> Parameter:
    """Return the option of a file that is written."""
    return Parameter(name=["--output", "-o"], help=told)


def check_output(path: str, suffixes: Sequence[str], force: bool) -> None:
    """Refuse, before anything is computed, what cannot be written."""
    if Path(path).suffix not in suffixes:
        ends = f"what is written ends in one of {', '.join(suffixes)}"
        raise OutputError(f"{shown_path(path)}: {ends}")
    check_new(path, force)


@Parameter(name="*")
@dataclass(frozen=True)
class Reading:
    """What to take instead of what a model's file tells."""

    actuated: Annotated[
        str | None, Parameter(help="The motors, such as a,b, instead of those that the file tells.")
    ] = None
    tool: Annotated[str | None, Parameter(help="The tool's frame, instead of the file's.")] = None
    tool_rows: Annotated[
        str | None,
        Parameter(help="Rows of its twist that count, such as vx,vy, of vx,vy,vz,wx,wy,wz."),
    ] = None
    tool_axes: Annotated[
        str | None,
        Parameter(help="Of these rows: LOCAL_WORLD_ALIGNED, or LOCAL for the tool's own."),
    ] = None
    locked: Annotated[
        str | None,
        Parameter(help="Joints to hold at their home values, such as spring1,spring2."),
    ] = None
    tolerance: Annotated[
        float | None, Parameter(help="Gap in m that counts as closed, where numbers are rounded.")
    ] = None
    include_root: Annotated[
        str | None,
        Parameter(help="A folder above an MJCF file, below which it may include others."),
    ] = None
    beyond_limits: Annotated[
        bool, Parameter(negative="", help="Take poses though joints are beyond their limits.")
    ] = False

    def keywords(self) -> dict[str, Any]:
        """Return them as `load`, `check` and `convert` take them."""
        return {
            "actuated": None if self.actuated is None else split_names(self.actuated),
            "tool": self.tool,
            "tool_rows": None if self.tool_rows is None else split_names(self.tool_rows),
            "tool_axes": None if self.tool_axes is None else self.tool_axes.upper(),
            "locked": () if self.locked is None else split_names(self.locked),
            "tolerance": self.tolerance,
            "include_root": self.include_root,
            "enforce_limits": False if self.beyond_limits else None,
        }


@Parameter(name="*")
@dataclass(frozen=True)
class Choice:
    """Which of the machines that a file describes."""

    set_: Annotated[
        list[str] | None,
        Parameter(name="--set", help="Parameters, such as l1=1.2,l2=3; may be repeated."),
    ] = None
    reading: Reading = Reading()

    def parameters(self) -> dict[str, float]:
        """Return the values given for the model's parameters."""
        items = [item for setting in self.set_ or () for item in setting.split(",")]
        return numbers_by_name("--set", items)

    def load(self, name: str) -> Mechanism:
        """Return the mechanism of this name or file."""
        mechanism = load(name, self.parameters(), **self.reading.keywords())
        mechanism.need_tool()  # for what is shown
        return mechanism


@Parameter(name="*")
@dataclass(frozen=True)
class PoseOption:
    """A named pose, or motor values to walk to from one."""

    at: At = None
    from_: Annotated[
        str | None,
        Parameter(
            name="--from", help="The pose to show or, with --at, to walk from (default: home)."
        ),
    ] = None

    def configuration(
        self, mechanism: Mechanism, default: str = "home"
    ) -> tuple[Configuration, dict[str, str | None]]:
        """Return the configuration asked for, and which pose it is or was reached from.

        `default` is the pose where none is asked for; motor values are reached from home.
        """
        unnamed = default if self.at is None else "home"
        start = unnamed if self.from_ is None else self.from_
        if self.at is None:
            return mechanism.pose(start), {"pose": start, "start": None}
        values, limits = parsed_values("--at", self.at), mechanism.spec.enforce_limits
        closed = mechanism.close(values, guess=start, enforce_limits=limits)
        return closed, {"pose": None, "start": start}


def numbers_by_name(option: str, items: Iterable[str]) -> dict[str, float]:
    """Return the numbers given as NAME=NUMBER."""
    return _read_by_name(option, items, "NAME=NUMBER, such as l1=1.2", float)


def ranges_by_name(option: str, given: str, such_as: str) -> dict[str, tuple[float, float]]:
    """Return where each name begins and ends, given as NAME=FROM:TO joined by commas."""

    def ends(text: str) -> tuple[float, float]:
        lower, _, upper = text.partition(":")
        return float(lower), float(upper)

    return _read_by_name(option, given.split(","), f"NAME=FROM:TO, such as {such_as}", ends)


def _read_by_name(
    option: str, items: Iterable[str], wanted: str, read: Callable[[str], Read]
) -> dict[str, Read]:
    found: dict[str, Read] = {}
    for item in items:
        name, _, value = map(str.strip, item.partition("="))
        if name in found:
            raise ArgumentError(f"{option} gives {quoted(name)} twice")
        try:
            found[name] = read(value)
        except ValueError:
            raise ArgumentError(f"{option} takes {wanted}; got {quoted(item)}") from None
    return found


def parsed_values(option: str, given: str) -> list[float] | dict[str, float]:
    """Return the numbers that an option gives, by names where it has them."""
    items = given.split(",")
    if all("=" in item for item in items):
        return numbers_by_name(option, items)
    return numbers_given(option, given)


def numbers_given(option: str, given: str) -> list[float]:
    """Return the numbers that an option gives."""
    try:
        return [float(item) for item in given.split(",")]
    except ValueError:
        message = f"{option} takes numbers joined by commas, such as 0.5,1,2; got {quoted(given)}"
        raise ArgumentError(message) from None


def split_names(text: str) -> list[str]:
    """Return names joined by commas."""
    return [name.strip() for name in text.split(",")]
