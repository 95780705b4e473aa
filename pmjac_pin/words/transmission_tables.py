"""A transmission over a rectangle as headings, paragraphs and tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.rates.motor_limits import EFFORT_UNITS
from pmjac_pin.studies.transmissions.transmission_table import TransmissionTable
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.brief import at_least, at_most, brief
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table

_LEGEND = (
    "Least and largest at the points; between the bounds in brackets all over the rectangle, as "
    "the last sentence says. Alone: the largest effort of a joint with none at the others, and its "
    "largest rate with the others at rest, where each motor gives its limit at most."
)


def transmission_blocks(table: TransmissionTable, motor_limits: ArrayLike) -> Iterator[Block]:
    """Show where a transmission is known, how its ratios and limits vary, and its error."""
    name = table.transmission.by_motors.name
    yield Heading(f"Transmission of {name}: {', '.join(table.joints)} by {', '.join(table.motors)}")
    points = " by ".join(str(axis.size) for axis in table.map.axes)
    yield Paragraph(f"{table.rectangle}; {points} points.")
    yield _ratios(table)
    yield _limits_table(table, motor_limits)
    yield _errors(table)
    yield Paragraph(_LEGEND)
    yield Paragraph(f"{table.evidence}.")


def _ratios(table: TransmissionTable) -> Table:
    ratio, condition = table.map.ratio, table.map.condition
    rows = [
        (
            f"{motor} by {joint}",
            *_extremes_text(ratio[..., i, j]),
            f"[{at_least(table.lower[i, j], 3)}, {at_most(table.upper[i, j], 3)}]",
        )
        for i, motor in enumerate(table.motors)
        for j, joint in enumerate(table.joints)
    ]
    rows.append(("condition", *_extremes_text(condition), ""))
    return Table("Gear ratios", ("", "least", "largest", "bounds"), tuple(rows), "<>>>")


def _limits_table(table: TransmissionTable, motor_limits: ArrayLike) -> Table:
    units = table.transmission.by_motors.units
    found = (
        ("effort", EFFORT_UNITS, table.map.efforts_alone(motor_limits)),
        ("rate", {"rad": "rad/s", "m": "m/s"}, table.map.rates_alone(motor_limits)),
    )
    rows = [
        (f"{what} of {joint} alone [{unit[units[joint]]}]", *_extremes_text(reach[..., k]))
        for what, unit, reach in found
        for k, joint in enumerate(table.joints)
    ]
    given = ", ".join(_rounded(x) for x in np.broadcast_to(motor_limits, len(table.motors)))
    return Table(f"Within motor limits of {given}", ("", "least", "largest"), tuple(rows), "<>>")


def _errors(table: TransmissionTable) -> Table:
    units = table.transmission.by_motors.units
    rows = tuple(
        (f"{motor} [{units[motor]}]", at_most(error))
        for motor, error in zip(table.motors, table.error.tolist(), strict=True)
    )
    return Table("Error of interpolation", ("", "at most"), rows, "<>")


def _extremes_text(values: Array) -> Sequence[str]:
    return _rounded(np.nanmin(values)), _rounded(np.nanmax(values))


def _rounded(number: float) -> str:
    return brief(float(number))
