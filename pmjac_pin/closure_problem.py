"""ClosureProblem: the loop equations of a mechanism as functions, and when they count as closed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.factorisation import norm
from pmjac_pin.partition import Partition

Array = NDArray[np.float64]

#: Loops count as closed below this gap, m; for machines beyond 100 m, rounding allows only
#: 1e-14 of their size.
CLOSURE_TOLERANCE = 1e-12

ROUNDING = 1e-15  # of the characteristic length: a gap that no further iteration can improve


@dataclass(frozen=True, slots=True)
class ClosureProblem:
    """The loop equations as functions of q, and the partition of their columns.

    Attributes
    ----------
    evaluate : callable
        q ↦ (η (p,), ∂η/∂v (p, nv)).
    integrate : callable
        (q, v) ↦ q ⊕ v.
    partition : Partition
    given_tolerance : float or None
        The gap in m that the model calls closed; None for `CLOSURE_TOLERANCE`.
    """

    evaluate: Callable[[Array], tuple[Array, Array]]
    integrate: Callable[[Array, Array], Array]
    partition: Partition
    given_tolerance: float | None = None

    @property
    def tolerance(self) -> float:
        """The gap in m below which the loops are closed."""
        return max(self.given_tolerance or CLOSURE_TOLERANCE, 1e-14 * self.partition.length)

    def gap(self, residual: Array) -> float:
        """Return the Euclidean norm of a residual, in m."""
        return norm(residual * self.partition.row_scale)
