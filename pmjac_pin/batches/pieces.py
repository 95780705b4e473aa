"""Pieces: results of many poses are computed piece by piece, by several threads.

So memory is that of the results and of a piece for each thread, and what is done when somebody
interrupts is not lost.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor, wait
from dataclasses import fields
from threading import Event, Lock
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.batches.results import Status
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

    def __init__(self, at: slice, interrupted: Event) -> None:
        self.at, self._interrupted = at, interrupted

    def each(self, of: Mask) -> Iterator[int]:
        """Yield where a mask holds, for what takes long at each of these poses."""
        for index in np.flatnonzero(of).tolist():
            self.go_on()
            yield index

    def run(self, tape: Tape, inputs: Array) -> Array:
        """Run a tape."""
        self.go_on()
        return run(tape, inputs)

    def go_on(self) -> None:
        """Raise where nobody waits for this any longer."""
        if self._interrupted.is_set():
            raise _GivenUp


class _GivenUp(Exception):
    """Ends a piece; nobody sees it."""


PieceWork: TypeAlias = Callable[[Piece], Sequence[NDArray[Any]]]


def gathered(
    kind: type[Results],
    shapes: Sequence[tuple[int, ...]],
    work: PieceWork,
    threads: int | None = None,
    progress: Progress | None = None,
    **more: Any,
) -> Results:
    """Return results of many poses.

    Parameters
    ----------
    kind : type
        A dataclass of arrays, one of which is called `status`.
    shapes : sequence of tuple of int
        Of its arrays, in their order.
    work : callable
        Piece ↦ its arrays. Where the pieces end depends on their number alone.
    threads, progress
        As of `Batch.close`.
    **more
        What the results are made with besides their arrays.

    Raises
    ------
    ArgumentError, Interrupted
    """
    check_callable(progress, "progress")
    names = [one.name for one in fields(kind)]
    found: list[NDArray[Any]] = [
        np.empty(shape, dtype=np.int8 if name == "status" else np.float64)
        for name, shape in zip(names, shapes, strict=True)
    ]
    filling, pool = _Filling(found, work), ThreadPoolExecutor(thread_count(threads))
    try:
        for done in filling.ends(pool):
            if progress is not None:
                progress(done, filling.count)
        pool.shutdown()
    except BaseException as stopped:
        filling.give_up()  # nothing is written any more: threads are not waited for
        pool.shutdown(wait=False, cancel_futures=True)
        if not isinstance(stopped, KeyboardInterrupt):
            raise
        told = f"{filling.blank()} of {filling.count} poses"
        raise interrupted(told, kind(*map(sealed, found), **more)) from None
    return kind(*map(sealed, found), **more)


class _Filling:
    """Arrays of many poses, filled piece by piece, and the pieces that are left."""

    def __init__(self, found: Sequence[NDArray[Any]], work: PieceWork) -> None:
        self.count, self._found, self._work = len(found[0]), found, work
        starts = range(0, self.count, PIECE)
        self._left = {at: slice(at, min(at + PIECE, self.count)) for at in starts}
        self._given_up, self._writing = Event(), Lock()

    def ends(self, pool: Executor) -> Iterator[int]:
        """Fill the arrays; yield where pieces end, in their order: so the same error is first."""
        starts = list(self._left)
        if len(starts) < 2:  # one alone needs no other thread
            yield from map(self._fill, starts)
            return
        for task in [pool.submit(self._fill, at) for at in starts]:
            while not task.done():
                wait([task], _HEARING)
            yield task.result()

    def give_up(self) -> None:
        """Let nothing be written any more."""
        with self._writing:
            self._given_up.set()

    def blank(self) -> int:
        """Say of the pieces that are left that they are not done; return how many poses are."""
        for array in self._found:
            nothing = np.nan if array.dtype == np.float64 else Status.NOT_DONE
            for piece in self._left.values():
                array[piece] = nothing
        return self.count - sum(piece.stop - piece.start for piece in self._left.values())

    def _fill(self, at: int) -> int:
        piece = Piece(self._left[at], self._given_up)
        piece.go_on()
        parts = self._work(piece)
        with self._writing:
            piece.go_on()
            for whole, part in zip(self._found, parts, strict=True):
                whole[piece.at] = part
            return self._left.pop(at).stop


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
