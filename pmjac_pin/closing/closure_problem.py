"""ClosureProblem: the loop equations of a mechanism as functions, and when they count as closed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.found_once import found_once

#: Loops count as closed below this gap, of the characteristic length.
CLOSURE_TOLERANCE = 1e-12

#: Of the characteristic length: with a larger tolerance no rank could be told.
LARGEST_SHARE = 1e-2

ROUNDING = 1e-15  # of the characteristic length: a gap that no further iteration can improve


@dataclass(frozen=True)
class ClosureProblem:
    """The loop equations as functions of q, and the partition of their columns.

    Attributes
    ----------
    evaluate : callable
        q ↦ (η (p,), ∂η/∂v (p, nv)).
    integrate : callable
        (q, v) ↦ q ⊕ v.
    difference : callable
        (q, q') ↦ v with q ⊕ v = q'.
    partition : Partition
    given_tolerance : float or None
        The gap in m that the model calls closed; None for `CLOSURE_TOLERANCE`.
    rounding : float
        The gap in m that the rounding of the model's coordinates may leave: of a machine that
        stands far from the world's origin.
    """

    evaluate: Callable[[Array], tuple[Array, Array]]
    integrate: Callable[[Array, Array], Array]
    difference: Callable[[Array, Array], Array]
    partition: Partition
    given_tolerance: float | None = None
    rounding: float = 0.0

    @found_once
    def tolerance(self) -> float:
        """The gap in m below which the loops are closed."""
        least = max(CLOSURE_TOLERANCE * self.partition.length, self.rounding)
        return max(self.given_tolerance or 0.0, least)

    @property
    def largest_tolerance(self) -> float:
        """The largest gap in m that may be called closed."""
        return LARGEST_SHARE * self.partition.length

    def gap(self, residual: Array) -> float:
        """Return the Euclidean norm of a residual, in m."""
        return norm(residual * self.partition.row_scale)
