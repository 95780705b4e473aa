"""A request of paths to many motor values: known again where the next call makes the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pmjac_pin.batches.at_ends import at_ends
from pmjac_pin.batches.at_poses import AtPoses
from pmjac_pin.batches.closing import Closing
from pmjac_pin.batches.filled_again import Refillable
from pmjac_pin.batches.path_starts import path_starts
from pmjac_pin.batches.paths_work import PathsFromEach, PathsFromOne, PathsWork
from pmjac_pin.batches.pieces import PieceWork
from pmjac_pin.batches.results import ManyClosed, ManyEllipsoids, ManyMeasures
from pmjac_pin.batches.sound_rows import SoundRows
from pmjac_pin.batches.wanted import Wanted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import enforced
from pmjac_pin.values.arrays import Array


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


class PathsRequests:
    """Requests of paths of one mechanism, of which the last of each kind is known again.

    Parameters
    ----------
    mechanism : Mechanism
    closing : Closing
    sound : SoundRows
    at_poses : AtPoses
    """

    def __init__(
        self, mechanism: Mechanism, closing: Closing, sound: SoundRows, at_poses: AtPoses
    ) -> None:
        self._mechanism, self._closing, self._sound = mechanism, closing, sound
        self._finds = {ManyEllipsoids: at_poses.ellipsoids, ManyMeasures: at_poses.measures}
        self._last: dict[type, PathsRequest] = {}

    def of(
        self, kind: type[Refillable], values: Array, guess: Any, enforce_limits: bool | str
    ) -> tuple[PathsRequest, tuple[Array, ...]]:
        """Return what is asked of paths to motor values (N, n), and the arrays that this reads.

        Parameters
        ----------
        kind : type
            `ManyClosed`, or what is found where paths end.
        values, guess, enforce_limits
            As for `Batch.close`.
        """
        last = self._last.get(kind)
        if last is not None and last.is_again(guess, enforce_limits, len(values)):
            return last, (values,)
        (paths, given), count = self._paths(values, guess, enforced(enforce_limits)), len(values)
        wanted: tuple[Wanted[Any], ...] = (Wanted.of(self._mechanism, ManyClosed, count),)
        work: PieceWork = paths
        if kind is not ManyClosed:
            work = at_ends(paths, self._finds[kind](), self._sound)
            wanted += (Wanted.of(self._mechanism, kind, count),)
        request = PathsRequest(guess, enforce_limits, count, wanted, work)
        if isinstance(paths, PathsFromOne):  # rows may hold something else next time
            self._last[kind] = request
        return request, given

    def _paths(self, values: Array, guess: Any, whose: str) -> tuple[PathsWork, tuple[Array, ...]]:
        """Return what closes paths to motor values, and the arrays that it reads."""
        start = path_starts(self._mechanism, guess, len(values))
        if start.ndim == 1:
            return PathsFromOne.of(self._closing, self._sound, whose, start), (values,)
        return PathsFromEach(self._closing, self._sound, whose), (start, values)

    def __getstate__(self) -> dict[str, Any]:
        """Return what pickles know: not the requests, whose guesses are no longer the same."""
        return {**vars(self), "_last": {}}
