"""What the kernel for one pose at a time is given: structures as `path_kernel.c` has them."""

from __future__ import annotations

import ctypes
import threading
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from pmjac_pin.algebra import tape_runner
from pmjac_pin.algebra.tape import Tape

_FOLDER = Path(__file__).parent
_ALGEBRA = _FOLDER.parent / "algebra"
_SOURCES = (_FOLDER / "path_kernel.c", _ALGEBRA / "tape_kernel.c", _ALGEBRA / "lanes.h")

_Number, _Count = ctypes.c_double, ctypes.c_int64
_Pointer = ctypes.c_void_p


@cache
def path_kernel() -> ctypes.PyDLL | None:
    """Return the kernel that was built from the sources, None where there is none.

    Its calls take microseconds: other threads wait, instead of taking over in each of them.
    """
    library = tape_runner.loaded(_FOLDER / "_path_kernel.so", *_SOURCES)
    return None if library is None else ctypes.PyDLL(library._name, handle=library._handle)


class ProgramStruct(ctypes.Structure):
    """`Program`."""

    _fields_ = (
        ("code", _Pointer),
        ("length", _Count),
        ("slots", _Pointer),
        ("inputs", _Pointer),
        ("outputs", _Pointer),
    )


class MachineStruct(ctypes.Structure):
    """`Machine`."""

    _fields_ = (
        *((name, _Count) for name in ("nq", "nv", "motors")),
        *((name, _Pointer) for name in ("motor_entries", "motor_circles")),
        *((name, _Number) for name in ("tolerance", "enough", "walking", "rank_tolerance")),
        *((name, _Number) for name in ("least_size", "largest_step", "smallest_step")),
        *((name, _Number) for name in ("largest_correction", "slowest_contraction")),
        *((name, _Number) for name in ("no_inverse", "margin")),
        ("most_corrections", _Count),
    )


class PathStruct(ctypes.Structure):
    """`Path`."""

    _fields_ = (
        ("machine", _Pointer),
        *((name, ProgramStruct) for name in ("move", "arrival", "leg")),
        *((name, _Pointer) for name in ("point", "displacement", "target")),
        ("share", _Number),
        ("next", _Number),
        ("iterations", _Count),
        ("tries", _Count),
    )


class Memory:
    """A tape with numbers to work on, of one thread.

    Attributes
    ----------
    inputs, outputs : ndarray
    struct : ProgramStruct
    """

    __slots__ = ("_kept", "inputs", "outputs", "struct")

    def __init__(self, tape: Tape) -> None:
        code = np.ascontiguousarray(tape.code, dtype=np.int32)
        slots = np.zeros(tape.slots + 1)
        slots[: len(tape.constants)] = tape.constants
        self.inputs, self.outputs = np.zeros(tape.inputs), np.zeros(tape.outputs)
        self._kept = (code, slots)
        self.struct = ProgramStruct(
            address(code), len(code), address(slots), address(self.inputs), address(self.outputs)
        )


class ThreadMemory(threading.local):
    """Each thread's own `Memory` of a tape, and what `pmjac_run_once` takes.

    Attributes
    ----------
    memory : Memory
    argument : object
        The address of its struct.
    """

    def __init__(self, tape: Tape) -> None:
        self.memory = Memory(tape)
        self.argument = ctypes.byref(self.memory.struct)


def address(array: Any) -> int:
    """Return where an array's numbers are."""
    return int(array.ctypes.data)
