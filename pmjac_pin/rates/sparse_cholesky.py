"""Positive definite equations over recorded numbers, in an order that is chosen once.

What is zero at every pose takes no part. Nothing is decided at a pose: there are no pivots, which a
matrix that is positive definite enough, by its damping, does not need.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

UpperPlace = tuple[int, int]  #: A row and a column of the upper triangle.


@dataclass(frozen=True, slots=True, eq=False)
class Elimination:
    """The order in which unknowns are eliminated: next the one that is tied to the fewest others.

    Attributes
    ----------
    order : tuple of int
    tied : tuple of tuple of int
        To each unknown of the order, those of the later ones that it is tied to.

    Examples
    --------
    >>> arrow = Elimination.of([(0, 0), (1, 1), (2, 2), (0, 1), (0, 2)])
    >>> arrow.order, arrow.products
    ((1, 0, 2), 2)
    """

    order: tuple[int, ...]
    tied: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, places: Iterable[UpperPlace]) -> Elimination:
        """Return that of a matrix whose entries are at some places, all of the diagonal's too."""
        ties: dict[int, set[int]] = {}
        for one, other in places:
            ties.setdefault(one, set()).add(other)
            ties.setdefault(other, set()).add(one)
        for unknown, others in ties.items():
            others.discard(unknown)
        order: list[int] = []
        tied: list[tuple[int, ...]] = []
        while ties:
            pivot = min(ties, key=lambda unknown: (len(ties[unknown]), unknown))
            others = ties.pop(pivot)
            for one in others:
                ties[one] |= others
                ties[one] -= {one, pivot}
            order.append(pivot)
            tied.append(tuple(sorted(others)))
        return cls(tuple(order), tuple(tied))

    @property
    def products(self) -> int:
        """How many the elimination takes."""
        return sum(len(others) * (len(others) + 1) // 2 for others in self.tied)

    def solve(self, matrix: Mapping[UpperPlace, Any], right: Sequence[Any]) -> list[Any]:
        """Return x of A x = b, A given by its upper triangle."""
        left, sides = dict(matrix), list(right)
        inverses: dict[int, Any] = {}
        for pivot, others in zip(self.order, self.tied, strict=True):
            inverse = inverses[pivot] = 1.0 / left[pivot, pivot]
            for place, one in enumerate(others):
                factor = left[_upper(pivot, one)] * inverse
                for other in others[place:]:
                    product = factor * left[_upper(pivot, other)]
                    left[one, other] = left.get((one, other), 0.0) - product
                sides[one] = sides[one] - factor * sides[pivot]
        for pivot, others in zip(reversed(self.order), reversed(self.tied), strict=True):
            total = sides[pivot]
            for other in others:
                total = total - left[_upper(pivot, other)] * sides[other]
            sides[pivot] = total * inverses[pivot]
        return sides


def _upper(one: int, other: int) -> UpperPlace:
    return (one, other) if one < other else (other, one)
