"""Least squares by Householder reflections in an order that is chosen once, over recorded numbers.

Numbers that are the double 0 are zero at every pose and take no part. Nothing is decided at a pose
but signs, so that the whole is straight-line code; where that fails, its numbers are not finite.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.programs import root, with_sign, zeros
from pmjac_pin.algebra.terms import Term
from pmjac_pin.values.arrays import Mask


@dataclass(frozen=True, slots=True, eq=False)
class Triangle:
    """Q A = R on some columns of A, and Q on all.

    Attributes
    ----------
    matrix : ndarray, shape (p, k)
        Q times the columns of A, R among them.
    columns : tuple of int
        Those of R, in the order in which they were reduced.
    rows : tuple of int
        The row that each of them ends in.
    """

    matrix: Numbers
    columns: tuple[int, ...]
    rows: tuple[int, ...]

    @classmethod
    def of(cls, matrix: Numbers, count: int) -> Triangle:
        """Reduce the first columns, those first that take the fewest operations."""
        reduced: list[list[Any]] = matrix.tolist()
        waiting, left = list(range(count)), list(range(len(reduced)))
        columns: list[int] = []
        rows: list[int] = []
        filled = np.not_equal(matrix, 0.0).astype(bool)
        while waiting:
            column = _quickest(filled[left], waiting)
            used = [row for row in left if filled[row, column]]
            used.sort(key=lambda row: int(filled[row].sum()))
            others = [c for c in range(matrix.shape[1]) if c != column and c not in columns]
            _reflect([reduced[row] for row in used], column, others)
            filled[used] = filled[used].any(axis=0)
            filled[used[1:], column] = False
            left.remove(used[0])
            waiting.remove(column)
            columns.append(column)
            rows.append(used[0])
        return cls(
            np.array(reduced, dtype=object).reshape(matrix.shape), tuple(columns), tuple(rows)
        )

    @property
    def left_over(self) -> list[int]:
        """The rows in which none of the columns ends: what they hold cannot be solved for."""
        return [row for row in range(len(self.matrix)) if row not in self.rows]

    def triangle(self) -> Numbers:
        """Return R, square: its singular values are those of A."""
        triangle: Numbers = self.matrix[np.ix_(self.rows, self.columns)]
        return triangle

    def solve(self, right: Sequence[int]) -> Numbers:
        """Return X with R X = B, for columns B of the matrix; rows in the columns' own order."""
        count = len(self.columns)
        found = zeros(count, len(right)).tolist()
        for step, inverse, later in self._from_below():
            row = self.matrix[self.rows[step]].tolist()
            for k, column in enumerate(right):
                total = row[column]
                for entry, other in later:
                    total = total - entry * found[other][k]
                found[step][k] = total * inverse
        solved = np.array(found, dtype=object).reshape(count, len(right))
        return solved[np.argsort(self.columns)]

    def inverse_norm(self) -> Any:
        """Return ‖R⁻¹‖ by Frobenius: the smallest singular value of A is at least its inverse."""
        count = len(self.columns)
        inverses = zeros(count, count).tolist()
        for step, inverse, later in self._from_below():
            inverses[step][step] = inverse
            for column in range(step + 1, count):
                entry: Any = 0.0
                for known, other in later:
                    if other <= column:
                        entry = entry - known * inverses[other][column]
                inverses[step][column] = entry * inverse
        return norm(np.array(inverses, dtype=object))

    def _from_below(self) -> Iterator[tuple[int, Any, list[tuple[Any, int]]]]:
        """Yield steps, the last first: the diagonal's inverse, and what of R is behind it."""
        triangle = self.triangle().tolist()
        for step in reversed(range(len(self.columns))):
            row = triangle[step]
            later = [(x, k) for k, x in enumerate(row) if k > step and _takes_part(x)]
            yield step, 1.0 / row[step], later


def norm(entries: Numbers) -> Any:
    """Return the Frobenius norm."""
    known = [x for x in entries.ravel().tolist() if _takes_part(x)]
    return root(dot(known, known))


def dot(u: Iterable[Any], v: Iterable[Any]) -> Any:
    """Return Σ uₖ vₖ."""
    total: Any = 0.0
    for a, b in zip(u, v, strict=True):
        total = total + a * b
    return total


def _takes_part(x: Any) -> bool:
    return isinstance(x, Term) or x != 0.0


def _quickest(filled: Mask, columns: Sequence[int]) -> int:
    """Return the column of which a reflection takes the fewest operations."""
    return min(columns, key=lambda column: (_work(filled, column), column))


def _work(filled: Mask, column: int) -> int:
    """Return how many entries a reflection would change; very many where it could not be made."""
    rows = filled[filled[:, column]]
    return (len(rows) - 1) * int(rows.any(axis=0).sum()) if len(rows) else filled.size


def _reflect(rows: Sequence[list[Any]], column: int, others: Sequence[int]) -> None:
    """Reflect so that of a column only the entry in the first of these rows is left."""
    if len(rows) == 1:
        return
    normal = [row[column] for row in rows]
    size = root(dot(normal, normal))
    end = -with_sign(size, normal[0])
    normal[0] = normal[0] - end
    factor = 1.0 / (end * normal[0])
    for other in others:
        entries = [row[other] for row in rows]
        if any(_takes_part(x) for x in entries):
            along = dot(normal, entries) * factor
            for row, x, a in zip(rows, entries, normal, strict=True):
                row[other] = x + along * a
    for row in rows:
        row[column] = 0.0
    rows[0][column] = end
