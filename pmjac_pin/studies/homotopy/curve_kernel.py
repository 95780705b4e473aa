"""The kernel that follows points of a curve, as `Curve` does without one."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.c_kernels import COUNT, NUMBER, POINTER, address, loaded
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.values.arrays import Array, Complex, aligned

_STEPS_IN_A_CALL = 64  # of each lane: some ten milliseconds, in which nothing can interrupt
_POINTS_OF_MEMORY = 9
_LANE = 5  # numbers of 8 bytes of a lane, the path first


class StepRules(NamedTuple):
    """How points are followed.

    Attributes
    ----------
    first, smallest : float
        Steps, of a path.
    arrived : float
        The share of a path at which it is at its end.
    close : float
        First correction, relative to the point: further away the step was too long.
    exact : float
        Last correction.
    most, corrections : int
        Of steps tried, and of Newton after each.
    """

    first: float
    smallest: float
    arrived: float
    close: float
    exact: float
    most: int
    corrections: int


@cache
def curve_kernel() -> ctypes.CDLL | None:
    """Return the kernel, None where none was built; it lets other threads run."""
    folder = "studies/homotopy"
    sources = (f"{folder}/curve_kernel.c", "algebra/tape_kernel.c", "algebra/lanes.h")
    return loaded(f"{folder}/_curve_kernel.so", *sources, pmjac_follow=(POINTER, COUNT))


class CurveInLanes:
    """Follows points of a line's curve, many at a time.

    Parameters
    ----------
    library : ctypes.CDLL
        The kernel.
    tape : Tape
        Points (X, h, t), and numbers of the line, to the rows of the derivatives, each with its
        equation last.
    numbers : ndarray of complex, shape (k,)
        Of the line.
    """

    def __init__(self, library: ctypes.CDLL, tape: Tape, numbers: Complex) -> None:
        self._library, self._tape, self._numbers = library, tape, numbers
        self._size = tape.inputs // 2 - len(numbers)

    def follow(
        self, points: Complex, planes: Complex, pulls: Complex, rules: StepRules
    ) -> tuple[Complex, Array]:
        """Return where points (b, size) are led by planes (b, size) that move by pulls.

        Planes are normals and offsets. The second are the shares of the way that they went.
        """
        points, share = points.copy(), np.zeros(len(points))
        given = [np.ascontiguousarray(each) for each in (planes, pulls)]
        memory = self._memory()
        walk = _Walk(*map(address, (*memory, points, share, *given)))
        walk.length, walk.size, walk.count = len(self._tape.code), self._size, len(points)
        walk.most_steps, walk.corrections = rules.most, rules.corrections
        walk.first_step, walk.smallest_step = rules.first, rules.smallest
        walk.arrived, walk.close, walk.exact = rules.arrived, rules.close, rules.exact
        while self._library.pmjac_follow(ctypes.byref(walk), _STEPS_IN_A_CALL):
            pass
        return points, share

    def _memory(self) -> tuple[NDArray[Any], ...]:
        """Return what the kernel works on: code, slots, inputs, matrix, memory and lanes."""
        tape, size, lanes = self._tape, self._size, int(self._library.pmjac_lanes())
        code, slots = np.ascontiguousarray(tape.code), aligned(tape.slots + 1, lanes)
        slots[: len(tape.constants)] = tape.constants[:, None]
        inputs = aligned(tape.inputs, lanes)
        inputs[2 * size :] = self._numbers.view(float)[:, None]
        matrix = aligned(2 * size * (size + 1), lanes)
        memory = aligned(2 * size * _POINTS_OF_MEMORY, lanes)
        return code, slots, inputs, matrix, memory, np.full((lanes, _LANE), -1, dtype=np.int64)


class _Walk(ctypes.Structure):
    """`Walk`."""

    _fields_ = (
        *((name, POINTER) for name in ("code", "slots", "inputs", "matrix", "memory", "lanes")),
        *((name, POINTER) for name in ("points", "share", "planes", "pulls")),
        *((name, COUNT) for name in ("length", "size", "count", "taken")),
        *((name, COUNT) for name in ("most_steps", "corrections")),
        *((name, NUMBER) for name in ("first_step", "smallest_step", "arrived")),
        *((name, NUMBER) for name in ("close", "exact")),
    )
