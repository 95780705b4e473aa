"""Interval arithmetic over arrays, rounded outwards: every result holds what it stands for.

NumPy's +, −, ×, / round to the nearest double, so that a result z is off by at most u|z|, u = 2⁻⁵³,
or by less than 1e-300 where it underflows; an end is moved outwards by 3u|z| + 1e-290, which also
covers the rounding of that move. A sum of n products, in whatever order NumPy or BLAS takes them,
is off by at most nu/(1 − nu) times the sum of their absolute values; its ends are moved by
(n + 3)u times that. NumPy's sine and cosine are taken to be right to 2⁻⁵⁰, eight units in the last
place of a number near 1. What overflows is not a number, and such an end bounds nothing.

Source: S. M. Rump, Verification methods, Acta Numerica 19 (2010), sections 2, 3 and 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmjac_pin.values.arrays import Array

_UNIT = 2.0**-53
_ABSOLUTE = 1e-290
_TRIGONOMETRY = 2.0**-50
_LARGEST_ANGLE = 1e6  # rad: beyond it, sine and cosine are anything in [−1, 1]
_TURN_SLACK = 1e-9  # turns: more than x / 2π is off by up to the largest angle


@dataclass(frozen=True, slots=True, eq=False)
class Intervals:
    """An array of closed intervals.

    Attributes
    ----------
    lower, upper : ndarray, of one shape

    Examples
    --------
    >>> third = Intervals.exact(1.0) / Intervals.exact(3.0)
    >>> bool(third.lower < third.upper), bool((third * Intervals.exact(3.0)).holds(1.0))
    (True, True)
    """

    lower: Array
    upper: Array

    @classmethod
    def exact(cls, values: ArrayLike) -> Intervals:
        """Return intervals that hold one double each."""
        array = np.asarray(values, dtype=float)
        return cls(array, array)

    @classmethod
    def stack(cls, parts: Sequence[Intervals], axis: int) -> Intervals:
        """Return intervals side by side along a new axis."""
        return cls(
            np.stack([part.lower for part in parts], axis),
            np.stack([part.upper for part in parts], axis),
        )

    @classmethod
    def join(cls, parts: Sequence[Intervals], axis: int = 0) -> Intervals:
        """Return intervals one after another along an axis."""
        return cls(
            np.concatenate([part.lower for part in parts], axis),
            np.concatenate([part.upper for part in parts], axis),
        )

    @property
    def shape(self) -> tuple[int, ...]:
        """The array's shape."""
        return self.lower.shape

    @property
    def middle(self) -> Array:
        """A double in each interval, near its middle."""
        middle = self.lower + 0.5 * (self.upper - self.lower)
        return np.minimum(np.maximum(middle, self.lower), self.upper)

    @property
    def width(self) -> Array:
        """The widths, rounded to the nearest."""
        return self.upper - self.lower

    @property
    def magnitude(self) -> Array:
        """The largest absolute values."""
        return np.maximum(np.abs(self.lower), np.abs(self.upper))

    def __getitem__(self, index: Any) -> Intervals:
        return Intervals(self.lower[index], self.upper[index])

    def __neg__(self) -> Intervals:
        return Intervals(-self.upper, -self.lower)

    def __add__(self, other: Intervals) -> Intervals:
        return _outward(self.lower + other.lower, self.upper + other.upper)

    def __sub__(self, other: Intervals) -> Intervals:
        return _outward(self.lower - other.upper, self.upper - other.lower)

    def __mul__(self, other: Intervals) -> Intervals:
        return _hull(
            self.lower * other.lower,
            self.lower * other.upper,
            self.upper * other.lower,
            self.upper * other.upper,
        )

    def __truediv__(self, other: Intervals) -> Intervals:
        """Divide by intervals without 0; by others, the quotient is [−inf, inf]."""
        possible = (other.lower > 0.0) | (other.upper < 0.0)
        lower, upper = np.where(possible, other.lower, 1.0), np.where(possible, other.upper, 1.0)
        quotient = _hull(
            self.lower / lower, self.lower / upper, self.upper / lower, self.upper / upper
        )
        return Intervals(
            np.where(possible, quotient.lower, -np.inf), np.where(possible, quotient.upper, np.inf)
        )

    def square(self) -> Intervals:
        """Return {x²}, tighter than self * self."""
        one, other = self.lower * self.lower, self.upper * self.upper
        straddles = (self.lower < 0.0) & (self.upper > 0.0)
        wide = _outward(np.minimum(one, other), np.maximum(one, other))
        return Intervals(np.where(straddles, 0.0, np.maximum(wide.lower, 0.0)), wide.upper)

    def sqrt(self) -> Intervals:
        """Return {√x} of what is not negative: NumPy's roots are rounded to the nearest."""
        found = _outward(np.sqrt(np.maximum(self.lower, 0.0)), np.sqrt(self.upper))
        return Intervals(np.maximum(found.lower, 0.0), found.upper)

    def sum(self, axis: int) -> Intervals:
        """Return the sum along an axis."""
        size = _sum_error(self.shape[axis], self.magnitude.sum(axis))
        return Intervals(self.lower.sum(axis) - size, self.upper.sum(axis) + size)

    def cos(self) -> Intervals:
        """Return {cos x}, x in rad."""
        return _wave_between(self, np.cos(self.lower), np.cos(self.upper), 0.0)

    def sin(self) -> Intervals:
        """Return {sin x}, x in rad."""
        return _wave_between(self, np.sin(self.lower), np.sin(self.upper), 0.25)

    def after(self, matrix: Array) -> Intervals:
        """Return matrix @ self, the matrix of doubles."""
        positive, negative = np.maximum(matrix, 0.0), np.minimum(matrix, 0.0)
        size = _sum_error(matrix.shape[-1] + 1, np.abs(matrix) @ self.magnitude)
        return Intervals(
            positive @ self.lower + negative @ self.upper - size,
            positive @ self.upper + negative @ self.lower + size,
        )

    def widened(self, by: float | Array) -> Intervals:
        """Return intervals that reach further by this much at both ends."""
        return _outward(self.lower - by, self.upper + by)

    def meet(self, other: Intervals) -> Intervals:
        """Return the intersections: empty where lower > upper."""
        return Intervals(np.maximum(self.lower, other.lower), np.minimum(self.upper, other.upper))

    def meets(self, other: Intervals) -> NDArray[np.bool_]:
        """Tell where two intervals have a number in common; True where one is not a number."""
        return ~((self.lower > other.upper) | (other.lower > self.upper))

    def inside(self, other: Intervals) -> NDArray[np.bool_]:
        """Tell where these intervals are in the interior of the others."""
        return (self.lower > other.lower) & (self.upper < other.upper)

    def holds(self, values: float | Array) -> NDArray[np.bool_]:
        """Tell where the intervals hold these doubles."""
        return np.asarray((self.lower <= values) & (values <= self.upper))


