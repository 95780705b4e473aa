"""What was made lately, by the bytes that it was made of."""

from __future__ import annotations

from collections.abc import Callable
from itertools import accumulate
from typing import Any, Generic, NamedTuple, TypeVar

MadeValue = TypeVar("MadeValue")


class _Made(NamedTuple, Generic[MadeValue]):
    said: bytes
    beside: tuple[Any, ...]
    value: MadeValue


class MadeLately(Generic[MadeValue]):
    """The last few values that were made: one that is asked for again is not made again.

    They are known by all of their bytes, not by a digest. Threads need no lock, and none is left
    held where a process forks: two that ask for the same at the same time may both make it.

    Parameters
    ----------
    most, most_bytes : int
        How many are kept, and of how many bytes together; one that is made of more than half of
        these is not, and does not displace the others.

    Examples
    --------
    >>> lately = MadeLately(most=2, most_bytes=100)
    >>> first = lately.of(b"1 2", (), lambda: [1, 2])
    >>> lately.of(b"1 2", (), lambda: [1, 2]) is first
    True
    """

    def __init__(self, most: int, most_bytes: int) -> None:
        self._most, self._most_bytes = most, most_bytes
        self._kept: tuple[_Made[MadeValue], ...] = ()

    def of(self, said: bytes, beside: tuple[Any, ...], make: Callable[[], MadeValue]) -> MadeValue:
        """Return what was made of these bytes, or make it.

        Parameters
        ----------
        said : bytes
        beside : tuple
            What else it depends on.
        make : callable
        """
        asked = self._kept
        for made in asked:
            if made.said == said and made.beside == beside:
                if made is not asked[0]:
                    self._keep(made)
                return made.value
        value = make()
        self._keep(_Made(said, beside, value))
        return value

    def clear(self) -> None:
        """Forget all of them."""
        self._kept = ()

    def _keep(self, made: _Made[MadeValue]) -> None:
        if 2 * len(made.said) > self._most_bytes:
            return
        kept = (made, *(one for one in self._kept if one is not made))[: self._most]
        sizes = accumulate(len(one.said) for one in kept)
        self._kept = kept[: sum(size <= self._most_bytes for size in sizes)]
