"""ClosureProblem: the loop equations of a mechanism as functions, and when they count as closed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.found_once import found_once

#: Loops count as closed below this gap, of the characteristic length.
CLOSURE_TOLERANCE = 1e-12

#: Of the characteristic length: with a larger tolerance no rank could be told.
LARGEST_SHARE = 1e-2

ROUNDING = 1e-15  # of the characteristic length: a gap that no further iteration can improve


class LoopEquations(Protocol):
    """η (p,) and ∂η/∂v (p, nv) as functions of q, as `Kinematics` has them."""

    def closure(self, q: Array) -> tuple[Array, Array]:
        """Return both, each loop seen from the body that carries its two ends."""
        ...

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Return both in axes that turn from pose to pose, with the same gaps and steps: faster."""
        ...


@dataclass(frozen=True)
class ClosureProblem:
    """The loop equations as functions of q, and the partition of their columns.

    Attributes
    ----------
    loops : LoopEquations
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

    loops: LoopEquations
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

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Return η (p,) and ∂η/∂v (p, nv), each loop seen from the body that carries both ends."""
        return self.loops.closure(q)

    @property
    def largest_tolerance(self) -> float:
        """The largest gap in m that may be called closed."""
        return LARGEST_SHARE * self.partition.length

    def gap(self, residual: Array) -> float:
        """Return the Euclidean norm of a residual, in m."""
        return norm(residual * self.partition.row_scale)