def hull(boxes: Intervals) -> Intervals:
    """Return the smallest intervals that hold all of those along the first axis."""
    return Intervals(boxes.lower.min(axis=0), boxes.upper.max(axis=0))


def _outward(lower: Array, upper: Array) -> Intervals:
    return Intervals(
        lower - (np.abs(lower) * (3.0 * _UNIT) + _ABSOLUTE),
        upper + (np.abs(upper) * (3.0 * _UNIT) + _ABSOLUTE),
    )


def _hull(*ends: Array) -> Intervals:
    a, b, c, d = ends
    return _outward(
        np.minimum(np.minimum(a, b), np.minimum(c, d)),
        np.maximum(np.maximum(a, b), np.maximum(c, d)),
    )


def _sum_error(terms: int, size: Array) -> Array:
    """Return more than a sum of `terms` products of this absolute size can be off by."""
    return size * ((terms + 3) * _UNIT) + _ABSOLUTE


def _wave_between(angles: Intervals, one: Array, other: Array, top: float) -> Intervals:
    """Return what a wave with a maximum 1 at `top` turns does between two of its values."""
    lower, upper = angles.lower / (2.0 * np.pi), angles.upper / (2.0 * np.pi)

    def reached(turns: float) -> NDArray[np.bool_]:
        first = np.ceil(lower - turns - _TURN_SLACK)
        return np.asarray(first <= np.floor(upper - turns + _TURN_SLACK))

    least = np.maximum(np.minimum(one, other) - _TRIGONOMETRY, -1.0)
    largest = np.minimum(np.maximum(one, other) + _TRIGONOMETRY, 1.0)
    far = ~(angles.magnitude <= _LARGEST_ANGLE)
    return Intervals(
        np.where(far | reached(top + 0.5), -1.0, least), np.where(far | reached(top), 1.0, largest)
    )
