"""Names and units for the rows and columns of the lecture's matrices.

A unit is kept as its powers of metre and radian, (1, 0) for m and (2, -1) for m²/rad, so that
units of quotients and of determinants follow by adding and subtracting.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

Powers: TypeAlias = tuple[int, int]

METRE: Powers = (1, 0)
SQUARE_METRE: Powers = (2, 0)
RADIAN: Powers = (0, 1)

_POWERS = {"m": METRE, "m²": SQUARE_METRE, "rad": RADIAN}

_FORCES = {METRE: "N", RADIAN: "N m", SQUARE_METRE: "N/m"}

LINEAR = ("v_x", "v_y", "v_z")
ANGULAR = ("ω_x", "ω_y", "ω_z")

_SUPERSCRIPTS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def powers_of(units: Iterable[str]) -> tuple[Powers, ...]:
    """Return the powers of units: of "m", "rad" or "m²"."""
    return tuple(_POWERS[unit] for unit in units)


def rate_unit(powers: Powers) -> str:
    """Return the unit of a rate: m/s or rad/s."""
    return f"{unit(powers)}/s"


def force_unit(powers: Powers) -> str:
    """Return the unit of the force that does work on such a displacement: N on m, N m on rad.

    Examples
    --------
    >>> force_unit(METRE), force_unit(RADIAN), force_unit(SQUARE_METRE)
    ('N', 'N m', 'N/m')
    """
    return _FORCES[powers]


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


def _power(name: str, power: int) -> str:
    return name if power == 1 else name + str(power).translate(_SUPERSCRIPTS)
