"""Pursuit: one question at a time, answered in a thread of its own while a loop goes on."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Generic, TypeVar

from pmjac_pin.errors import PmjacError
from pmjac_pin.viewer.worker import Worker

Answer = TypeVar("Answer")
_logger = logging.getLogger(__name__)


class Pursuit(ABC, Generic[Answer]):
    """Looks for an answer in a thread, and brings it to the loop if it is still wanted there.

    Parameters
    ----------
    what : str
        Is going on: "search", such as.
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._worker = Worker(f"pmjac {what}")
        self._unwanted: threading.Event | None = None  # set when nobody wants the answer any more
        self._found: Answer | None = None

    @property
    def going(self) -> bool:
        """Whether an answer is still to come."""
        return self._unwanted is not None

    @property
    def known(self) -> bool:
        """Whether there is anything to tell a page that has just been opened."""
        return self.going or self._found is not None

    def stop(self) -> None:
        """Want the answer no more, silently."""
        if self._unwanted is not None:
            self._unwanted.set()
            self._unwanted = None

    @abstractmethod
    def _finish(self, answer: Answer) -> None:
        """Take the answer, in the loop's thread."""

    @abstractmethod
    def _refused(self, why: str) -> Answer:
        """Return the answer that there is none."""

    def _begin(self, find: Callable[[Callable[[], bool]], Answer]) -> None:
        """Look for an answer, instead of what was looked for; called within the loop.

        Parameters
        ----------
        find : callable
            Given a function that tells whether the answer is still wanted.
        """
        self.stop()
        loop = asyncio.get_running_loop()
        self._found = None
        self._unwanted = unwanted = threading.Event()

        def finish(answer: Answer) -> None:
            if unwanted is self._unwanted:
                self._unwanted = None
                self._finish(answer)

        def work() -> None:
            if unwanted.is_set():  # while it waited for its turn
                return
            answer = self._answered(lambda: find(lambda: not unwanted.is_set()))
            with contextlib.suppress(RuntimeError):  # the server has ended meanwhile
                loop.call_soon_threadsafe(finish, answer)

        self._worker.do(work)

    def _answered(self, find: Callable[[], Answer]) -> Answer:
        try:
            return find()
        except PmjacError as error:
            return self._refused(str(error))
        except Exception:
            _logger.exception("the %s failed", self._what)
            return self._refused(f"The {self._what} failed; see the log of the server.")
