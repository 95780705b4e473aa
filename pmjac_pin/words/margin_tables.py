"""The margins of a pose as a table and as plain data, in metres and radians."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pmjac_pin.rates.margins import JointMargin, Margins, ToolMargin
from pmjac_pin.values.brief import brief
from pmjac_pin.words.blocks import Block, Table
from pmjac_pin.words.plain import told


def margin_blocks(margins: Margins) -> Iterator[Block]:
    """Show how joints are held, one a row, and what work motors' wrenches do on the tool."""
    held = (("motors locked", margins.gain), ("tool locked", margins.loss))
    rows = tuple(
        (name, how, *_margin_numbers(one)) for how, by_name in held for name, one in by_name.items()
    )
    if rows:
        columns = ("", "held with", "arm [m]", "angle [rad]", "transmission [rad]")
        yield Table("Margins of joints: 0 where they are not held", columns, rows, "<<>>>")
    if margins.tool:
        tool = tuple((name, brief(one.value), one.unit) for name, one in margins.tool.items())
        heading = "Margins of the tool: 0 where it is free with this motor locked"
        yield Table(heading, ("", "", ""), tool, "<><")


def margins_told(margins: Margins) -> dict[str, object]:
    """Return the margins as plain data; what is infinite or unknown becomes null in JSON."""
    return {
        "gain": [_joint_told(*one) for one in margins.gain.items()],
        "loss": [_joint_told(*one) for one in margins.loss.items()],
        "tool": [_tool_told(*one) for one in margins.tool.items()],
    }


def _margin_numbers(one: JointMargin) -> tuple[str, str, str]:
    transmission = "-" if math.isnan(one.transmission) else brief(one.transmission)
    arm = brief(one.arm) if math.isfinite(one.arm) else "infinite"
    return arm, brief(one.angle), transmission


def _joint_told(name: str, one: JointMargin) -> dict[str, object]:
    return {"joint": name, **told(one, "arm", "angle", "transmission")}


def _tool_told(name: str, one: ToolMargin) -> dict[str, object]:
    return {"motor": name, **told(one, "value", "unit")}
