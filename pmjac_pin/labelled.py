"""Names and units for the rows and columns of the lecture's matrices.

A unit is kept as its powers of metre and radian, (1, 0) for m and (2, -1) for m²/rad, so that
units of quotients and of determinants follow by adding and subtracting.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias, assert_never

import msgspec
import numpy as np
from numpy.typing import NDArray

from pmjac_pin.coordinates import JointCoordinates
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.spec import DistanceLoop, Loop, PointLoop

Array = NDArray[np.float64]
Powers: TypeAlias = tuple[int, int]

METRE: Powers = (1, 0)
SQUARE_METRE: Powers = (2, 0)
RADIAN: Powers = (0, 1)

LINEAR = ("v_x", "v_y", "v_z")
ANGULAR = ("ω_x", "ω_y", "ω_z")

_SUPERSCRIPTS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


class LabelledMatrix(msgspec.Struct, frozen=True):
    """A matrix with its labels; the unit of an entry is its row's unit over its column's.

    Attributes
    ----------
    rows, columns : tuple of str
        Names.
    row_units, column_units : tuple of str
    values : tuple of tuple of float
        Row by row.
    """

    rows: tuple[str, ...]
    row_units: tuple[str, ...]
    columns: tuple[str, ...]
    column_units: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]


def labelled(
    values: Array,
    rows: tuple[str, ...],
    row_units: tuple[str, ...],
    columns: tuple[str, ...],
    column_units: tuple[str, ...],
) -> LabelledMatrix:
    """Put labels on an array, shape (len(rows), len(columns))."""
    entries = tuple(tuple(map(float, row)) for row in values)
    return LabelledMatrix(rows, row_units, columns, column_units, entries)


def joint_powers(mechanism: Mechanism) -> tuple[tuple[Powers, ...], tuple[Powers, ...]]:
    """Return the units of the actuated and of the passive degrees of freedom."""
    coordinates = JointCoordinates(mechanism.model)
    rotational = coordinates.rotational
    actuated = coordinates.columns(mechanism.spec.actuated)
    others = (name for name in coordinates.names if name not in mechanism.spec.actuated)
    passive = coordinates.columns(mechanism.spec.passive or others)
    powers = tuple(RADIAN if turns else METRE for turns in rotational)
    return tuple(powers[k] for k in actuated), tuple(powers[k] for k in passive)


def row_powers(loops: Iterable[Loop]) -> tuple[Powers, ...]:
    """Return the unit of each of the p loop equations."""
    return tuple(power for loop in loops for power in _loop_powers(loop))


def rate_unit(powers: Powers) -> str:
    """Return the unit of a rate: m/s or rad/s."""
    return f"{unit(powers)}/s"


def metric_unit(twist: Powers, joint: Powers) -> str:
    """Return the unit of a row of g: (twist unit)²/(rate unit), the column's still to come."""
    if twist == joint:
        return rate_unit(twist)
    return f"{unit(twist)}²/({unit(joint)} s)"


def unit(powers: Powers) -> str:
    """Write a unit.

    Examples
    --------
    >>> unit((6, -3)), unit((1, 0)), unit((0, 0)), unit((0, -1))
    ('m⁶/rad³', 'm', '1', '1/rad')
    """
    named = list(zip(("m", "rad"), powers, strict=True))
    above = " ".join(_power(name, power) for name, power in named if power > 0)
    below = " ".join(_power(name, -power) for name, power in named if power < 0)
    below = f"({below})" if " " in below else below
    return f"{above or '1'}/{below}" if below else above or "1"


def quotient(rows: Iterable[Powers], columns: Iterable[Powers]) -> Powers:
    """Return the unit of the product of the rows' units over the product of the columns'."""
    above, below = list(rows), list(columns)
    metre, radian = (
        sum(powers[k] for powers in above) - sum(powers[k] for powers in below) for k in (0, 1)
    )
    return metre, radian


def common_unit(rows: Iterable[Powers], columns: Iterable[Powers]) -> str | None:
    """Return the unit that all entries share, None where they do not."""
    above, below = set(rows), set(columns)
    if len(above) != 1 or len(below) != 1:
        return None
    return unit(quotient(above, below))


def _loop_powers(loop: Loop) -> tuple[Powers, ...]:
    match loop:
        case PointLoop():
            return (METRE, METRE, METRE)
        case DistanceLoop():
            return (SQUARE_METRE,)
    assert_never(loop)


def _power(name: str, power: int) -> str:
    return name if power == 1 else name + str(power).translate(_SUPERSCRIPTS)
