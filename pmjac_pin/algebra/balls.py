"""Balls: NumPy arrays of Arb's numbers, each a middle and a radius that holds all rounding.

Arb (python-flint) rounds outwards whatever its working precision is, so that nothing here
depends on that of the process.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache

import numpy as np
from flint import arb, ctx
from numpy.typing import ArrayLike, NDArray

from pmjac_pin.algebra.arrays import Arrays
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.values.arrays import Array

BallArray = NDArray[np.object_]  # of flint.arb

_EPS = float(np.finfo(float).eps)

#: How far placements may be from the model's, relative to their size: four units in the last
#: place, more than the rounding of a URDF's numbers and of the matrices made of them.
PLACEMENT_WIDTH = 4.0 * _EPS

#: Far above the rounding of the few thousand sums and products of numbers ≥ 0 that it covers.
OUTWARDS = 1.0 + 1e-10

ZERO = arb(0)

_lock = threading.RLock()


class Balls(Arrays):
    """Real balls.

    Examples
    --------
    >>> balls = Balls()
    >>> x = balls.constant([0.5])
    >>> bool(balls.squared(balls.stack([balls.cos(x[0]), balls.sin(x[0])]))[0, 0].contains(1))
    True
    """

    __slots__ = ()

    def exact(self, values: Array) -> BallArray:
        """Return doubles as they are."""
        return exactly(values)

    def measured(self, values: ArrayLike) -> BallArray:
        """Return lengths, each up to `PLACEMENT_WIDTH` of it."""
        flat = np.asarray(values, dtype=float)
        found = np.empty(flat.shape, dtype=object)
        found.ravel()[:] = [arb(x, PLACEMENT_WIDTH * abs(x)) for x in flat.ravel().tolist()]
        return found[..., None, None]

    def directed(self, directions: Array, x: BallArray) -> BallArray:
        """Return directions @ x for axes x, as wide as unit vectors may be."""
        return widened(self.times(directions, x), rotation_width(directions))

    def cos(self, x: BallArray) -> BallArray:
        """Return cos x."""
        return _of_each_ball(x, arb.cos)

    def sin(self, x: BallArray) -> BallArray:
        """Return sin x."""
        return _of_each_ball(x, arb.sin)

    def unit(self, x: BallArray) -> BallArray:
        """Return x by its length, over the first components."""
        return np.asarray(x / _of_each_ball(self.squared(x), arb.sqrt))


@contextmanager
def precise() -> Iterator[None]:
    """Work with twice a double's digits: long products of rotations would widen otherwise.

    Arb's precision is that of the whole process, so that only one thread at a time may set it.
    """
    with _lock, ctx.workprec(106):
        yield


def exactly(numbers: ArrayLike) -> BallArray:
    """Return doubles as they are, as intervals without width."""
    values = np.asarray(numbers, dtype=float)
    exact: BallArray = np.empty(values.shape, dtype=object)
    exact.ravel()[:] = [arb(value) for value in values.ravel().tolist()]
    return exact


def rotation_width(matrix: ArrayLike) -> float:
    """Return how far, in the spectral norm, a rotation may be from the stored one.

    That is `PLACEMENT_WIDTH` more than it takes to reach the nearest exact rotation: the polar
    factor U of P has ‖P − U‖ ≤ ‖PPᵀ − I‖, since each singular value σ of P has |σ − 1| ≤ |σ² − 1|.
    Fewer rows, of unit length and perpendicular, do as well.
    """
    stored = np.asarray(matrix, dtype=float)
    return _rotation_width(stored.tobytes(), stored.shape)


@lru_cache(maxsize=4096)
def _rotation_width(entries: bytes, shape: tuple[int, ...]) -> float:
    with precise():
        stored = exactly(np.frombuffer(entries).reshape(shape))
        return PLACEMENT_WIDTH + upper(
            euclidean_norm((stored @ stored.T - np.eye(len(stored))).ravel())
        )


def widened(numbers: BallArray, width: float) -> BallArray:
    """Return intervals that are wider by this at both ends."""
    wide: BallArray = numbers + arb(0, width)
    return wide


def _of_each_ball(x: BallArray, of: Callable[[arb], arb]) -> BallArray:
    found: BallArray = np.empty(x.shape, dtype=object)
    found.ravel()[:] = [of(ball) for ball in x.ravel()]
    return found


def euclidean_norm(vector: BallArray) -> arb:
    """Return the Euclidean norm."""
    return sum((entry * entry for entry in vector), ZERO).nonnegative_part().sqrt()


def upper(number: arb) -> float:
    """Return a double that is not below the number; infinite where nothing is known."""
    value = float(number.upper())
    return math.inf if math.isnan(value) else math.nextafter(value, math.inf)


def uppers(numbers: BallArray) -> NDArray[np.float64]:
    """Return doubles that are not below the numbers' sizes."""
    sizes = [upper(abs(number)) for number in numbers.ravel()]
    return np.array(sizes, dtype=float).reshape(numbers.shape)


def enclosing(numbers: BallArray) -> Intervals:
    """Return intervals between doubles that hold the balls."""
    balls = [(float(number), float(number.rad())) for number in numbers.ravel()]
    middle, radius = np.array(balls, dtype=float).reshape(-1, 2).T.reshape(2, *numbers.shape)
    # A middle is rounded to the nearest double, a radius has fewer digits than one.
    return Intervals.exact(middle).widened(OUTWARDS * (radius + _EPS * np.abs(middle)))
