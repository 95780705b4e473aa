"""``pmjac report``."""

from __future__ import annotations

from typing import Annotated, Any

from cyclopts import Parameter

from pmjac_pin.cli.options import (
    Choice,
    FrameOption,
    NameOption,
    PoseOption,
    parsed_values,
    split_names,
)
from pmjac_pin.cli.output import Json, Output
from pmjac_pin.words.report import report
from pmjac_pin.words.tables import report_blocks


def report_command(
    mechanism: NameOption,
    /,
    *,
    pose: PoseOption = PoseOption(),
    frame: FrameOption = "LOCAL_WORLD_ALIGNED",
    choice: Choice = Choice(),
    rates: Annotated[
        str | None, Parameter(help="Motor rates, m/s or rad/s, given as --at is: what follows.")
    ] = None,
    accelerations: Annotated[
        str | None, Parameter(help="Motor accelerations, m/s² or rad/s², given as --at is.")
    ] = None,
    wrench: Annotated[
        str | None,
        Parameter(
            help="On the tool, N and N m by the world's axes about the tool's origin, such as "
            "0,0,-30,0,0,0 or fz=-30: what balances it and the weight."
        ),
    ] = None,
    dynamics: Annotated[
        bool, Parameter(help="Mass matrix, bias and the efforts of these motions and loads.")
    ] = False,
    only: Annotated[str | None, Parameter(help="Matrices alone, such as J_eq or K,K_star.")] = None,
    json: Json = False,
) -> Output:
    """Show all that is known at one pose, as tables or as JSON."""
    configuration, names = pose.configuration(choice.load(mechanism))
    given = {"rates": rates, "accelerations": accelerations, "wrench": wrench}
    asked: dict[str, Any] = {
        name: parsed_values(f"--{name}", text) for name, text in given.items() if text is not None
    }
    found = report(configuration, frame, **names, **asked, dynamics=dynamics)
    if only is not None:
        tables = {name: found.table(name) for name in split_names(only)}
        return tables if json else [one.block(name) for name, one in tables.items()]
    return found.told() if json else report_blocks(found)
