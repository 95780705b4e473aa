"""Numbers as they are written in tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

#: An entry up to this share of the size of its matrix is rounding, and shown as zero.
SHOWN_AS_ZERO = 1e-13


def matrix_numbers(matrix: Iterable[Sequence[float]], size: float = 0.0) -> list[list[str]]:
    """Write the entries of a matrix alike: four decimals, as the lecture prints them.

    With an exponent where four decimals would not show an entry, and throughout where the
    largest is very large or very small. Rounding beside `size`, or beside the largest, is 0.

    Examples
    --------
    >>> matrix_numbers([[0.5, -2.0], [1e-5, 1e-17]])
    [['0.5000', '-2.0000'], ['1.000e-05', '0.0000']]
    >>> matrix_numbers([[1e-17, -2e-16]], size=1.0)
    [['0.0000', '0.0000']]
    """
    rows = [list(row) for row in matrix]
    largest = max((abs(x) for row in rows for x in row if math.isfinite(x)), default=0.0)
    rounding = SHOWN_AS_ZERO * max(largest, size)
    if largest <= rounding:
        largest = 0.0
    return [[_digits(x, largest, rounding) for x in row] for row in rows]


def number(value: float) -> str:
    """Write one number as `matrix_numbers` does."""
    return matrix_numbers([[value]])[0][0]


def _digits(value: float, largest: float, rounding: float) -> str:
    if not math.isfinite(value):
        return "∞" if value > 0 else "-∞" if value < 0 else "nan"
    if abs(value) <= rounding:
        value = 0.0
    plain = largest == 0.0 or 1e-2 <= largest < 1e5
    too_small = 0.0 < abs(value) < 5e-5
    return f"{value:.4f}" if plain and not too_small else f"{value:.3e}" if value else "0"
