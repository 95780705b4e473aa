"""``pmjac export``."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from pmjac_pin.cli.options import Choice, Force, NameOption, output_option
from pmjac_pin.cli.output import Output
from pmjac_pin.loading import load
from pmjac_pin.studies.export.export import export
from pmjac_pin.words.terminal import complain, one_line


def export_command(
    mechanism: NameOption,
    /,
    *,
    to: Annotated[str, Parameter(help="The format: mjcf, sdf, extended-urdf, urdf-plus or toml.")],
    output: Annotated[str, output_option("The new file, such as robot.xml.")],
    choice: Choice = Choice(),
    force: Force = False,
) -> Output:
    """Write a mechanism, closed, for another program; print the files' paths."""
    machine = load(mechanism, choice.parameters(), **choice.reading.keywords())
    exported = export(machine, to=to, file=output, force=force)
    for note in exported.notes:
        complain(f"pmjac: {one_line(note)}\n")
    return "".join(f"{one_line(str(path))}\n" for path in exported.paths)
