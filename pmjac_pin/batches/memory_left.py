"""Memory that large results have left, for the next ones of the same size.

What nobody sees any longer goes back to the system and comes anew, page by page. That takes as long
as the poses in it where a machine has its pages from a host. So it is kept here, and the system is
told that it may have it where memory runs short: then its pages come anew as well.
"""

from __future__ import annotations

import math
import mmap
import sys
from collections import deque
from contextlib import suppress
from typing import Any
from weakref import finalize

import numpy as np
from numpy.typing import DTypeLike, NDArray

LARGE = 1 << 25  # bytes: the C library keeps less for the next one itself
_MOST = 1 << 32  # bytes that are kept for others: the oldest go
_LEFT: deque[mmap.mmap] = deque(maxlen=24)  # arrays: those of some results


def in_memory_left(shape: tuple[int, ...], kind: DTypeLike) -> NDArray[Any]:
    """Return an array like an empty one, in memory that one of the same size has left, if any.

    Its own goes to another when it ends. Every view of it keeps it: so nothing that somebody sees
    is given away.
    """
    size = math.prod(shape) * np.dtype(kind).itemsize
    memory = (_taken(size) or _mapped(size)) if size else None
    if memory is None:
        _LEFT.clear()
        return np.empty(shape, kind)
    # Of a view of a view NumPy keeps the last array alone: behind this one there is none, and its
    # buffer keeps the memory from being closed.
    flat: NDArray[Any] = np.frombuffer(memory, kind)
    finalize(flat, _leave_to_next, memory).atexit = False
    return flat.reshape(shape)


def _taken(size: int) -> mmap.mmap | None:
    for _ in range(len(_LEFT)):
        try:
            memory = _LEFT.popleft()
        except IndexError:  # another thread has taken it
            return None
        if len(memory) == size:
            return memory
        _LEFT.append(memory)
    return None


def _mapped(size: int) -> mmap.mmap | None:
    if sys.platform != "linux":
        return None
    with suppress(OSError):
        memory = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
        with suppress(OSError):
            memory.madvise(mmap.MADV_HUGEPAGE)
        return memory
    return None


def _leave_to_next(memory: mmap.mmap) -> None:
    # Whenever an array ends, maybe within `_taken`: no lock, but operations that are whole.
    if len(memory) > _MOST:
        return
    with suppress(OSError):
        memory.madvise(mmap.MADV_FREE)
        _LEFT.append(memory)
    with suppress(IndexError):  # another thread has taken the last one
        while sum(map(len, tuple(_LEFT))) > _MOST:
            _LEFT.popleft()
