"""Chunks: arrays are filled piece by piece, by several threads, so that memory stays bounded."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import Any, TypeAlias

from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError, quoted

CHUNK = 4096  # poses: they fill the kernel's lanes, and some MB
Progress: TypeAlias = Callable[[int, int], object]


def fill(
    found: Sequence[NDArray[Any]],
    work: Callable[[slice], Sequence[NDArray[Any]]],
    threads: int | None,
    progress: Progress | None = None,
) -> None:
    """Fill arrays (N, ...) with what work returns for their pieces.

    Where the pieces end depends on N alone. When this is interrupted, those begun are finished.
    """
    count = len(found[0])

    def one(piece: slice) -> int:
        for whole, part in zip(found, work(piece), strict=True):
            whole[piece] = part
        return len(found[0][piece])

    pieces = [slice(at, min(at + CHUNK, count)) for at in range(0, count, CHUNK)]
    done = 0
    with ThreadPoolExecutor(thread_count(threads)) as pool:
        tasks = [pool.submit(one, piece) for piece in pieces]
        try:
            for task in as_completed(tasks):
                done += task.result()
                if progress is not None:
                    progress(done, count)
        finally:
            for task in tasks:
                task.cancel()


def thread_count(given: int | None) -> int:
    """Return how many threads: all cores that this process may use, unless told."""
    if given is None:
        allowed = getattr(os, "sched_getaffinity", None)  # not on every system
        return len(allowed(0)) if allowed else os.cpu_count() or 1
    if isinstance(given, bool) or not isinstance(given, int) or given < 1:
        raise ArgumentError(f"threads must be a whole number ≥ 1 or None, got {quoted(given)}")
    return given
