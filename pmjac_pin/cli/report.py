"""``pmjac report``."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from pmjac_pin.cli.options import Choice, FrameOption, NameOption, PoseOption, split_names
from pmjac_pin.cli.output import Json, Output
from pmjac_pin.words.plain import to_json
from pmjac_pin.words.report import report
from pmjac_pin.words.tables import report_blocks


def report_command(
    mechanism: NameOption,
    /,
    *,
    pose: PoseOption = PoseOption(),
    frame: FrameOption = "LOCAL_WORLD_ALIGNED",
    choice: Choice = Choice(),
    only: Annotated[str | None, Parameter(help="Matrices alone, such as J_eq or K,K_star.")] = None,
    json: Json = False,
) -> Output:
    """Show all that is known at one pose, as tables or as JSON."""
    configuration, names = pose.configuration(choice.load(mechanism))
    found = report(configuration, frame, **names)
    if only is not None:
        tables = {name: found.table(name) for name in split_names(only)}
        return f"{to_json(tables)}\n" if json else [one.block(name) for name, one in tables.items()]
    return f"{to_json(found.told())}\n" if json else report_blocks(found)
