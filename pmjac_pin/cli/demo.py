"""``pmjac demo``."""

from __future__ import annotations

from typing import Annotated

from pmjac_pin.cli.options import output_option
from pmjac_pin.cli.output import Output
from pmjac_pin.pictures.demo import demo_blocks, run_demo


def demo_command(
    *,
    output: Annotated[
        str | None, output_option("The figure (default: three_rps_lecture_b.png).")
    ] = None,
) -> Output:
    """Work through the lecture's pose B of the 3-RPS and draw its figure."""
    return demo_blocks(run_demo(output))
