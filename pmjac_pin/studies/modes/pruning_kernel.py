"""The kernel that encloses loop equations over boxes, and narrows these to where they can hold."""

from __future__ import annotations

import ctypes
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.c_kernels import COUNT, POINTER, address, loaded
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.values.arrays import Array


@cache
def pruning_kernel() -> ctypes.CDLL | None:
    """Return the kernel, None where none was built; it lets other threads run."""
    folder = "studies/modes"
    own = (f"{folder}/{name}" for name in ("pruning_kernel.c", "boxes_in_lanes.h", "narrowing.h"))
    tapes = ("algebra/interval_tape.c", "algebra/tape_kernel.c", "algebra/lanes.h")
    built, takes = f"{folder}/_pruning_kernel.so", (POINTER, COUNT, POINTER, POINTER, POINTER)
    return loaded(built, *own, *tapes, pmjac_enclose=takes, pmjac_prune=takes)


class _Program(ctypes.Structure):
    """`Program`."""

    _fields_ = (
        ("code", POINTER),
        ("constants", POINTER),
        *((name, COUNT) for name in ("length", "known", "slots")),
    )


class _Loops(ctypes.Structure):
    """`Loops`."""

    _fields_ = (
        ("whole", _Program),
        ("values", _Program),
        *((name, POINTER) for name in ("given", "tolerance", "scale")),
        *((name, COUNT) for name in ("fixed", "unknowns", "rows", "cosines")),
        ("progress", ctypes.c_double),
    )


class LoopsInLanes:
    """Encloses p rows of k unknowns over many boxes, and narrows these.

    Parameters
    ----------
    library : ctypes.CDLL
        The kernel.
    whole, values : Tape
        The unknowns and intervals that are the same for all boxes, to the rows, their derivatives,
        row by row, and cosines; and to the rows alone.
    given : Intervals, shape (f,)
        What is the same for all boxes.
    tolerance : ndarray, shape (p,)
        How far each row may be from 0.
    """

    def __init__(
        self, library: ctypes.CDLL, whole: Tape, values: Tape, given: Intervals, tolerance: Array
    ) -> None:
        self._library, self._outputs = library, whole.outputs
        self._unknowns = whole.inputs - len(given.lower)
        ends = np.column_stack([given.lower, given.upper])
        programs, kept = zip(*map(_program, (whole, values)), strict=True)
        self._kept: list[Any] = [kept, ends, np.array(tolerance, dtype=float)]
        self._loops = _Loops(*programs, *map(address, self._kept[1:]))
        rows, unknowns = len(tolerance), self._unknowns
        self._loops.fixed, self._loops.unknowns, self._loops.rows = len(ends), unknowns, rows
        self._loops.cosines = whole.outputs - rows * (unknowns + 1)

    def enclose(self, boxes: Intervals) -> Intervals:
        """Return the outputs of `whole` over boxes (b, k), shape (outputs, b)."""
        lower, upper = (np.array(end, dtype=float, order="C") for end in (boxes.lower, boxes.upper))
        count = len(lower)
        found = np.empty((self._outputs, 2, count))
        arrays = map(address, (lower, upper, found))
        if self._library.pmjac_enclose(ctypes.byref(self._loops), count, *arrays):
            raise MemoryError("no memory for intervals")
        return Intervals(found[:, 0], found[:, 1])

    def narrowed(
        self, boxes: Intervals, scale: Array, progress: float
    ) -> tuple[Intervals, NDArray[np.int32]]:
        """Return boxes (b, k) narrowed, and what becomes of each.

        That is −2 where it holds no solution, −1 where its largest width, by `scale`, has got to at
        most the share `progress`, else which unknown the rows feel most.
        """
        lower, upper = (np.array(end, dtype=float, order="C") for end in (boxes.lower, boxes.upper))
        cut = np.empty(len(lower), dtype=np.int32)
        scale = np.array(scale, dtype=float)
        self._loops.scale, self._loops.progress = address(scale), progress
        arrays = map(address, (lower, upper, cut))
        if self._library.pmjac_prune(ctypes.byref(self._loops), len(lower), *arrays):
            raise MemoryError("no memory for intervals")
        return Intervals(lower, upper), cut


def enclosed(library: ctypes.CDLL, tape: Tape, inputs: Intervals) -> Intervals:
    """Return what a program tells of intervals (inputs,)."""
    none = Intervals.exact(np.zeros(0))
    lanes = LoopsInLanes(library, tape, tape, none, np.zeros(0))
    return lanes.enclose(inputs[None])[:, 0]


def _program(tape: Tape) -> tuple[_Program, tuple[NDArray[Any], ...]]:
    """Return it as the kernel takes it, and the arrays that have to be kept."""
    code, constants = np.ascontiguousarray(tape.code), np.array(tape.constants, dtype=float)
    sizes = len(code), len(constants), tape.slots
    return _Program(address(code), address(constants), *sizes), (code, constants)
