"""What closes the paths of a piece, and says why some are none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from pmjac_pin.batches.closing import Closing, Found
from pmjac_pin.batches.pieces import Piece
from pmjac_pin.batches.results import Status, Statuses, say_nothing
from pmjac_pin.batches.sound_rows import SoundRows
from pmjac_pin.closing.kernel_walk import CommonStart, Following
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class PathsFromOne:
    """Closes paths from one pose, of which it is known that it is closed, to motor values (N, n).

    Attributes
    ----------
    closing : Closing
    sound : SoundRows
    whose : str
        Whose limits to enforce.
    q : ndarray, shape (nq,)
        Where they begin.
    start : CommonStart or None
        What a kernel knows of that.
    """

    closing: Closing
    sound: SoundRows
    whose: str
    q: Array
    start: CommonStart | None

    @classmethod
    def of(cls, closing: Closing, sound: SoundRows, whose: str, q: Array) -> PathsFromOne:
        """Return what closes paths from a closed q (nq,)."""
        return cls(closing, sound, whose, q, closing.common_start(q))

    def __call__(
        self,
        piece: Piece,
        given: tuple[Array],
        *found: Any,
        following: Following | None = None,
    ) -> bool:
        """Fill q, share and status of a piece; tell whether of some paths nothing is known.

        What follows is done only where a kernel has walked, and all have arrived.
        """
        (values,), closing, start = given, self.closing, self.start
        whose = "none" if self.whose == "motors" else self.whose  # motors are within theirs
        if start is not None:
            if closing.close_inside(piece, start, values, whose, found, following=following):
                return False
        elif closing.mechanism.motors.are_inside(values):
            paths = self._rows(values), values
            closing.close(piece, paths, whose, found, following=following)
            return False
        told = self.sound.of_targets(self._rows(values), values)
        return _close(closing, piece, told, self.whose, found, following=following)

    def _rows(self, values: Array) -> Array:
        return np.broadcast_to(self.q, (len(values), self.q.size))


@dataclass(frozen=True, slots=True, eq=False)
class PathsFromEach:
    """Closes paths from q (N, nq), of which nothing is known, to motor values (N, n).

    Attributes
    ----------
    closing, sound, whose
        As of `PathsFromOne`.
    """

    closing: Closing
    sound: SoundRows
    whose: str

    def __call__(
        self,
        piece: Piece,
        given: tuple[Array, Array],
        *found: Any,
        following: Following | None = None,
    ) -> bool:
        """Fill q, share and status of a piece; tell whether of some paths nothing is known."""
        told = self.sound.of_paths(*given, self.closing.is_open)
        return _close(self.closing, piece, told, self.whose, found, following=following)


PathsWork: TypeAlias = PathsFromOne | PathsFromEach


def _close(
    closing: Closing,
    piece: Piece,
    paths: tuple[Array, Array, Statuses | None],
    whose: str,
    found: Found,
    *,
    following: Following | None,
) -> bool:
    """Close paths, of which some may be none, and tell whether there are any; else it follows."""
    rows, values, why = paths
    if why is None:
        closing.close(piece, (rows, values), whose, found, following=following)
        return False
    closing.close(piece, (rows, values), whose, found)
    none = why != Status.CLOSED
    say_nothing(found, none, why[none])
    return True
