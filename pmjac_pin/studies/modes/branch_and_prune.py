"""Branch and prune: small boxes that hold every solution of the equations in a large one.

A box is narrowed to where it can hold solutions, dropped where it can hold none, and cut in two
where narrowing no longer helps.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.studies.modes.box_equations import DROPPED, UNCUT, BoxEquations, Cuts
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


def branch_and_prune(loops: BoxEquations, start: Intervals, scale: Array, budget: Budget) -> Pruned:
    """Return small boxes that hold every solution in `start`.

    Parameters
    ----------
    loops : BoxEquations
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
        box, cuts = loops.narrowed(box, scale, _PROGRESS)
        left = cuts != DROPPED
        done = left & ((box.width / scale).max(axis=1) <= _SMALLEST_BOX)
        small.append(box[done])
        uncut, cut = left & ~done & (cuts == UNCUT), left & ~done & (cuts != UNCUT)
        waiting = Intervals.join([waiting, box[uncut], _halves(box[cut], cuts[cut])])
    return Pruned(Intervals.join(small), waiting, boxes)


def _halves(box: Intervals, column: Cuts) -> Intervals:
    """Return each box cut in two across an unknown."""
    rows = np.arange(len(box.lower))
    cut = box.middle[rows, column]
    left, right = box.upper.copy(), box.lower.copy()
    left[rows, column] = right[rows, column] = cut
    return Intervals.join([Intervals(box.lower, left), Intervals(right, box.upper)])
