"""Pursuit: one question at a time, answered in a thread of its own while a loop goes on."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from pmjac_pin.viewer.worker import Worker

Answer = TypeVar("Answer")


class Pursuit(Generic[Answer]):
    """Looks for an answer in a thread, and brings it to the loop if it is still wanted there.

    Parameters
    ----------
    name : str
        The thread's.
    """

    def __init__(self, name: str) -> None:
        self._worker = Worker(name)
        self._unwanted: threading.Event | None = None  # set when nobody wants the answer any more

    @property
    def going(self) -> bool:
        """Whether an answer is still to come."""
        return self._unwanted is not None

    def begin(
        self, find: Callable[[Callable[[], bool]], Answer], then: Callable[[Answer], None]
    ) -> None:
        """Look for an answer, instead of what was looked for; called within the loop.

        Parameters
        ----------
        find : callable
            Given a function that tells whether the answer is still wanted.
        then : callable
            Called with the answer, in the loop's thread.
        """
        self.stop()
        loop = asyncio.get_running_loop()
        self._unwanted = unwanted = threading.Event()

        def finish(answer: Answer) -> None:
            if unwanted is self._unwanted:
                self._unwanted = None
                then(answer)

        def work() -> None:
            if unwanted.is_set():  # while it waited for its turn
                return
            answer = find(lambda: not unwanted.is_set())
            with contextlib.suppress(RuntimeError):  # the server has ended meanwhile
                loop.call_soon_threadsafe(finish, answer)

        self._worker.do(work)

    def stop(self) -> None:
        """Want the answer no more."""
        if self._unwanted is not None:
            self._unwanted.set()
            self._unwanted = None
