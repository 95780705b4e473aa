"""Pieces: results of many poses are computed piece by piece, by several threads.

So memory is that of the results and of a piece for each thread, and what is done when somebody
interrupts is not lost.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from threading import Thread
from typing import Any, Generic, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.filled_again import memory_of, note_memory
from pmjac_pin.batches.results import Status, empty_arrays
from pmjac_pin.errors import ArgumentError, Interrupted, quoted
from pmjac_pin.values.arrays import Array, Mask, ReadOnlyArrays, sealed
from pmjac_pin.values.checks import check_callable

PIECE = 4096  # poses: they fill the kernel's lanes, and some MB
_HEARING = 0.2  # s: what waits for another thread does not hear every signal
Progress: TypeAlias = Callable[[int, int], object]
Results = TypeVar("Results", bound=ReadOnlyArrays)


class Piece:
    """A part of many poses, which is given up where nobody waits for it any longer.

    Attributes
    ----------
    at : slice
        Which poses.
    """

    __slots__ = ("_of", "at")

    def __init__(self, at: slice, of: _Filling) -> None:
        self.at, self._of = at, of

    def each(self, of: Mask) -> Iterator[int]:
        """Yield where a mask holds, for what takes long at each of these poses."""
        for index in np.flatnonzero(of).tolist():
            self.go_on()
            yield index

    def go_on(self) -> None:
        """Raise where nobody waits for this any longer."""
        if self._of.given_up:
            raise _GivenUp


class _GivenUp(Exception):
    """Ends a piece; nobody sees it."""


#: (piece, its part of each array) ↦ nothing: it fills them.
PieceWork: TypeAlias = Callable[..., object]


@dataclass(frozen=True, slots=True)
class Manner(Generic[Results]):
    """How many poses are computed.

    Attributes
    ----------
    threads, progress, out
        As of `Batch.close`.
    given : tuple of ndarray
        What is read while results are filled.
    """

    threads: int | None = None
    progress: Progress | None = None
    out: Results | None = None
    given: tuple[Array, ...] = ()


def gathered(
    kind: type[Results],
    shapes: Mapping[str, tuple[int, ...]],
    work: PieceWork,
    how: Manner[Results],
    **more: Any,
) -> Results:
    """Return results of many poses.

    Parameters
    ----------
    kind : type
        A dataclass of arrays, one of which is called `status`.
    shapes : mapping of str to tuple of int
        Of its arrays, by their names.
    work : callable
        Fills the arrays of a piece, ``work(piece, *parts)``, in that order. Where the pieces end
        depends on their number alone.
    how : Manner
    **more
        What the results are made with besides their arrays.

    Raises
    ------
    ArgumentError, Interrupted
    """
    check_callable(how.progress, "progress")
    threads, result = thread_count(how.threads), how.out
    if result is None:
        found = empty_arrays(shapes)
        result = kind(**{name: sealed(array) for name, array in found.items()}, **more)
    else:
        found = memory_of(result, kind, shapes, how.given)
        result.__post_init__(**more)
    filling = _Filling(list(found.values()), work)
    try:
        filling.fill(threads, how.progress)
    except BaseException as stopped:
        told = f"{filling.blank()} of {filling.count} poses"
        if isinstance(stopped, KeyboardInterrupt):
            raise interrupted(told, result) from None
        raise
    finally:
        note_memory(result, found)
    return result


class _Filling:
    """Arrays of many poses, filled piece by piece, and the pieces that are left.

    Threads take the pieces in their order, the caller's own among them. What they share are
    collections, of which each single operation is whole.
    """

    def __init__(self, found: Sequence[NDArray[Any]], work: PieceWork) -> None:
        self.count, self._found, self._work = len(found[0]), found, work
        starts = range(0, self.count, PIECE)
        self._left = {at: slice(at, min(at + PIECE, self.count)) for at in starts}
        self._waiting, self._ended = deque(starts), deque[int]()
        self._failed: dict[int, Exception] = {}
        self.given_up = False

    def fill(self, threads: int, progress: Progress | None) -> None:
        """Fill the arrays; raise what went wrong in the first of the pieces where something did."""
        told = _Told(progress, self.count, self._ended)
        helpers = [Thread(target=self._help) for _ in range(min(threads, len(self._left)) - 1)]
        try:
            for helper in helpers:
                helper.start()
            for _ in self._pieces():
                told.on()
            _wait_for(helpers)
            told.on()
        except BaseException:
            self._waiting.clear()
            self.given_up = True
            _wait_for(helpers)  # each to its next step: nothing is written any more
            raise
        for at in sorted(self._failed)[:1]:
            raise self._failed[at]

    def blank(self) -> int:
        """Say of the pieces that are left that they are not done; return how many poses are."""
        for array in self._found:
            nothing = np.nan if array.dtype == np.float64 else Status.NOT_DONE
            for piece in self._left.values():
                array[piece] = nothing
        return self.count - sum(piece.stop - piece.start for piece in self._left.values())

    def _help(self) -> None:
        for _ in self._pieces():
            pass

    def _pieces(self) -> Iterator[None]:
        """Fill pieces for as long as there are any; yield after each."""
        while self._waiting:
            try:
                at = self._waiting.popleft()
            except IndexError:  # another thread has taken it
                return
            try:
                self._fill(at)
            except Exception as error:  # raised by `fill`
                self._failed[at] = error
                self._waiting.clear()
                return
            yield

    def _fill(self, at: int) -> None:
        piece = Piece(self._left[at], self)
        self._work(piece, *(array[piece.at] for array in self._found))
        del self._left[at]
        self._ended.append(piece.at.stop - at)


class _Told:
    """Says how many poses are done to whom it was asked to."""

    def __init__(self, progress: Progress | None, count: int, ended: deque[int]) -> None:
        self._progress, self._count, self._ended, self._done = progress, count, ended, 0

    def on(self) -> None:
        """Say it, where more are done than when it was said before."""
        while self._ended and self._progress is not None:
            while self._ended:
                self._done += self._ended.popleft()
            self._progress(self._done, self._count)


def _wait_for(threads: Sequence[Thread]) -> None:
    for thread in threads:
        while thread.is_alive():
            thread.join(_HEARING)


def interrupted(what: str, done: object) -> Interrupted:
    """Return what is raised when somebody interrupts, with what is done."""
    return Interrupted(
        f"{what} are done, and kept in `done` of this exception (at a prompt, sys.last_value.done);"
        " the others have the status NOT_DONE there",
        done,
    )


def thread_count(given: int | None) -> int:
    """Return how many threads: all cores that this process may use, unless told."""
    if given is None:
        allowed = getattr(os, "sched_getaffinity", None)  # not on every system
        return len(allowed(0)) if allowed else os.cpu_count() or 1
    if isinstance(given, bool) or not isinstance(given, int) or given < 1:
        raise ArgumentError(f"threads must be a whole number ≥ 1 or None, got {quoted(given)}")
    return given
