"""What the kernels that walk paths are given: structures as `walk.h` has them."""

from __future__ import annotations

import ctypes
import threading
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from pmjac_pin.algebra.c_kernels import COUNT, POINTER, address, loaded
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.closing.recorded_step import BOUNDS
from pmjac_pin.values.arrays import aligned

if TYPE_CHECKING:
    from pmjac_pin.algebra.compiled_programs import CompiledProgram

_SOURCES = (
    "closing/path_kernel.c",
    "closing/starts.h",
    "closing/walk.h",
    "algebra/tape_kernel.c",
    "algebra/lanes.h",
)

_TAKES = (POINTER, COUNT)
_Number = ctypes.c_double


@cache
def path_kernel() -> ctypes.PyDLL | None:
    """Return the kernel of one lane, None where none was built from the sources.

    Its calls take microseconds: other threads wait, instead of taking over in each of them.
    """
    library = loaded("closing/_path_kernel.so", *_SOURCES)
    if library is None:
        return None
    alone = ctypes.PyDLL(library._name, handle=library._handle)
    alone.pmjac_set_out.argtypes = alone.pmjac_walk.argtypes = _TAKES
    return alone


@cache
def many_paths_kernel() -> ctypes.CDLL | None:
    """Return the kernel of many lanes, None where none was built; it lets other threads run."""
    sources = ("closing/many_paths.c", *_SOURCES)
    return loaded("closing/_many_paths.so", *sources, pmjac_set_out=_TAKES, pmjac_walk=_TAKES)


class ProgramStruct(ctypes.Structure):
    """`Program`."""

    _fields_ = (
        ("code", POINTER),
        ("length", COUNT),
        ("stages", COUNT * BOUNDS),
        *((name, POINTER) for name in ("slots", "inputs", "outputs", "compiled")),
    )


class MachineStruct(ctypes.Structure):
    """`Machine`."""

    _fields_ = (
        *((name, COUNT) for name in ("nq", "nv", "motors")),
        *((name, POINTER) for name in ("motor_entries", "motor_circles", "scale")),
        *((name, _Number) for name in ("tolerance", "enough", "walking", "rank_tolerance")),
        *((name, _Number) for name in ("least_size", "largest_step", "smallest_step")),
        *((name, _Number) for name in ("largest_correction", "slowest_contraction")),
        *((name, _Number) for name in ("no_inverse", "margin", "arrival_tolerance")),
        ("most_corrections", COUNT),
    )


class LaneStruct(ctypes.Structure):
    """`Lane`."""

    _fields_ = (
        *((name, COUNT) for name in ("state", "path", "tries", "iterations", "corrections")),
        ("last", COUNT),
        *((name, _Number) for name in ("share", "next", "stride", "allowed", "before")),
        *((name, _Number) for name in ("size", "left")),
    )


class WalkStruct(ctypes.Structure):
    """`Walk`."""

    _fields_ = (
        ("machine", POINTER),
        *((name, ProgramStruct) for name in ("move", "arrival", "leg")),
        *((name, POINTER) for name in ("point", "lanes", "common", "learnt")),
        ("inverse", _Number),
        *((name, POINTER) for name in ("start", "displacement", "target", "ways", "design")),
        *(
            (name, COUNT)
            for name in ("designed", "apart", "count", "taken", "most_tries", "few", "patience")
        ),
        ("busy", COUNT),
        ("arrived", COUNT),
        *((name, POINTER) for name in ("q", "gap", "share", "iterations", "end")),
        *((name, POINTER) for name in ("follow", "given")),
    )


class Memory:
    """A tape with numbers to work on, of one thread.

    Parameters
    ----------
    tape : Tape
    lanes : int
        For how many sets of inputs at a time.
    compiled : CompiledProgram, optional
        What computes the same.

    Attributes
    ----------
    inputs, outputs : ndarray, shapes (k, lanes)
    struct : ProgramStruct
    """

    __slots__ = ("_kept", "inputs", "outputs", "struct")

    def __init__(self, tape: Tape, lanes: int = 1, compiled: CompiledProgram | None = None) -> None:
        code = np.ascontiguousarray(tape.code, dtype=np.int32)
        slots = aligned(tape.slots + 1 if compiled is None else compiled.kept + 1, lanes)
        if compiled is None:
            slots[: len(tape.constants)] = tape.constants[:, None]
        self.inputs, self.outputs = aligned(tape.inputs, lanes), aligned(tape.outputs, lanes)
        self._kept = (code, slots, compiled)
        self.struct = ProgramStruct(
            address(code),
            len(code),
            tape.stages or (len(code),),
            *map(address, (slots, self.inputs, self.outputs)),
            compiled and compiled.stage,
        )


class ThreadMemory(threading.local):
    """Each thread's own `Memory` of a tape.

    Attributes
    ----------
    numbers : (ndarray, ndarray, object)
        Inputs and outputs, shapes (k,), and what `pmjac_run_once` takes.
    """

    def __init__(self, tape: Tape) -> None:
        self._kept = memory = Memory(tape)
        self.numbers = memory.inputs[:, 0], memory.outputs[:, 0], ctypes.byref(memory.struct)
