"""Rest: where helping threads come to rest, and how their caller waits for it."""

from __future__ import annotations

from _thread import allocate_lock
from collections.abc import Sequence

_HEARING = 0.2  # s: what waits for another thread does not hear every signal


class Rest:
    """Where a thread comes to rest, while somebody waits who may be interrupted at any moment.

    `threading.Event` waits by locks of its own, which an interrupt can leave taken.

    Attributes
    ----------
    is_busy : bool
        Whether the thread has begun, and is not at rest.
    """

    __slots__ = ("_lock", "_reached", "is_busy")

    def __init__(self) -> None:
        self._lock, self._reached, self.is_busy = allocate_lock(), False, False
        self._lock.acquire()

    def reach(self) -> None:
        """Say that the thread is at rest."""
        self.is_busy, self._reached = False, True
        self._lock.release()

    def wait(self) -> None:
        """Wait for that; who was interrupted with the lock in his hands knows it by the other."""
        while not self._reached:
            self._lock.acquire(timeout=_HEARING)


def wait_for(threads: Sequence[Rest]) -> None:
    """Wait until all are at rest."""
    for rest in threads:
        rest.wait()


def wait_whatever_happens(threads: Sequence[Rest]) -> None:
    """Wait until all are at rest, however often somebody interrupts.

    But between two steps of this function itself: so what they write to is nobody else's before
    they are (`RefillTurn`).
    """
    while True:
        try:
            wait_for(threads)
        except KeyboardInterrupt:
            continue
        return
