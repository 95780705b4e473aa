"""Pieces: results of many poses are computed piece by piece, by several threads.

So memory is that of the results and of a piece for each thread, and what is done when somebody
interrupts is not lost.
"""

from __future__ import annotations

from _thread import start_new_thread
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import pairwise, repeat
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.rest import Rest, wait_for, wait_whatever_happens
from pmjac_pin.batches.results import Status, say_nothing
from pmjac_pin.errors import ArgumentError, Interrupted, quoted
from pmjac_pin.values.arrays import Array, Mask
from pmjac_pin.values.cores import usable_cores

PIECE = 5120  # poses at most: they fill the kernel's lanes, and some MB
_BY_ONE = 3072  # poses of a small machine, done as soon as another thread would have begun
_LANES, _NOT_DONE = 16, int(Status.NOT_DONE)
Progress: TypeAlias = Callable[[int, int], object]


class Piece:
    """A part of many poses, which is given up where nobody waits for it any longer.

    Attributes
    ----------
    at : slice
        Which poses.
    """

    __slots__ = ("_of", "at")

    def __init__(self, at: slice, of: Filling) -> None:
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


#: (piece, its part of what is given, its part of each array) ↦ nothing: it fills these.
PieceWork: TypeAlias = Callable[..., object]


def pieces_of(count: int) -> list[slice[int, int, None]]:
    """Return the pieces of so many poses, whoever computes them.

    They are alike, so that threads end together, but the first and the last, which are halves: else
    threads would end each piece at one time, and wait for each other at Python's lock.

    Examples
    --------
    >>> [piece.stop - piece.start for piece in pieces_of(10_000)]
    [2512, 5024, 2464]
    """
    if count <= _BY_ONE:
        return [slice(0, count)] if count else []
    alike = 2 * -(-count // (2 * PIECE))
    half = -(-count // (2 * alike * _LANES)) * _LANES
    ends = [0, *range(half, count, 2 * half), count]
    return [slice(start, end) for start, end in pairwise(ends)]


class _Arrays:
    """Arrays of results that are filled piece by piece.

    In results that somebody has already, what has become of poses is said when all of their piece
    is done, and before that they are not: so whenever somebody interrupts, and however often, what
    is not done says so.

    Attributes
    ----------
    count : int
        Of poses.
    """

    def __init__(
        self,
        found: list[NDArray[Any]],
        work: PieceWork,
        given: tuple[Array, ...],
        seen: Sequence[int],
    ) -> None:
        self._found, self._work, self._given, self._seen = found, work, given, seen
        self.count = len(found[0])
        for k in seen:
            found[k].fill(_NOT_DONE)

    def _do(self, piece: Piece, given: tuple[Array, ...], found: list[NDArray[Any]]) -> None:
        """Fill the arrays of a piece."""
        if not self._seen:
            self._work(piece, given, *found)
            return
        told = found.copy()
        for k in self._seen:
            told[k] = np.empty(found[k].shape, np.int8)
        self._work(piece, given, *told)
        for k in self._seen:
            found[k][:] = told[k]


class Whole(_Arrays, Piece):
    """Arrays of so few poses that they are one piece, where each microsecond counts: it is that.

    Attributes
    ----------
    helpers
        As of `Filling`: none.
    """

    helpers: Sequence[Rest] = ()
    at, _is_done = slice(None), False

    def go_on(self) -> None:
        """Go on: somebody waits for it."""

    def fill(self, _: int, progress: Progress | None) -> None:
        """Fill the arrays, in the caller's thread."""
        if self.count:
            self._do(self, self._given, self._found)
        self._is_done = True
        if progress is not None and self.count:
            progress(self.count, self.count)

    def blank(self) -> int:
        """Leave no numbers where they are not filled; return how many poses are done."""
        if self._is_done:
            return self.count
        say_nothing(self._found, slice(None), Status.NOT_DONE)
        return 0


class Filling(_Arrays):
    """Arrays of many poses, filled piece by piece, and the pieces that are left.

    Threads take the pieces in their order, the caller's own among them. What they share are
    collections, of which each single operation is whole.

    Attributes
    ----------
    given_up : bool
        Whether nobody waits for the pieces any longer.
    helpers : list of Rest
        Of the threads besides the caller's.
    """

    def __init__(
        self,
        found: list[NDArray[Any]],
        work: PieceWork,
        given: tuple[Array, ...],
        seen: Sequence[int],
    ) -> None:
        super().__init__(found, work, given, seen)
        self._left = {piece.start: piece for piece in pieces_of(self.count)}
        self._waiting = deque(self._left)
        self._ended: deque[int] = deque()
        self._failed: dict[int, Exception] = {}
        self.given_up = False
        self.helpers: list[Rest] = []

    def fill(self, threads: int, progress: Progress | None) -> None:
        """Fill the arrays; raise what went wrong in the first of the pieces where something did."""
        told = _Told(progress, self.count, self._ended)
        self.helpers.extend(Rest() for _ in range(min(threads, len(self._left)) - 1))
        begun: list[int] = []
        try:
            # Not by `threading`, which waits until each runs: 0.1 ms where a core is to wake. And
            # at once, so that whoever interrupts finds in `begun` all that run.
            with suppress(RuntimeError):  # where no more threads can be, fewer do it
                begun.extend(map(start_new_thread, repeat(self._help), zip(self.helpers)))
            for _ in self._pieces():
                told.on()
            wait_for(self.helpers[: len(begun)])
            told.on()
        except BaseException:
            self.give_up()
            wait_whatever_happens(self.helpers[: len(begun)])
            raise
        for at in sorted(self._failed)[:1]:
            raise self._failed[at]
        if self._left:
            raise RuntimeError(f"a thread has ended before {len(self._left)} of its pieces")

    def give_up(self) -> None:
        """Leave what has not begun; what has ends at its next step."""
        self._waiting.clear()
        self.given_up = True

    def blank(self) -> int | None:
        """Leave no numbers in pieces that are left; return how many poses are done.

        None where threads still write, since somebody has interrupted again before they were at
        rest: then what is done is not known yet, and the rest says that it is not done.
        """
        self.give_up()
        if any(rest.is_busy for rest in self.helpers):
            return None
        left = list(self._left.values())
        for piece in left:
            say_nothing(self._found, piece, Status.NOT_DONE)
        return self.count - sum(piece.stop - piece.start for piece in left)

    def _help(self, rest: Rest) -> None:
        rest.is_busy = True
        try:
            for _ in self._pieces():
                pass
        finally:
            rest.reach()

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
        given = tuple([array[piece.at] for array in self._given])
        self._do(piece, given, [array[piece.at] for array in self._found])
        del self._left[at]
        self._ended.append(piece.at.stop - at)


def filling_of(
    found: list[NDArray[Any]], work: PieceWork, given: tuple[Array, ...], seen: Sequence[int]
) -> Whole | Filling:
    """Return what fills arrays, each of its pieces by such work.

    Parameters
    ----------
    found : list of ndarray
    work : callable
    given : tuple of ndarray
        What the work reads, row by row.
    seen : sequence of int
        Which of the arrays are statuses of results that somebody has already.
    """
    return (Whole if len(found[0]) <= _BY_ONE else Filling)(found, work, given, seen)


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
        return usable_cores()
    if isinstance(given, bool) or not isinstance(given, int) or given < 1:
        raise ArgumentError(f"threads must be a whole number ≥ 1 or None, got {quoted(given)}")
    return given
