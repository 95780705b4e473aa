"""Narrowing: what of a box can hold solutions, and where it is best cut.

A box is dropped when a row's enclosure, directly or in its mean-value form
η(m) + J(X)(X − m), stays away from 0; narrowed by interval Newton steps (Gauss–Seidel on these
rows, and on them combined by an approximate inverse of J(m)). Rows may be as far from 0 as their
tolerance: what is kept holds every pose that counts as closed.

Source: A. Neumaier, Interval Methods for Systems of Equations, 1990, chapters 4 and 5.
"""

from __future__ import annotations

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.studies.modes.box_equations import DROPPED, UNCUT, BoxEquations, Cuts
from pmjac_pin.values.arrays import Array, Index


def narrowed(
    loops: BoxEquations, box: Intervals, scale: Array, progress: float
) -> tuple[Intervals, Cuts]:
    """Return what `BoxEquations.narrowed` says."""
    whole = loops.evaluate(box)
    allowed = Intervals(-loops.tolerance, loops.tolerance)
    kept = np.flatnonzero(whole.possible & whole.residual.meets(allowed).all(axis=1))
    cuts = np.full(len(box.lower), DROPPED, dtype=np.int32)
    lower, upper = box.lower.copy(), box.upper.copy()
    part, jacobian = box[kept], whole.jacobian[kept]
    small = _in_rows(loops, part, jacobian)
    lower[kept], upper[kept] = small.lower, small.upper
    left = ~(small.lower > small.upper).any(axis=1)
    kept, part, small, jacobian = kept[left], part[left], small[left], jacobian[left]
    slope = jacobian.magnitude / loops.tolerance[:, None]
    got = (small.width / scale).max(axis=1) <= progress * (part.width / scale).max(axis=1)
    cuts[kept] = np.where(got, UNCUT, _most_felt(small, slope, scale))
    return Intervals(lower, upper), cuts


def _in_rows(loops: BoxEquations, box: Intervals, jacobian: Intervals) -> Intervals:
    """Return the part of each box where its rows, and these combined, can vanish."""
    middle = box.middle
    at_middle = loops.residual(Intervals.exact(middle)).widened(loops.tolerance)
    inverse = _approximate_inverse(jacobian.middle, loops.tolerance)
    rows = Intervals.join([jacobian, jacobian.after(inverse)], axis=1)
    combined = at_middle[:, :, None].after(inverse)[:, :, 0]
    return _solved(box, middle, rows, Intervals.join([at_middle, combined], axis=1))


def _approximate_inverse(jacobian: Array, tolerance: Array) -> Array:
    """Return about (JᵀJ)⁻¹Jᵀ of rows by their tolerances: no proof depends on how exact it is."""
    weight = (tolerance.min() / tolerance)[:, None]
    weighted = jacobian * weight
    across = weighted.transpose(0, 2, 1)
    square = across @ weighted
    diagonal = np.einsum("bii->bi", square)
    diagonal += 1e-13 * diagonal.max(axis=1, keepdims=True) + 1e-200
    inverse: Array = np.linalg.solve(square, across) * weight[:, 0]
    return inverse


def _solved(box: Intervals, middle: Array, rows: Intervals, at_middle: Intervals) -> Intervals:
    """Return the part of each box where 0 ∈ at_middle + rows · (φ − middle); lower > upper: none.

    One unknown after the other is solved for, in every row at once.
    """
    step = box - Intervals.exact(middle)
    lower, upper = step.lower.copy(), step.upper.copy()
    for column in range(middle.shape[1]):
        others = np.arange(middle.shape[1]) != column
        terms = rows[:, :, others] * Intervals(lower, upper)[:, None, others]
        bound = -(at_middle + terms.sum(axis=2)) / rows[:, :, column]
        lower[:, column] = np.maximum(lower[:, column], bound.lower.max(axis=1))
        upper[:, column] = np.minimum(upper[:, column], bound.upper.min(axis=1))
    return (Intervals.exact(middle) + Intervals(lower, upper)).meet(box)


def _most_felt(box: Intervals, slope: Array, scale: Array) -> Index:
    """Return the unknown that the rows feel most.

    A row that cannot change by as much as its tolerance feels, by half, how wide each unknown is.
    """
    width = box.width / scale
    width *= 0.5 / (width.sum(axis=1, keepdims=True) + 1e-300)
    felt = slope * box.width[:, None, :]
    whole = felt.sum(axis=2, keepdims=True) + 1.0
    share = ((felt + width[:, None, :]) / whole).sum(axis=1)
    most: Index = np.where(box.width > 0.0, share, -1.0).argmax(axis=1)
    return most
