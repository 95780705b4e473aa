"""Spares: what one thread works with at a time, kept for the next one that needs it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

Work = TypeVar("Work")


class Spares(Generic[Work]):
    """Things that threads work with, as many as have worked at once.

    Threads come and go with each call. What they need longer to make stays.

    Parameters
    ----------
    make : callable
        Makes another one.

    Examples
    --------
    >>> spares = Spares(list)
    >>> mine = spares.take()
    >>> spares.put_back(mine)
    >>> spares.take() is mine
    True
    """

    __slots__ = ("_kept", "_make")

    def __init__(self, make: Callable[[], Work]) -> None:
        self._make, self._kept = make, deque[Work]()

    def take(self) -> Work:
        """Return one that nobody else has."""
        try:
            return self._kept.pop()
        except IndexError:
            return self._make()

    def put_back(self, one: Work) -> None:
        """Leave it to others."""
        self._kept.append(one)
