"""Worker: one thread for long work, of which only the newest is wanted."""

from __future__ import annotations

import threading
from collections.abc import Callable


class Worker:
    """Does one thing at a time, in a thread that ends when there is nothing to do.

    Parameters
    ----------
    name : str
        The thread's.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._lock = threading.Lock()
        self._next: Callable[[], None] | None = None
        self._busy = False

    def do(self, work: Callable[[], None]) -> None:
        """Do this as soon as what is being done has ended; what still waited is forgotten."""
        with self._lock:
            self._next = work
            if self._busy:
                return
            self._busy = True
        threading.Thread(target=self._run, name=self._name, daemon=True).start()

    def _run(self) -> None:
        while (work := self._taken()) is not None:
            work()

    def _taken(self) -> Callable[[], None] | None:
        with self._lock:
            work, self._next = self._next, None
            self._busy = work is not None
            return work
