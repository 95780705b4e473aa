"""Least squares by Householder reflections in an order that is chosen once, over recorded numbers.

Numbers that are the double 0 are zero at every pose and take no part. Nothing is decided at a pose
but signs, so that the whole is straight-line code; where that fails, its numbers are not finite.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.programs import Term, root, with_sign
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
        reduced = matrix.copy()
        waiting, left = list(range(count)), list(range(len(matrix)))
        columns: list[int] = []
        rows: list[int] = []
        filled = np.not_equal(reduced, 0.0).astype(bool)
        while waiting:
            column = min(waiting, key=lambda c: (_work(filled[left], c), c))
            used = [row for row in left if filled[row, column]]
            used.sort(key=lambda row: int(filled[row].sum()))
            others = [c for c in range(matrix.shape[1]) if c != column and c not in columns]
            _reflect(reduced, used, column, others)
            filled[used] = filled[used].any(axis=0)
            filled[used[1:], column] = False
            left.remove(used[0])
            waiting.remove(column)
            columns.append(column)
            rows.append(used[0])
        return cls(reduced, tuple(columns), tuple(rows))

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
        found = np.empty((count, len(right)), dtype=object)
        for step in reversed(range(count)):
            row, inverse = self.rows[step], self._inverse(step)
            for k, column in enumerate(right):
                total = self.matrix[row, column]
                for later in range(step + 1, count):
                    total = total - self.matrix[row, self.columns[later]] * found[later, k]
                found[step, k] = total * inverse
        return found[np.argsort(self.columns)]

    def inverse_norm(self) -> Any:
        """Return ‖R⁻¹‖ by Frobenius: the smallest singular value of A is at least its inverse."""
        count = len(self.columns)
        inverses = np.zeros((count, count), dtype=object)
        for step in reversed(range(count)):
            row, inverse = self.rows[step], self._inverse(step)
            inverses[step, step] = inverse
            for column in range(step + 1, count):
                entry: Any = 0.0
                for later in range(step + 1, column + 1):
                    known = inverses[later, column]
                    entry = entry - self.matrix[row, self.columns[later]] * known
                inverses[step, column] = entry * inverse
        return norm(inverses)

    def _inverse(self, step: int) -> Any:
        return 1.0 / self.matrix[self.rows[step], self.columns[step]]


def norm(entries: Numbers) -> Any:
    """Return the Frobenius norm."""
    return root(dot(entries.ravel(), entries.ravel()))


def dot(u: Sequence[Any] | Numbers, v: Sequence[Any] | Numbers) -> Any:
    """Return Σ uₖ vₖ."""
    total: Any = 0.0
    for a, b in zip(u, v, strict=True):
        total = total + a * b
    return total


def _work(filled: Mask, column: int) -> int:
    """Return how many entries a reflection would change; very many where it could not be made."""
    rows = filled[filled[:, column]]
    return (len(rows) - 1) * int(rows.any(axis=0).sum()) if len(rows) else filled.size


def _reflect(matrix: Numbers, rows: Sequence[int], column: int, others: Sequence[int]) -> None:
    """Reflect so that of a column only the entry in the first of these rows is left."""
    if len(rows) == 1:
        return
    normal = matrix[rows, column]
    size = norm(normal)
    end = -with_sign(size, normal[0])
    normal[0] = normal[0] - end
    factor = 1.0 / (end * normal[0])
    for other in others:
        entries = matrix[rows, other]
        if any(isinstance(x, Term) or x != 0.0 for x in entries):
            along = dot(normal, entries) * factor
            matrix[rows, other] = [x + along * a for x, a in zip(entries, normal, strict=True)]
    matrix[rows, column] = 0.0
    matrix[rows[0], column] = end
