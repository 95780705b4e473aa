"""Pieces: results of many poses are computed piece by piece, by several threads.

So memory is that of the results and of a piece for each thread, and what is done when somebody
interrupts is not lost.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
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


Work: TypeAlias = Callable[[Piece], Sequence[NDArray[Any]]]


def gathered(
    kind: type[Results],
    shapes: Sequence[tuple[int, ...]],
    work: Work,
    threads: int | None = None,
    progress: Progress | None = None,
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

    Raises
    ------
    Interrupted
    """
    names = [one.name for one in fields(kind)]
    found: list[NDArray[Any]] = [
        np.empty(shape, dtype=np.int8 if name == "status" else np.float64)
        for name, shape in zip(names, shapes, strict=True)
    ]
    count = shapes[0][0]
    left = {at: slice(at, min(at + PIECE, count)) for at in range(0, count, PIECE)}
    pool, given_up, writing = ThreadPoolExecutor(thread_count(threads)), Event(), Lock()

    def one(at: int) -> int:
        piece = Piece(left[at], given_up)
        piece.go_on()
        parts = work(piece)
        with writing:
            piece.go_on()
            for whole, part in zip(found, parts, strict=True):
                whole[piece.at] = part
            return left.pop(at).stop

    try:
        # One alone needs no other thread.
        ends = map(one, list(left)) if len(left) < 2 else _in_order(pool, one, list(left))
        for done in ends:
            if progress is not None:
                progress(done, count)
        pool.shutdown()
    except BaseException as stopped:
        with writing:
            given_up.set()  # nothing is written any more: threads are not waited for
        pool.shutdown(wait=False, cancel_futures=True)
        if not isinstance(stopped, KeyboardInterrupt):
            raise
        _blank(found, left.values())
        done = count - sum(piece.stop - piece.start for piece in left.values())
        raise interrupted(f"{done} of {count} poses", kind(*map(sealed, found))) from None
    return kind(*map(sealed, found))


def _in_order(pool: Executor, one: Callable[[int], int], starts: list[int]) -> Iterator[int]:
    """Yield results in their order, so that the first error is always the same."""
    for task in [pool.submit(one, at) for at in starts]:
        while not task.done():
            wait([task], _HEARING)
        yield task.result()


def _blank(found: Sequence[NDArray[Any]], pieces: Iterable[slice]) -> None:
    """Say of some pieces that they are not done."""
    for array in found:
        nothing = np.nan if array.dtype == np.float64 else Status.NOT_DONE
        for piece in pieces:
            array[piece] = nothing


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
