"""Turns: whose turn it is to fill results again."""

from __future__ import annotations

from collections.abc import Sequence

from pmjac_pin.batches.rest import Rest


class RefillTurn:
    """A call's turn to fill results, one of a kind: others are refused until it is over.

    Attributes
    ----------
    has_ended : bool
        Whether the call is done.
    helpers : sequence of Rest
        Of threads that help it, which may still write.
    followed : dict
        By what it is followed, or that this is long past (None), of each kind of its results.
    """

    __slots__ = ("followed", "has_ended", "helpers")

    def __init__(self) -> None:
        self.has_ended = False
        self.helpers: Sequence[Rest] = ()
        self.followed: dict[type, RefillTurn | None] = {}

    @property
    def is_over(self) -> bool:
        """Whether nobody writes to its results any longer."""
        if not self.helpers:
            return self.has_ended
        return self.has_ended and not any(rest.is_busy for rest in self.helpers)


class Turns:
    """Turns to fill one result, of which the last is known.

    Threads may ask at the same time, and somebody interrupt between any two steps. So a turn is
    over for all of its results by one operation, and whoever is first behind it has the next one by
    one operation of a dictionary, which is whole.

    Examples
    --------
    >>> first, mine, other = RefillTurn(), RefillTurn(), RefillTurn()
    >>> turns = Turns(first)
    >>> first.has_ended = True
    >>> turns.go_on_with(mine, dict), turns.go_on_with(other, dict)
    (True, False)
    >>> mine.has_ended = True
    >>> turns.go_on_with(other, dict)
    True
    """

    __slots__ = ("_last",)

    def __init__(self, first: RefillTurn) -> None:
        self._last = first

    def go_on_with(self, turn: RefillTurn, kind: type) -> bool:
        """Have a turn behind the last one of a result of some kind, if that is over."""
        before, last = self._last, self._last
        while last is not turn:
            if not last.is_over:
                return False
            following = last.followed.setdefault(kind, turn)
            before, last = last, self._last if following is None else following
        if before is not turn:
            self._last = turn
            before.followed[kind] = None  # else the first of many turns would keep all others
        return True
