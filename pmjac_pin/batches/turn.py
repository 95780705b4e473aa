"""Turns: whose turn it is to fill results again."""

from __future__ import annotations

from collections.abc import Sequence

from pmjac_pin.batches.rest import Rest


class RefillTurn:
    """A call's turn to fill results, one of a kind: others are refused until it is over.

    Threads may ask at the same time, and somebody interrupt between any two steps. So it is over
    for all of its results by one operation, and whoever is first behind it has the next turn by one
    operation of a dictionary, which is whole.

    Attributes
    ----------
    has_ended : bool
        Whether the call is done.
    helpers : sequence of Rest
        Of threads that help it, which may still write.

    Examples
    --------
    >>> first, mine, other = RefillTurn(), RefillTurn(), RefillTurn()
    >>> first.has_ended = True
    >>> mine.is_behind(first, dict), other.is_behind(first, dict)
    (True, False)
    >>> mine.has_ended = True
    >>> other.is_behind(first, dict)
    True
    """

    __slots__ = ("_next", "has_ended", "helpers")

    def __init__(self) -> None:
        self.has_ended = False
        self.helpers: Sequence[Rest] = ()
        self._next: dict[type, RefillTurn] = {}

    @property
    def is_over(self) -> bool:
        """Whether nobody writes to its results any longer."""
        if not self.helpers:
            return self.has_ended
        return self.has_ended and not any(rest.is_busy for rest in self.helpers)

    def is_behind(self, last: RefillTurn, kind: type) -> bool:
        """Take this turn behind another, or those that have come after it, if they are over."""
        while last is not self:
            if not last.is_over:
                return False
            last = last._next.setdefault(kind, self)
        return True
