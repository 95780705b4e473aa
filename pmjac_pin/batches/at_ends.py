"""What fills closed poses, and what is found there while they are near the processor."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

from pmjac_pin.batches.at_poses import RatesWork
from pmjac_pin.batches.ellipsoids_work import EllipsoidsWork
from pmjac_pin.batches.paths_work import PathsWork
from pmjac_pin.batches.pieces import Piece
from pmjac_pin.batches.results import Statuses
from pmjac_pin.batches.sound_rows import SoundRows
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class AtEnds:
    """Fills the arrays of `ManyClosed`, and those of what is found where paths end.

    Attributes
    ----------
    paths : PathsWork
    rates : callable
    sound : SoundRows
    """

    paths: PathsWork
    rates: RatesWork
    sound: SoundRows

    def __call__(
        self,
        piece: Piece,
        given: Any,
        q: Array,
        share: Array,
        status: Statuses,
        *found: Any,
    ) -> None:
        """Fill those of a piece."""
        if self.paths(piece, given, q, share, status):
            self.sound.fill(self.rates, piece, q, *found)
        else:
            self.rates(piece, q, *found)


@dataclass(frozen=True, slots=True, eq=False)
class EllipsoidsAtEnds(AtEnds):
    """The same of `ManyEllipsoids`, by one call of the kernels where all paths arrive."""

    rates: EllipsoidsWork

    def __call__(
        self,
        piece: Piece,
        given: Any,
        q: Array,
        share: Array,
        status: Statuses,
        *found: Any,
    ) -> None:
        """Fill those of a piece."""
        begun = self.rates.begun(*found)
        if self.paths(piece, given, q, share, status, following=begun.following):
            self.sound.fill(partial(self.rates.end, begun), piece, q, *found)
        else:
            self.rates.end(begun, piece, q, *found)


def at_ends(paths: PathsWork, rates: RatesWork, sound: SoundRows) -> AtEnds:
    """Return what fills arrays of both, as soon as it can."""
    if isinstance(rates, EllipsoidsWork) and rates.rates.goes_ahead:
        return EllipsoidsAtEnds(paths, rates, sound)
    return AtEnds(paths, rates, sound)
