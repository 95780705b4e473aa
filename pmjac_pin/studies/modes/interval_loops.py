"""The loop equations over boxes of joint values: rows and their derivatives, enclosed.

Tilts and turns are polynomials, which vanish at half a turn as well; a separate condition excludes
that. No row is larger than the one with roots, so a closed pose keeps its tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pmjac_pin.algebra import Number
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.jets import Jet
from pmjac_pin.kinematics.loops import Pair, riding
from pmjac_pin.kinematics.tree import Poses
from pmjac_pin.model.frames import Frame
from pmjac_pin.model.joint_kind import Waves
from pmjac_pin.model.rows import Distance, Gap, Rows
from pmjac_pin.studies.modes.box_equations import Cuts, Enclosed
from pmjac_pin.studies.modes.interval_tree import IntervalTree
from pmjac_pin.studies.modes.narrowing import narrowed
from pmjac_pin.values.arrays import Array


class Between(Waves, Protocol):
    """A number type over boxes: it has intervals among its numbers."""

    def between(self, ends: Intervals) -> Number:
        """Return intervals as numbers, their axes the components."""
        ...


class BoxRows(Protocol):
    """Some rows of the equations.

    Attributes
    ----------
    names : tuple of str
    tolerance : tuple of float
        How far each row can be from 0 at a pose that counts as closed.
    spans : tuple of (Frame, Frame, float)
        How far apart, m, the origins of two frames are at most where the rows vanish.
    """

    @property
    def names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def tolerance(self) -> tuple[float, ...]: ...  # noqa: D102
    @property
    def spans(self) -> tuple[tuple[Frame, Frame, float], ...]: ...  # noqa: D102

    def __call__(self, poses: Poses) -> tuple[list[Jet], list[Number]]:
        """Return the rows, in blocks, and cosines, each positive wherever they are meant."""
        ...


class IntervalLoops:
    """All equations of a mechanism over boxes (b, k) of its unknowns.

    Attributes
    ----------
    tree : IntervalTree
    places : mapping of int to int
        Which unknown each column of v is.
    names : tuple of str
        Of the p rows.
    tolerance : ndarray, shape (p,)
        How far each row can be from 0 at a pose that counts as closed.
    """

    __slots__ = ("_rows", "names", "places", "tolerance", "tree")

    def __init__(self, tree: IntervalTree, rows: Sequence[BoxRows]) -> None:
        self.tree, self._rows = tree, rows
        self.places = {column: place for place, column in enumerate(tree.columns)}
        self.names = tuple(name for block in rows for name in block.names)
        self.tolerance = np.array([size for block in rows for size in block.tolerance])

    def evaluate(self, box: Intervals) -> Enclosed:
        """Return all rows and their derivatives by all unknowns."""
        return self._evaluate(box, True)

    def residual(self, box: Intervals) -> Intervals:
        """Return all rows, shape (b, p)."""
        return self._evaluate(box, False).residual

    def narrowed(self, box: Intervals, scale: Array, progress: float) -> tuple[Intervals, Cuts]:
        """Return boxes narrowed, and what becomes of each."""
        return narrowed(self, box, scale, progress)

    def at(self, poses: Poses) -> tuple[list[Jet], list[Number]]:
        """Return all rows, in blocks, and cosines, each positive wherever they are meant."""
        blocks: list[Jet] = []
        cosines: list[Number] = []
        for part in self._rows:
            more, others = part(poses)
            blocks += more
            cosines += others
        return blocks, cosines

    def _evaluate(self, box: Intervals, rates: bool) -> Enclosed:
        blocks, cosines = self.at(self.tree.poses(box, rates))
        count, unknowns = len(box.lower), len(self.places) if rates else 0
        ends = [
            (np.empty((n, count)), np.zeros((n, unknowns, count))) for n in 2 * [len(self.names)]
        ]
        possible, start = np.ones(count, dtype=bool), 0
        for block in blocks:
            where = slice(start, start + block.value.shape[0])
            start = where.stop
            self._put(block, where, ends)
        for cosine in cosines:  # what is not a number excludes nothing
            possible &= ~(cosine.upper[0] <= 0.0)
        (lower, low), (upper, high) = ends
        return Enclosed(
            Intervals(lower.T.copy(), upper.T.copy()),
            Intervals(low.transpose(2, 0, 1).copy(), high.transpose(2, 0, 1).copy()),
            possible,
        )

    def _put(self, block: Jet, rows: slice, ends: Sequence[tuple[Array, Array]]) -> None:
        """Write a block of rows into the lower and the upper ends of all."""
        places = [self.places[column] for column in block.columns]
        for (residual, jacobian), side in zip(ends, ("lower", "upper"), strict=True):
            residual[rows] = getattr(block.value, side)[:, 0]
            if places:
                jacobian[rows, places] = getattr(block.rates, side)


@dataclass(frozen=True, slots=True, eq=False)
class PairRows:
    """The rows of a loop between two frames."""

    pair: Pair
    names: tuple[str, ...]
    tolerance: tuple[float, ...]

    @property
    def spans(self) -> tuple[tuple[Frame, Frame, float], ...]:
        """A coincident pair is no further apart than its tolerance, a rod's ends than the rod."""
        found = []
        for rows, block in self.pair.blocks:
            size = sum(self.tolerance[rows])
            if isinstance(block, Gap):
                found.append((self.pair.first, self.pair.second, 2.0 * size))
            elif isinstance(block, Distance):
                apart = block.length + size / block.length
                found.append((self.pair.first, self.pair.second, apart))
        return tuple(found)

    def __call__(self, poses: Poses) -> tuple[list[Jet], list[Number]]:
        """Return the loop's rows."""
        blocks = riding(self.pair, poses)
        cosines = [block.cosine.value for block in blocks if block.cosine is not None]
        return [block.rows for block in blocks], cosines


def tolerances(block: Rows, closed: float, length: float) -> tuple[float, ...]:
    """Return how far a block's rows can be from 0 where the loops gape by `closed` m at most.

    Parameters
    ----------
    block : Rows
    closed : float
        m
    length : float
        The mechanism's characteristic length, m: a rad counts as that.
    """
    if isinstance(block, Distance):
        return (2.0 * block.length * closed,)
    size = closed / length if block.unit == "rad" else closed
    return (size,) * len(block.names)
