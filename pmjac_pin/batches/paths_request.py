"""A request of paths to many motor values: known again where the next call makes the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pmjac_pin.batches.gathering import Wanted
from pmjac_pin.batches.pieces import PieceWork


@dataclass(frozen=True, slots=True, eq=False)
class PathsRequest:
    """What is to be found of so many paths.

    Attributes
    ----------
    guess, enforce_limits : object
        As somebody gave them, `Batch.close` says what that may be.
    count : int
        Of paths.
    wanted : tuple of Wanted
        Which results.
    work : callable
        What fills them.
    """

    guess: object
    enforce_limits: object
    count: int
    wanted: tuple[Wanted[Any], ...]
    work: PieceWork

    def is_again(self, guess: object, enforce_limits: object, count: int) -> bool:
        """Tell whether the same objects are given, of as many paths."""
        same = self.guess is guess and self.enforce_limits is enforce_limits
        return same and self.count == count
