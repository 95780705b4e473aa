"""``pmjac convert``."""

from __future__ import annotations

from typing import Annotated

from pmjac_pin.cli.options import Force, NameOption, Reading, output_option
from pmjac_pin.cli.output import Output
from pmjac_pin.studies.convert import convert
from pmjac_pin.words.terminal import one_line


def convert_command(
    mechanism: NameOption,
    /,
    *,
    output: Annotated[str, output_option("The new model file, such as mine.toml.")],
    reading: Reading = Reading(),
    force: Force = False,
) -> Output:
    """Write a model file and its URDF from any format; print their paths."""
    written = convert(mechanism, output, force=force, **reading.keywords())
    return "".join(f"{one_line(str(path))}\n" for path in written)
