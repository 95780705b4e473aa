"""What is found at many closed poses: J_eq and what goes with it, by programs.

What they certify is what the single call says; where they cannot, the single call is made.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.batches.ellipsoids_work import EllipsoidsWork
from pmjac_pin.batches.judge import Judge
from pmjac_pin.batches.many_rates import ManyRates
from pmjac_pin.batches.measures import blank_open, fill_measures
from pmjac_pin.batches.pieces import Piece
from pmjac_pin.batches.results import Statuses
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.twist_frame import FrameName
from pmjac_pin.rates.many_radii import fill_radii
from pmjac_pin.values.arrays import Array, Mask

if TYPE_CHECKING:
    from pmjac_pin.algebra.compiled_programs import CompiledPrograms

_WORLD_ALIGNED: FrameName = "LOCAL_WORLD_ALIGNED"
#: (piece, its rows of q, its part of each array) ↦ nothing: it fills them.
RatesWork: TypeAlias = Callable[..., object]


class AtPoses:
    """Finds it at poses of one mechanism, or raises NoToolError.

    Parameters
    ----------
    mechanism : Mechanism
    compiled : CompiledPrograms, optional
        In place of the kernel.
    """

    def __init__(self, mechanism: Mechanism, compiled: CompiledPrograms | None = None) -> None:
        self._mechanism, self._compiled = mechanism, compiled
        self._recorded, self._judge = mechanism.recorded, Judge(mechanism)
        self._known_rates: dict[int, ManyRates] = {}

    def jacobian(self, frame: FrameName) -> RatesWork:
        """Return what finds J_eq and its status."""
        self._mechanism.need_tool()
        rates = self._rates(self._recorded.jacobian(frame))

        def work(piece: Piece, q: Array, J_eq: Array, status: Statuses) -> None:
            _, certain = rates.fill(q, J_eq)
            self._judge.settle(piece, q, certain, frame, (J_eq, status))

        return work

    def ellipsoids(self) -> RatesWork:
        """Return what finds the arrays of `ManyEllipsoids`."""
        return self._ellipsoids

    def measures(self) -> RatesWork:
        """Return what finds those of `ManyMeasures`."""
        self._mechanism.need_tool()
        rates, partition = self._rates(self._recorded.measures), self._recorded.rates.partition

        def work(piece: Piece, q: Array, *found: Any) -> None:
            def fill(part: slice, J_eq: Array) -> tuple[Array, Mask]:
                return rates.fill(q[part], J_eq)

            J_eq, status, linear, angular, *_ = found
            sizes, certain = fill_measures(fill, partition, found)
            self._judge.settle(piece, q, certain, _WORLD_ALIGNED, (J_eq, status))
            fill_radii(J_eq, sizes, linear, angular)
            blank_open(found)

        return work

    @cached_property
    def _ellipsoids(self) -> EllipsoidsWork:
        self._mechanism.need_tool()
        return EllipsoidsWork(self._rates(self._recorded.ellipsoids), self._judge)

    def _rates(self, tape: Tape) -> ManyRates:
        """Return what computes J_eq by a tape."""
        known = self._known_rates.get(id(tape))  # which its rates keep
        if known is None:
            compiled = None if self._compiled is None else self._compiled.of(tape)
            partition, tolerance = self._recorded.rates.partition, self._mechanism.problem.tolerance
            known = ManyRates(tape, partition, tolerance, compiled)
            self._known_rates[id(tape)] = known
        return known
