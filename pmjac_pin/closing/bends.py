"""Bends: how far the loop equations and their rates can bend along a motion, from arms alone.

Let the joints move along x(s), 0 ≤ s ≤ 1, with |xᵢ⁽ᵐ⁾| ≤ wᵢₘ. Then the m-th derivative of a product
of turns R₁⋯Rₖ is at most m! times the coefficient of sᵐ in the power series

    Eₖ(s) = exp(Σᵢ (wᵢ₁ s + wᵢ₂ s²/2 + wᵢ₃ s³/6)):

for one turn because all derivatives of the exponential are at most 1, whether of an angle or of a
ball's rotation vector X: Dᵐ(exp X)[H, ..., H] is m! times an integral over a simplex of volume
1/m! of products of rotations and m factors H. For their product by Leibniz' rule. In the same way
that of a segment R₁⋯Rₖ dₖ is bounded by Pₖ = Eₖ·(|dₖ| + the series of the slides in dₖ). What a
joint that turns moves is the sum over the segments that it turns; a slide moves by the turns
before it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from pmjac_pin.closing.arms import Arms
from pmjac_pin.values.arrays import Array, Index

_LENGTH_ROUNDING = 1e-15  # of the segments of a loop together


class MotionSeries(NamedTuple):
    """Coefficients of power series along a motion, the first for s⁰, each (segments,).

    Attributes
    ----------
    turns, arms : list of ndarray
        E and P of each segment.
    """

    turns: list[Array]
    arms: list[Array]


class Bends:
    """Bounds on derivatives of the loop equations along motions, no rows or columns scaled.

    Parameters
    ----------
    arms : Arms
    root : callable, optional
        The square root of arrays: numbers may also be recorded ones (`algebra.programs`).

    Attributes
    ----------
    off_closure : ndarray, shape (p, nv)
        1 where ∂η/∂v as evaluated off closure differs from what is bounded here, by at most the
        norm of the block's η (`block_norms`).
    """

    __slots__ = (
        "_above", "_blocks", "_distances", "_inside", "_lengths", "_lies", "_members", "_of_row",
        "_ones", "_rods", "_root", "_slid", "_slides", "_sums", "_turned", "_values", "off_closure",
    )  # fmt: skip

    def __init__(self, arms: Arms, root: Callable[[Any], Any] = np.sqrt) -> None:
        self._root = root
        segments = [segment for block in arms.blocks for segment in block.segments]
        count, blocks = len(arms.rates), np.arange(len(arms.blocks))
        self._members, self._values = arms.rates.T**2, arms.values.T**2
        self._above = _marks([segment.turns for segment in segments], count)
        self._inside = _marks([segment.slides for segment in segments], count)
        self._lies = _marks([segment.lies for segment in segments], count)
        self._lengths = np.array([segment.length for segment in segments])
        self._turned, self._slid = self._above @ arms.rates, self._inside @ arms.rates
        self._slides = bool(self._slid.any() or self._lies.any())
        self._ones = np.ones(len(segments))
        owners = np.repeat(blocks, [len(block.segments) for block in arms.blocks])
        self._sums = (owners == blocks[:, None]).astype(float)
        self._of_row = np.repeat(blocks, [block.rows for block in arms.blocks])
        self._blocks = (self._of_row == blocks[:, None]).astype(float)
        rods = np.array([block.rod for block in arms.blocks])
        self._distances = np.flatnonzero(rods)
        self._rods = rods[self._distances]
        inexact = np.array([not block.exact for block in arms.blocks], dtype=bool)
        moved = (self._sums @ self._turned > 0.0) & inexact[:, None]
        self.off_closure = moved[self._of_row].astype(float)

    def speeds(self, rates: Array) -> Array:
        """Return the norms of rates (..., nv) in each group, shape (..., groups)."""
        norms: Array = self._root((rates * rates).dot(self._members))
        return norms

    def block_norms(self, residual: Array) -> Array:
        """Return for each row the norm of its block's residual, shape (p,)."""
        norms: Array = np.sqrt(self._blocks.dot(residual * residual))[self._of_row]
        return norms

    def motion(self, q: Array, speeds: Array) -> MotionSeries:
        """Return the series along a motion from q.

        Parameters
        ----------
        q : ndarray, shape (nq,)
        speeds : ndarray, shape (3, groups)
            The largest first, second and third derivative of each group.
        """
        a1, a2, a3 = speeds.dot(self._above.T)
        d1, d2, d3 = speeds.dot(self._inside.T)
        a2, a3, d2, d3 = a2 / 2.0, a3 / 6.0, d2 / 2.0, d3 / 6.0
        square = a1 * a1
        e2, e3 = square / 2.0 + a2, square * a1 / 6.0 + a1 * a2 + a3
        e4 = square * square / 24.0 + square * a2 / 2.0 + a2 * a2 / 2.0 + a1 * a3
        length = self._lengths + self._root((q * q).dot(self._values)).dot(self._lies.T) + d1
        arms = [
            length,
            a1 * length + d1,
            e2 * length + a1 * d1 + d2,
            e3 * length + e2 * d1 + a1 * d2 + d3,
            e4 * length + e3 * d1 + e2 * d2 + a1 * d3,
        ]
        return MotionSeries([np.ones_like(a1), a1, e2, e3, e4], arms)

    def straight(self, q: Array, speeds: Array) -> MotionSeries:
        """Return the series, up to s², along a motion of constant rates: speeds (groups,)."""
        turn, length = self._above.dot(speeds), self._lengths
        square = 0.5 * turn * turn
        if not self._slides:
            return MotionSeries(
                [self._ones, turn, square], [length, turn * length, square * length]
            )
        slide = self._inside.dot(speeds)
        length = length + self._lies.dot(self._root((q * q).dot(self._values))) + slide
        arms = [length, turn * length + slide, square * length + turn * slide]
        return MotionSeries([self._ones, turn, square], arms)

    def bending(self, motion: MotionSeries) -> tuple[Array, Array]:
        """Return bounds on the second derivatives of η and ∂η/∂v, shapes (p,) and (p, nv)."""
        residual, rates = self._sums.dot(motion.arms[2]), self._rates(motion, 2)
        if self._rods.size:
            block = self._distances
            g1, g2 = (self._gaps(arm) for arm in motion.arms[1:3])
            c0, c1 = (self._rates(motion, order, block) for order in range(2))
            length = self._rods + g1
            residual[block] = 2.0 * length * g2 + g1 * g1
            product = length[:, None] * rates[block] + g1[:, None] * c1 + g2[:, None] * c0
            rates[block] = 2.0 * product
        return self._by_row(2.0 * residual), self._by_row(2.0 * rates)

    def residual(self, motion: MotionSeries) -> Array:
        """Return a bound on the fourth derivative of η, shape (p,)."""
        bound = 24.0 * self._sums.dot(motion.arms[4])
        if self._rods.size:
            g1, g2, g3, g4 = (self._gaps(arm) for arm in motion.arms[1:])
            square = 2.0 * (self._rods + g1) * g4 + 2.0 * g1 * g3 + g2 * g2
            bound[self._distances] = 24.0 * square
        return self._by_row(bound)

    def rounding(self, motion: MotionSeries) -> Array:
        """Return how far η as evaluated may be off, shape (p,): a few units in the last place."""
        bound = _LENGTH_ROUNDING * self._sums.dot(motion.arms[0])
        if self._rods.size:
            bound[self._distances] *= 2.0 * self._rods
        return self._by_row(bound)

    def rates(self, motion: MotionSeries) -> Array:
        """Return a bound on the third derivative of ∂η/∂v, shape (p, nv)."""
        bound = 6.0 * self._rates(motion, 3)
        if self._rods.size:
            g1, g2, g3 = (self._gaps(arm)[:, None] for arm in motion.arms[1:4])
            c0, c1, c2 = (self._rates(motion, order, self._distances) for order in range(3))
            c3 = bound[self._distances] / 6.0
            product = (self._rods[:, None] + g1) * c3 + g1 * c2 + g2 * c1 + g3 * c0
            bound[self._distances] = 12.0 * product
        return self._by_row(bound)

    def within(self, motion: MotionSeries, reach: Array) -> Array:
        """Return a bound on how ∂η/∂v changes up to `reach` (nv,) from the motion, (p, nv)."""
        speeds = self.speeds(reach)
        turn, length = speeds.dot(self._above.T), motion.arms[0]
        if self._slides:
            slide = speeds.dot(self._inside.T)
            length = length + slide
            arm = length * turn + slide
            bound = self._sums.dot(arm[:, None] * self._turned + turn[:, None] * self._slid)
        else:
            arm = length * turn
            bound = self._sums.dot(arm[:, None] * self._turned)
        if self._rods.size:
            gap = self._rods + self._gaps(motion.arms[1] + arm)
            moved = length[:, None] * self._turned + self._slid
            c0 = self._sums[self._distances] @ moved
            product = gap[:, None] * bound[self._distances] + (c0 @ reach)[:, None] * c0
            bound[self._distances] = 2.0 * product
        return self._by_row(bound)

    def _gaps(self, arms: Array) -> Array:
        """Return the sums over the segments of each distance."""
        gaps: Array = self._sums[self._distances].dot(arms)
        return gaps

    def _rates(self, motion: MotionSeries, order: int, block: Index | slice = slice(None)) -> Array:
        moved = motion.arms[order][:, None] * self._turned
        if self._slides:
            moved = moved + motion.turns[order][:, None] * self._slid
        rates: Array = self._sums[block].dot(moved)
        return rates

    def _by_row(self, bound: Array) -> Array:
        rows: Array = bound[self._of_row]
        return rows


def _marks(members: Sequence[Sequence[int]], count: int) -> Array:
    marks = np.zeros((len(members), count))
    for row, own in zip(marks, members, strict=True):
        row[list(own)] = 1.0
    return marks
