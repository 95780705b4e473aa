"""Pieces: results of many poses are computed piece by piece, by several threads.

So memory is that of the results and of a piece for each thread, and what is done when somebody
interrupts is not lost.
"""

from __future__ import annotations

import os
from _thread import start_new_thread
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import pairwise, repeat
from threading import Event
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.filled_again import Shapes, Shown, let_go, note_shown, shown_by
from pmjac_pin.batches.results import Status, empty_arrays, say_nothing
from pmjac_pin.errors import ArgumentError, Interrupted, quoted
from pmjac_pin.values.arrays import Array, Mask, ReadOnlyArrays, sealed
from pmjac_pin.values.checks import check_callable

PIECE = 5120  # poses at most: they fill the kernel's lanes, and some MB
_BY_ONE = 3072  # poses of a small machine, done as soon as another thread would have begun
_LANES = 16
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


class Manner(NamedTuple):
    """How many poses are computed.

    Attributes
    ----------
    threads, progress
        As of `Batch.close`.
    given : tuple of ndarray
        What is read while results are filled.
    """

    threads: int | None = None
    progress: Progress | None = None
    given: tuple[Array, ...] = ()


class Wanted(Generic[Results]):
    """Results of many poses that are wanted.

    Parameters
    ----------
    kind : type
        A dataclass of arrays, one of which is called `status`.
    shapes : mapping of str to tuple of int
        Of its arrays, by their names.
    out : Results, optional
        To be filled again.
    **more
        What the results are made with besides their arrays.
    """

    __slots__ = ("_kind", "_more", "_out", "_shapes")

    def __init__(
        self,
        kind: type[Results],
        shapes: Shapes,
        out: Results | None = None,
        **more: Any,
    ) -> None:
        self._kind, self._shapes, self._out, self._more = kind, shapes, out, more

    def taken(self, given: Sequence[Array], call: object) -> tuple[Results, Shown]:
        """Return the results and what they show, which nobody but this call fills.

        Raises
        ------
        ArgumentError
            Results that cannot be filled again, while this is read.
        """
        if self._out is None:
            arrays = empty_arrays(self._shapes)
            shown = {name: sealed(array) for name, array in arrays.items()}
            result = self._kind(**shown, **self._more)
            seen = Shown(arrays, self._shapes, {})
            note_shown(result, seen)
            return result, seen
        return self._out, shown_by(self._out, self._kind, self._shapes, given, call)

    def let_go(self, call: object) -> None:
        """Leave results that are filled again to others, if this call has taken them."""
        if isinstance(self._out, self._kind):
            let_go(self._out, call)

    def renew(self) -> None:
        """Let results that are filled again say what they are made with now."""
        if self._out is not None and self._more:
            self._out.__post_init__(**self._more)


def gathered(wanted: Wanted[Results], work: PieceWork, how: Manner) -> Results:
    """Return results of many poses.

    Parameters
    ----------
    wanted : Wanted
    work : callable
        Fills the arrays of a piece, ``work(piece, *parts)``, in their order. Where the pieces end
        depends on the number of poses alone.
    how : Manner

    Raises
    ------
    ArgumentError, Interrupted
    """
    result: Results
    (result,) = gathered_together((wanted,), work, how)
    return result


def gathered_together(
    wanted: Sequence[Wanted[Any]], work: PieceWork, how: Manner
) -> tuple[Any, ...]:
    """Return several results of the same poses, each piece of all of them at a time."""
    check_callable(how.progress, "progress")
    threads, call = thread_count(how.threads), object()
    try:
        taken = [one.taken(how.given, call) for one in wanted]
        for one in wanted:  # none of them was refused
            one.renew()
        results = tuple(result for result, _ in taken)
        filling = _Filling([array for _, shown in taken for array in shown.arrays.values()], work)
        try:
            filling.fill(threads, how.progress)
        except BaseException as stopped:
            told = f"{filling.blank()} of {filling.count} poses"
            if isinstance(stopped, KeyboardInterrupt):
                done = results if len(results) > 1 else results[0]
                raise interrupted(told, done) from None
            raise
    finally:
        for one in wanted:
            one.let_go(call)
    return results


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


class _Filling:
    """Arrays of many poses, filled piece by piece, and the pieces that are left.

    Threads take the pieces in their order, the caller's own among them. What they share are
    collections, of which each single operation is whole.
    """

    def __init__(self, found: Sequence[NDArray[Any]], work: PieceWork) -> None:
        self.count, self._found, self._work = len(found[0]), found, work
        self._left = {piece.start: piece for piece in pieces_of(self.count)}
        self._waiting = deque(self._left)
        self._ended: deque[int] = deque()
        self._failed: dict[int, Exception] = {}
        self.given_up = False

    def fill(self, threads: int, progress: Progress | None) -> None:
        """Fill the arrays; raise what went wrong in the first of the pieces where something did."""
        told = _Told(progress, self.count, self._ended)
        at_rest = [Event() for _ in range(min(threads, len(self._left)) - 1)]
        helpers: list[int] = []
        try:
            # Not by `threading`, which waits until each runs: 0.1 ms where a core is to wake. And
            # at once, so that whoever interrupts finds in `helpers` all that run.
            if at_rest:
                helpers.extend(map(start_new_thread, repeat(self._help), zip(at_rest)))
            for _ in self._pieces():
                told.on()
            _wait_for(at_rest)
            told.on()
        except BaseException:
            self._waiting.clear()
            self.given_up = True
            _wait_whatever_happens(at_rest[: len(helpers)])
            raise
        for at in sorted(self._failed)[:1]:
            raise self._failed[at]
        if self._left:
            raise RuntimeError(f"a thread has ended before {len(self._left)} of its pieces")

    def blank(self) -> int:
        """Say of the pieces that are left that they are not done; return how many poses are."""
        for piece in self._left.values():
            say_nothing(self._found, piece, Status.NOT_DONE)
        return self.count - sum(piece.stop - piece.start for piece in self._left.values())

    def _help(self, at_rest: Event) -> None:
        try:
            for _ in self._pieces():
                pass
        finally:
            at_rest.set()

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


def _wait_for(at_rest: Sequence[Event]) -> None:
    for event in at_rest:
        while not event.wait(_HEARING):
            pass


def _wait_whatever_happens(at_rest: Sequence[Event]) -> None:
    """Wait for threads that go to their next step, however often somebody interrupts.

    What they still write to is given to others then.
    """
    waiting = True
    while waiting:
        with suppress(KeyboardInterrupt):
            _wait_for(at_rest)
            waiting = False


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
