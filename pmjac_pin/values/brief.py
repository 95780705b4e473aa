"""Numbers in words, as short as they may be."""

from __future__ import annotations

import math
from collections.abc import Iterable
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal


def brief(value: float) -> str:
    """Write a number whose size alone matters: a residual, a tolerance."""
    return "∞" if value == math.inf else f"{value:.3g}"


def with_names(names: Iterable[str], values: Iterable[float]) -> str:
    """Write numbers by their names.

    Examples
    --------
    >>> with_names(["pitch", "roll"], [0.25, -1.0 / 3.0])
    'pitch=0.25, roll=-0.333333'
    """
    return ", ".join(f"{name}={value:.6g}" for name, value in zip(names, values, strict=True))


def at_most(value: float, digits: int = 2) -> str:
    """Write a bound from above with so many digits: rounded up.

    Examples
    --------
    >>> at_most(9.141e-05), at_most(-3.046, 3), at_most(math.inf)
    ('9.2e-05', '-3.04', '∞')
    """
    return _towards(value, digits, ROUND_CEILING)


def at_least(value: float, digits: int = 2) -> str:
    """Write a bound from below: rounded down."""
    return _towards(value, digits, ROUND_FLOOR)


def _towards(value: float, digits: int, rounding: str) -> str:
    if not math.isfinite(value):
        return f"{value}".replace("inf", "∞")
    rounded = Context(prec=digits, rounding=rounding).plus(Decimal(value))
    return f"{float(rounded):.{digits}g}"
