"""What a proof asks of equations over boxes: to enclose them, and to narrow boxes by them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.values.arrays import Array, Mask

Cuts = NDArray[np.int32]

#: What becomes of a box, where it is not the number of an unknown.
DROPPED, UNCUT = -2, -1


@dataclass(frozen=True, slots=True, eq=False)
class Enclosed:
    """p loop equations over b boxes of k unknowns.

    Attributes
    ----------
    residual : Intervals, shape (b, p)
    jacobian : Intervals, shape (b, p, k)
        ∂η/∂φ; k = 0 where nobody asked for it.
    possible : ndarray of bool, shape (b,)
        False where a body is certainly half a turn from where the rows want it.
    """

    residual: Intervals
    jacobian: Intervals
    possible: Mask


class BoxEquations(Protocol):
    """p equations over boxes (b, k) of their unknowns.

    Attributes
    ----------
    names : tuple of str
    tolerance : ndarray, shape (p,)
        How far each row can be from 0 at a pose that counts as closed.
    """

    @property
    def names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def tolerance(self) -> Array: ...  # noqa: D102

    def evaluate(self, box: Intervals) -> Enclosed:
        """Return all rows and their derivatives by all unknowns."""
        ...

    def residual(self, box: Intervals) -> Intervals:
        """Return all rows, shape (b, p)."""
        ...

    def narrowed(self, box: Intervals, scale: Array, progress: float) -> tuple[Intervals, Cuts]:
        """Return boxes narrowed, and what becomes of each.

        Parameters
        ----------
        box : Intervals, shape (b, k)
        scale : ndarray, shape (k,)
            What counts as a width of 1 in each unknown, rad or m.
        progress : float
            The share of its largest width that a box has to get to, to stay uncut.

        Returns
        -------
        Intervals, shape (b, k)
        ndarray of int, shape (b,)
            DROPPED where no solution is in the box, UNCUT where it got small enough, else the
            unknown across which it is best cut.
        """
        ...
