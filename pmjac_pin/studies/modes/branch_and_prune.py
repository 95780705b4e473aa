"""Branch and prune: small boxes that hold every solution of the equations in a large one.

A box is dropped when a row's enclosure, directly or in its mean-value form
η(m) + J(X)(X − m), stays away from 0; narrowed by interval Newton steps (Gauss–Seidel on these
rows, and on them combined by an approximate inverse of J(m)); and cut in two where that no longer
helps. Rows may be as far from 0 as their tolerance: what is kept holds every pose that counts as
closed.

Source: A. Neumaier, Interval Methods for Systems of Equations, 1990, chapters 4 and 5.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.studies.modes.interval_loops import Enclosed, IntervalLoops
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_number

_BATCH = 1024  # boxes at once
_SMALLEST_BOX = 1e-7  # scaled width below which boxes are no longer cut
_PROGRESS = 0.6  # of a box's width: what narrowing has to reach to be tried again uncut


@dataclass(frozen=True, slots=True)
class Budget:
    """How much a proof may cost.

    Attributes
    ----------
    boxes : int
        0 or more; as many as it takes where infinite.
    seconds : float
        Likewise.

    Raises
    ------
    ArgumentError
        No number, or negative.
    """

    boxes: float = 200_000
    seconds: float = 60.0

    def __post_init__(self) -> None:
        for name, value in (("boxes", self.boxes), ("seconds", self.seconds)):
            if as_number(value, name, math.inf) < 0.0:
                raise ArgumentError(f"{name} must be 0 or more, got {quoted(value)}")


@dataclass(frozen=True, slots=True, eq=False)
class Pruned:
    """What is left of a box.

    Attributes
    ----------
    small : Intervals, shape (n, k)
        With `unfinished`, they hold all solutions.
    unfinished : Intervals, shape (u, k)
        Not looked at any more when the budget was spent.
    boxes : int
        How many were looked at.
    """

    small: Intervals
    unfinished: Intervals
    boxes: int


def branch_and_prune(
    loops: IntervalLoops, start: Intervals, scale: Array, budget: Budget
) -> Pruned:
    """Return small boxes that hold every solution in `start`.

    Parameters
    ----------
    loops : IntervalLoops
    start : Intervals, shape (b, k)
    scale : ndarray, shape (k,)
        What counts as a width of 1 in each unknown, rad or m.
    budget : Budget
    """
    end = time.monotonic() + budget.seconds
    waiting, small, boxes = start, [start[:0]], 0
    while len(waiting.lower) and boxes < budget.boxes and time.monotonic() < end:
        box, waiting = waiting[-_BATCH:], waiting[:-_BATCH]
        boxes += len(box.lower)
        old, box, slope = _pruned(loops, box)
        widths = box.width / scale
        done = widths.max(axis=1) <= _SMALLEST_BOX
        small.append(box[done])
        old, box, slope, widths = old[~done], box[~done], slope[~done], widths[~done]
        moved = widths.max(axis=1) <= _PROGRESS * (old.width / scale).max(axis=1)
        waiting = Intervals.join([waiting, box[moved], _halves(box[~moved], slope[~moved], scale)])
    return Pruned(Intervals.join(small), waiting, boxes)


def _pruned(loops: IntervalLoops, box: Intervals) -> tuple[Intervals, Intervals, Array]:
    """Return the boxes that may hold solutions: as they were, narrowed, and |J| per tolerance."""
    whole = loops.evaluate(box)
    allowed = Intervals(-loops.tolerance, loops.tolerance)
    keep = np.asarray(whole.possible & whole.residual.meets(allowed).all(axis=1))
    box = box[keep]
    whole = Enclosed(whole.residual[keep], whole.jacobian[keep], whole.possible[keep])
    middle = box.middle
    at_middle = loops.residual(Intervals.exact(middle)).widened(loops.tolerance)
    inverse = _approximate_inverse(whole.jacobian.middle, loops.tolerance)
    rows = Intervals.join([whole.jacobian, whole.jacobian.after(inverse)], axis=1)
    combined = at_middle[:, :, None].after(inverse)[:, :, 0]
    narrowed = _narrowed(box, middle, rows, Intervals.join([at_middle, combined], axis=1))
    left = np.asarray(~(narrowed.lower > narrowed.upper).any(axis=1))
    slope = whole.jacobian.magnitude[left] / loops.tolerance[:, None]
    return box[left], narrowed[left], slope


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


def _narrowed(box: Intervals, middle: Array, rows: Intervals, at_middle: Intervals) -> Intervals:
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


def _halves(box: Intervals, slope: Array, scale: Array) -> Intervals:
    """Return each box cut in two across the unknown that the rows feel most.

    A row that cannot change by as much as its tolerance feels, by half, how wide each unknown is.
    """
    width = box.width / scale
    width *= 0.5 / (width.sum(axis=1, keepdims=True) + 1e-300)
    felt = slope * box.width[:, None, :]
    whole = felt.sum(axis=2, keepdims=True) + 1.0
    share = ((felt + width[:, None, :]) / whole).sum(axis=1)
    share = np.where(box.width > 0.0, share, -1.0)
    rows, column = np.arange(len(box.lower)), share.argmax(axis=1)
    cut = box.middle[rows, column]
    left, right = box.upper.copy(), box.lower.copy()
    left[rows, column] = right[rows, column] = cut
    return Intervals.join([Intervals(box.lower, left), Intervals(right, box.upper)])
