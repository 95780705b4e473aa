"""Crossings: where a number along a path passes a threshold, from its values and rates.

Between two parameters the cubic with the same values and rates lies within its Bernstein
coefficients. Where these are clear of the threshold, by a tenth of what they differ by, nothing
crosses; where they ascend or descend through it, one crossing is found by bracketing; all else is
halved.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import NamedTuple, TypeAlias

from scipy.optimize import brentq

#: t ↦ value and rate.
Watched: TypeAlias = Callable[[float], tuple[float, float]]

_CLEAR = 0.1  # of what the coefficients differ by
_MOST_HALVINGS = 40
_SHARP = 1e-15  # of t, where it is found
_SMALLEST_T = 1e-3  # of t: near 0 it is found to a share of this
_RELATIVE = 4e-15
_STRIDES = 40


class IntervalEnds(NamedTuple):
    """Values and rates of a number at both ends of an interval, and its width."""

    first: float
    leaving: float
    last: float
    arriving: float
    width: float

    def coefficients(self) -> tuple[float, float, float, float]:
        """Return the Bernstein coefficients of the cubic with these values and rates."""
        third = self.width / 3.0
        near, far = self.first + third * self.leaving, self.last - third * self.arriving
        return self.first, near, far, self.last

    def may_pass(self, threshold: float) -> bool:
        """Tell whether the number may pass a threshold between the ends."""
        coefficients = self.coefficients()
        low, high = min(coefficients), max(coefficients)
        margin = _CLEAR * (high - low)
        return low - margin <= threshold < high + margin

    def ascends(self) -> bool:
        """Tell whether the cubic ascends, or descends, all the way."""
        steps = [after - before for before, after in pairwise(self.coefficients())]
        return min(steps) >= 0.0 or max(steps) <= 0.0


def slack_crossings(
    watched: Watched, start: float, end: float, slack: float, halvings: int = _MOST_HALVINGS
) -> Iterator[float]:
    """Yield where a value becomes more than `slack` above 0, or less: there it is the slack.

    Parameters
    ----------
    watched : callable
    start, end : float
    slack : float
        Values up to this count as not above 0.
    halvings : int
        How often intervals are halved at most.
    """
    ends = IntervalEnds(*watched(start), *watched(end), end - start)
    if not ends.may_pass(slack):
        return
    passes = (ends.first > slack) != (ends.last > slack)
    if passes and (ends.ascends() or not halvings):
        yield located(lambda t: watched(t)[0] - slack, start, end)
    elif halvings:
        middle = 0.5 * (start + end)
        yield from slack_crossings(watched, start, middle, slack, halvings - 1)
        yield from slack_crossings(watched, middle, end, slack, halvings - 1)


def zero_beside(watched: Watched, t: float, start: float, end: float) -> float:
    """Return where a value is 0 beside a t at which it is the slack, within an interval.

    It ascends or descends there; of values above 0 up to an end of the interval, the end is told.
    """
    value, rate = watched(t)
    stride = -2.0 * value / rate if rate else 0.0
    for _ in range(_STRIDES):
        there = min(max(t + stride, start), end)
        if watched(there)[0] <= 0.0:
            return located(lambda t: watched(t)[0], *sorted((t, there)))
        if there in (start, end):
            return there
        stride *= 2.0
    return t


def located(value: Callable[[float], float], start: float, end: float) -> float:
    """Return where a value is 0 between two parameters, at which its signs differ."""
    sharp = _SHARP * max(abs(start), abs(end), _SMALLEST_T)
    first, last = value(start), value(end)
    if (first > 0.0 < last) or (first < 0.0 > last):
        raise ArithmeticError(f"no change of sign between t = {start!r} and {end!r}")
    if not (size := max(abs(first), abs(last))):
        return start
    # Products of very small values underflow, to what SciPy takes for no change of sign.
    found: float = brentq(lambda t: value(t) / size, start, end, xtol=sharp, rtol=_RELATIVE)
    return found
