"""``pmjac transmission``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from pmjac_pin.adapters import ros2_control
from pmjac_pin.cli.options import (
    Choice,
    Force,
    NameOption,
    check_output,
    numbers_given,
    output_option,
    ranges_by_name,
    split_names,
)
from pmjac_pin.cli.output import Output
from pmjac_pin.errors import ArgumentError, did_you_mean, quoted
from pmjac_pin.files.output_file import write_files
from pmjac_pin.files.user_path import shown_path
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.pictures.figures import check_figure_file, save_figure
from pmjac_pin.pictures.transmission_figure import plot_transmission
from pmjac_pin.studies.transmissions.table_maker import transmission_table
from pmjac_pin.studies.transmissions.tabulated import TABLE_SUFFIXES
from pmjac_pin.studies.transmissions.transmission_table import TransmissionTable
from pmjac_pin.studies.transmissions.widest import widest_rectangle
from pmjac_pin.words.blocks import Verbatim
from pmjac_pin.words.transmission_tables import transmission_blocks

_FIGURES = (".png", ".pdf", ".svg")
_PLUGIN = ".cpp"


@Parameter(name="*")
@dataclass(frozen=True)
class Where:
    """The rectangle of joint values, and how closely it is looked at."""

    joints: Annotated[str, Parameter(help="The joints that the robot thinks in, as pitch,roll.")]
    over: Annotated[
        str | None,
        Parameter(
            help="Where each begins and ends, such as pitch=-0.4:0.3,roll=-0.2:0.2; by default "
            "as far about home as the transmission exists."
        ),
    ] = None
    points: Annotated[int, Parameter(help="Along each joint (default: 17).")] = 17
    no_proof: Annotated[bool, Parameter(help="Estimate the error: sooner.")] = False

    def table(self, mechanism: Mechanism) -> TransmissionTable:
        """Return the transmission over the rectangle."""
        return transmission_table(
            mechanism,
            self.rectangle(mechanism),
            self.points,
            enforce_limits="all" if mechanism.spec.enforce_limits else False,
            proof=not self.no_proof,
        )

    def rectangle(self, mechanism: Mechanism) -> dict[str, tuple[float, float]]:
        """Return where each joint begins and ends."""
        names = split_names(self.joints)
        limits = "all" if mechanism.spec.enforce_limits else False
        if self.over is None:
            return widest_rectangle(mechanism, names, enforce_limits=limits)
        given = ranges_by_name("--over", self.over, "pitch=-0.4:0.3")
        for name in given:
            if name not in names:
                wanted = f"--over names {quoted(name)}, which --joints does not"
                raise ArgumentError(f"{wanted}{did_you_mean(name, names)}")
        if missing := [name for name in names if name not in given]:
            raise ArgumentError(f"--over does not say where {', '.join(missing)} begins and ends")
        return {name: given[name] for name in names}


def transmission_command(
    mechanism: NameOption,
    /,
    *,
    where: Where,
    output: Annotated[
        list[str] | None,
        output_option(
            "A C header (.h), beside it a plugin for ros2_control (.cpp), a table (.npz, .csv) or "
            "a figure (.png, .pdf, .svg); may be repeated."
        ),
    ] = None,
    name: Annotated[
        str | None,
        Parameter(help="What the names of the header begin with (default: the model's)."),
    ] = None,
    limits: Annotated[
        str | None,
        Parameter(help="Of the motors' efforts and rates, such as 60,60 (default: 1 each)."),
    ] = None,
    force: Force = False,
    choice: Choice = Choice(),
) -> Output:
    """Tabulate how motors and the joints that they drive by rods are geared; write it as C."""
    paths = output or []
    _check_outputs(paths, force)
    header = _header_of_plugins(paths)
    table = where.table(choice.load(mechanism))
    given = [1.0] * len(table.motors) if limits is None else numbers_given("--limits", limits)
    blocks = list(transmission_blocks(table, given))
    for path in paths:
        if Path(path).suffix in _FIGURES:
            save_figure(plot_transmission(table.map, given), path)
        elif Path(path).suffix == _PLUGIN:
            source = ros2_control.source(table, header, name)
            write_files({Path(path): source.encode()}, replace=force)
        else:
            table.save(path, name=name, force=force)
    return [*blocks, *map(Verbatim, paths)]


def _check_outputs(paths: list[str], force: bool) -> None:
    for path in paths:
        check_output(path, (*TABLE_SUFFIXES, _PLUGIN, *_FIGURES), force)
        if Path(path).suffix in _FIGURES:
            check_figure_file(path)


def _header_of_plugins(paths: list[str]) -> str:
    """Return the name of the header that is written beside plugins, which include it."""
    plugins, headers = (
        [Path(path) for path in paths if Path(path).suffix == suffix] for suffix in (_PLUGIN, ".h")
    )
    if plugins and not headers:
        wanted = f"add -o {shown_path(plugins[0].with_suffix('.h'))}"
        raise ArgumentError(f"{shown_path(plugins[0])} includes a C header: {wanted}")
    return headers[0].name if headers else ""
