"""What is shown, before it is drawn: headings, paragraphs and tables of text."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from pmjac_pin.words.labelled import SHOWN_AS_ZERO, LabelledMatrix


@dataclass(frozen=True, slots=True)
class Heading:
    """The title of a part."""

    text: str


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Running text."""

    text: str


@dataclass(frozen=True, slots=True)
class Verbatim:
    """A line that is never wrapped or rewritten: a path."""

    text: str


@dataclass(frozen=True, slots=True)
class Table:
    """A table of text.

    Attributes
    ----------
    title : str
    header : tuple of str
        One for each column; may hold several lines.
    rows : tuple of tuple of str
    align : str
        "<" or ">" for each column: words to the left, numbers to the right.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    align: str


Block: TypeAlias = Heading | Paragraph | Verbatim | Table


def matrix_table(title: str, matrix: LabelledMatrix) -> Table:
    """Show a matrix: its name, its size, and a unit at every row and column."""
    header = [f"{name}\n[{u}]" for name, u in zip(matrix.columns, matrix.column_units, strict=True)]
    labels = [f"{name} [{u}]" for name, u in zip(matrix.rows, matrix.row_units, strict=True)]
    rows = zip(labels, matrix_numbers(matrix.values, matrix.size), strict=True)
    return Table(
        title,
        ("", *header),
        tuple((label, *entries) for label, entries in rows),
        "<" + ">" * len(header),
    )


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
    return [[_number(x, largest, rounding) for x in row] for row in rows]


def number(value: float) -> str:
    """Write one number as `matrix_numbers` does."""
    return matrix_numbers([[value]])[0][0]


def _number(value: float, largest: float, rounding: float) -> str:
    if not math.isfinite(value):
        return "∞" if value > 0 else "-∞" if value < 0 else "nan"
    if abs(value) <= rounding:
        value = 0.0
    plain = largest == 0.0 or 1e-2 <= largest < 1e5
    too_small = 0.0 < abs(value) < 5e-5
    return f"{value:.4f}" if plain and not too_small else f"{value:.3e}" if value else "0"
