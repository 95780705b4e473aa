"""Damped least squares of many starts by the kernel, as `descend` does them without one."""

from __future__ import annotations

import ctypes
from functools import cache

import numpy as np

from pmjac_pin.algebra.c_kernels import COUNT, NUMBER, POINTER, address, loaded
from pmjac_pin.algebra.lane_programs import PROGRAM_SOURCES, Memory, ProgramStruct
from pmjac_pin.closing.levenberg_marquardt import Descended, Patience
from pmjac_pin.studies.modes.recorded_descent import RecordedDescent
from pmjac_pin.values.arrays import Array

_ROUNDS_OF_A_CALL = 64  # a step of each lane: some milliseconds, in which nothing can interrupt
_LANE_NUMBERS = 8  # of 8 bytes
_CLOSED, _SPENT = 1, 2  # ends, as `descent_kernel.c` numbers them


@cache
def descent_kernel() -> ctypes.CDLL | None:
    """Return the kernel, None where none was built; it lets other threads run."""
    folder = "studies/modes"
    sources = (f"{folder}/descent_kernel.c", *PROGRAM_SOURCES)
    return loaded(f"{folder}/_descent_kernel.so", *sources, pmjac_descend=(POINTER, COUNT))


class DescentsInLanes:
    """Descends from starts, many at a time.

    Parameters
    ----------
    library : ctypes.CDLL
        The kernel.
    programs : RecordedDescent
    stride : float
        Damping is multiplied by the gap in such strides, m.
    """

    def __init__(self, library: ctypes.CDLL, programs: RecordedDescent, stride: float) -> None:
        self._library, self._programs, self._stride = library, programs, stride

    def descend(self, starts: Array, patience: Patience) -> Descended:
        """Return where starts (b, nq) lead to, in their order."""
        count, programs = len(starts), self._programs
        starts = np.ascontiguousarray(starts)
        q, gap = np.empty(starts.shape), np.empty(count)
        iterations, end = np.empty((2, count), dtype=np.int64)
        lanes = np.zeros((int(self._library.pmjac_lanes()), _LANE_NUMBERS), dtype=np.int64)
        pose, step = (Memory(tape, len(lanes)) for tape in (programs.pose, programs.step))
        pose.struct.inputs = step.struct.outputs  # where a step leads is where the next pose is
        descent = _DescentStruct(
            pose.struct,
            step.struct,
            *map(address, (lanes, starts, q, gap, iterations, end)),
            nq=programs.nq,
            known=programs.pose.outputs - 1,
            unknowns=programs.unknowns,
            count=count,
            fading=1.0 / self._stride,
            **{name: getattr(patience, name) for name in patience.__slots__},
        )
        while self._library.pmjac_descend(ctypes.byref(descent), _ROUNDS_OF_A_CALL):
            pass
        return Descended(q, gap, iterations, end == _CLOSED, end == _SPENT)


class _DescentStruct(ctypes.Structure):
    """`Descent`."""

    _fields_ = (
        ("pose", ProgramStruct),
        ("step", ProgramStruct),
        *((name, POINTER) for name in ("lanes", "starts", "q", "gap", "iterations", "end")),
        *((name, COUNT) for name in ("nq", "known", "unknowns", "count", "taken", "busy")),
        *((name, COUNT) for name in ("steps", "creeping_steps")),
        *((name, NUMBER) for name in ("enough", "tolerance", "damping", "least", "most")),
        *((name, NUMBER) for name in ("shrinks", "grows", "grows_within", "falling", "creeping")),
        ("fading", NUMBER),
    )
