"""LabelledMatrix: a matrix with names and units, for tables, data frames and papers."""

from __future__ import annotations

import re
from typing import Any

import msgspec
import numpy as np

from pmjac_pin.errors import MissingDependencyError
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.shown import Printed
from pmjac_pin.words.blocks import Table
from pmjac_pin.words.markdown import markdown_table
from pmjac_pin.words.numbers import matrix_numbers

_LATEX = {"v": "v", "ω": r"\omega"}  # the letters of twists


class LabelledMatrix(Printed, msgspec.Struct, frozen=True):
    """A matrix with its labels; the unit of an entry is its row's unit over its column's.

    It prints, and in a notebook shows, as a table.

    Attributes
    ----------
    rows, columns : tuple of str
        Names.
    row_units, column_units : tuple of str
    values : tuple of tuple of float
        Row by row.
    size : float
        What an entry is compared with: up to 1e-13 (`SHOWN_AS_ZERO`) of it is rounding. The largest
        entry or, in J_eq = J − J* K*⁻¹ K, the size of what cancels.
    """

    rows: tuple[str, ...]
    row_units: tuple[str, ...]
    columns: tuple[str, ...]
    column_units: tuple[str, ...]
    values: tuple[tuple[float, ...], ...]
    size: float

    def block(self, title: str = "") -> Table:
        """Return it as a table of text: a unit at every row and column."""
        columns = zip(self.columns, self.column_units, strict=True)
        rows = zip(self._row_labels(), matrix_numbers(self.values, self.size), strict=True)
        return Table(
            title,
            ("", *(f"{name}\n[{unit}]" for name, unit in columns)),
            tuple((label, *entries) for label, entries in rows),
            "<" + ">" * len(self.columns),
        )

    def dataframe(self) -> Any:
        """Return it as a pandas DataFrame of all digits.

        Raises
        ------
        MissingDependencyError
            pandas is not installed.

        Examples
        --------
        >>> table = labelled(np.eye(1), ("v_x",), ("m/s",), ("l1",), ("m/s",))
        >>> table.dataframe().loc["v_x [m/s]", "l1 [m/s]"].item()
        1.0
        """
        try:
            from pandas import DataFrame  # noqa: PLC0415
        except ImportError as error:
            needed = f"a DataFrame needs pandas: pip install 'pmjac_pin[table]' ({error})"
            raise MissingDependencyError(needed) from error
        columns = zip(self.columns, self.column_units, strict=True)
        labels = [f"{name} [{unit}]" for name, unit in columns]
        return DataFrame(self.values, index=self._row_labels(), columns=labels)

    def markdown(self) -> str:
        """Return it as a table in GitHub's Markdown."""
        return markdown_table(self.block())

    def latex(self) -> str:
        r"""Return it as LaTeX, for formulas: four decimals, names at the rows and columns.

        Examples
        --------
        >>> print(labelled(np.eye(1), ("v_x",), ("m/s",), ("theta_1",), ("rad/s",)).latex())
        \begin{array}{r|r}
         & \text{theta\_1} \\ \hline
        v_{x} & 1.0000
        \end{array}
        """
        head = " & ".join(["", *map(_in_latex, self.columns)])
        numbers = matrix_numbers(self.values, self.size)
        rows = [
            " & ".join([_in_latex(name), *map(_power_of_ten, entries)])
            for name, entries in zip(self.rows, numbers, strict=True)
        ]
        inside = " \\\\\n".join([f"{head} \\\\ \\hline", *rows]).replace("\\hline \\\\", "\\hline")
        return f"\\begin{{array}}{{r|{'r' * len(self.columns)}}}\n{inside}\n\\end{{array}}"

    def _row_labels(self) -> list[str]:
        return [f"{name} [{unit}]" for name, unit in zip(self.rows, self.row_units, strict=True)]


def labelled(
    values: Array,
    rows: tuple[str, ...],
    row_units: tuple[str, ...],
    columns: tuple[str, ...],
    column_units: tuple[str, ...],
    *,
    size: float = 0.0,
) -> LabelledMatrix:
    """Put labels on an array, shape (len(rows), len(columns)), of at least this size."""
    entries = tuple(tuple(map(float, row)) for row in values)
    size = float(np.abs(values).max(initial=size))
    return LabelledMatrix(rows, row_units, columns, column_units, entries, size)


def stacked(first: LabelledMatrix, second: LabelledMatrix) -> LabelledMatrix:
    """Return two matrices of the same columns as one; their rows may have units of their own."""
    return LabelledMatrix(
        (*first.rows, *second.rows),
        (*first.row_units, *second.row_units),
        first.columns,
        first.column_units,
        (*first.values, *second.values),
        max(first.size, second.size),
    )


def _in_latex(name: str) -> str:
    """Write a component of a twist as a letter with an index, other names as text."""
    if found := re.fullmatch(r"([vω])_([xyz])", name):
        return f"{_LATEX[found[1]]}_{{{found[2]}}}"
    escaped = re.sub(r"([#$%&_{}])", r"\\\1", name)
    return rf"\text{{{escaped}}}"


def _power_of_ten(number: str) -> str:
    mantissa, e, exponent = number.partition("e")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if e else number.replace("∞", r"\infty")
