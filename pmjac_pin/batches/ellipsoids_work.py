"""What fills J_eq and its radii at closed poses, by a kernel as soon as it has closed them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from pmjac_pin.batches.judge import Judge
from pmjac_pin.batches.many_rates import ManyRates
from pmjac_pin.batches.pieces import Piece
from pmjac_pin.batches.rates_in_lanes import RatesInLanes
from pmjac_pin.batches.results import CLOSED, Statuses
from pmjac_pin.rates.many_radii import fill_radii
from pmjac_pin.values.arrays import Array, Mask


@dataclass(frozen=True, slots=True, eq=False)
class EllipsoidsWork:
    """Fills the arrays of `ManyEllipsoids`.

    Attributes
    ----------
    rates : ManyRates
    judge : Judge
    """

    rates: ManyRates
    judge: Judge

    def __call__(self, piece: Piece, q: Array, *found: Any) -> None:
        """Fill those of a piece."""
        J_eq, status, *radii = found
        self._settle(self.rates.fill(q, J_eq, radii), piece, q, (J_eq, status), radii)

    def begun(self, J_eq: Array, _: Statuses, *radii: Array) -> RatesInLanes:
        """Return what finds it behind a walk, where rates go ahead."""
        return self.rates.ahead(J_eq, radii)

    def end(self, begun: RatesInLanes, piece: Piece, q: Array, *found: Any) -> None:
        """Fill what is left of them: all, where that was not done."""
        J_eq, status, *radii = found
        if begun.is_certain:
            status.fill(CLOSED)
        elif begun.is_done:
            self._settle(begun.told(), piece, q, (J_eq, status), radii)
        else:
            self(piece, q, *found)
        self.rates.put_back(begun)

    def _settle(
        self,
        told: tuple[Array, Mask],
        piece: Piece,
        q: Array,
        found: tuple[Array, Statuses],
        radii: Sequence[Array],
    ) -> None:
        """Keep what is certain of it; make single calls elsewhere."""
        (sizes, certain), (J_eq, _) = told, found
        if self.judge.settle(piece, q, certain, "LOCAL_WORLD_ALIGNED", found):
            fill_radii(J_eq, sizes, *radii)
