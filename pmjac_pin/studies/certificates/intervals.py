"""Intervals: NumPy arrays of Arb's numbers, each a middle and a radius that holds all rounding.

Arb (python-flint) rounds outwards whatever its working precision is, so that nothing here
depends on that of the process.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from flint import arb, ctx
from numpy.typing import ArrayLike, NDArray

Intervals = NDArray[np.object_]  # of flint.arb

#: How far placements may be from the model's, relative to their size: four units in the last
#: place, more than the rounding of a URDF's numbers and of the matrices made of them.
PLACEMENT_WIDTH = 4.0 * float(np.finfo(float).eps)

#: Far above the rounding of the few thousand sums and products of numbers ≥ 0 that it covers.
OUTWARDS = 1.0 + 1e-10

ZERO, ONE = arb(0), arb(1)

_lock = threading.RLock()


@contextmanager
def precise() -> Iterator[None]:
    """Work with twice a double's digits: long products of rotations would widen otherwise.

    Arb's precision is that of the whole process, so that only one thread at a time may set it.
    """
    with _lock, ctx.workprec(106):
        yield


def exactly(numbers: ArrayLike) -> Intervals:
    """Return doubles as they are, as intervals without width."""
    values = np.asarray(numbers, dtype=float)
    exact: Intervals = np.empty(values.shape, dtype=object)
    exact.ravel()[:] = [arb(value) for value in values.ravel().tolist()]
    return exact


def rod_length(number: float) -> arb:
    """Return a length in m, up to `PLACEMENT_WIDTH` of it."""
    return arb(number, PLACEMENT_WIDTH * abs(number))


def rotation_width(matrix: ArrayLike) -> float:
    """Return how far, in the spectral norm, a rotation may be from the stored one.

    That is `PLACEMENT_WIDTH` more than it takes to reach the nearest exact rotation: the polar
    factor U of P has ‖P − U‖ ≤ ‖PPᵀ − I‖, since each singular value σ of P has |σ − 1| ≤ |σ² − 1|.
    Fewer rows, of unit length and perpendicular, do as well.
    """
    stored = exactly(matrix)
    defect = upper(norm((stored @ stored.T - np.eye(len(stored))).ravel()))
    return PLACEMENT_WIDTH + defect


def widened(numbers: Intervals, width: float) -> Intervals:
    """Return intervals that are wider by this at both ends."""
    wide: Intervals = numbers + arb(0, width)
    return wide


def unit_rows(matrix: ArrayLike) -> Intervals:
    """Return unit vectors, perpendicular to each other, one a row, as wide as a rotation's."""
    return widened(exactly(matrix), rotation_width(matrix))


def about_z(cosine: arb, sine: arb) -> Intervals:
    """Return a turn about z."""
    return np.array([[cosine, -sine, ZERO], [sine, cosine, ZERO], [ZERO, ZERO, ONE]], dtype=object)


def of_quaternion(entries: ArrayLike) -> Intervals:
    """Return the rotation of a quaternion (x, y, z, w), which is divided by its length."""
    x, y, z, w = exactly(entries)
    s = 2 / (x * x + y * y + z * z + w * w)
    return np.array(
        [
            [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
            [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
            [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
        ],
        dtype=object,
    )


def cross(one: Intervals, other: Intervals) -> Intervals:
    """Return the cross product of two vectors; NumPy's own takes ten times as long."""
    (a, b, c), (x, y, z) = one, other
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x], dtype=object)


def norm(vector: Intervals) -> arb:
    """Return the Euclidean norm."""
    return sum((entry * entry for entry in vector), ZERO).nonnegative_part().sqrt()


def upper(number: arb) -> float:
    """Return a double that is not below the number; infinite where nothing is known."""
    value = float(number.upper())
    return math.inf if math.isnan(value) else math.nextafter(value, math.inf)


def uppers(numbers: Intervals) -> NDArray[np.float64]:
    """Return doubles that are not below the numbers' sizes."""
    sizes = [upper(abs(number)) for number in numbers.ravel()]
    return np.array(sizes, dtype=float).reshape(numbers.shape)


def middles(numbers: Intervals) -> NDArray[np.float64]:
    """Return the middles as doubles, of which nothing is promised."""
    return np.array([float(number.mid()) for number in numbers.ravel()]).reshape(numbers.shape)
