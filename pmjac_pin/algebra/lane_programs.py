"""Programs as the kernels run them in lanes, with numbers to work on: `lane_programs.h`."""

from __future__ import annotations

import ctypes
import threading
from typing import TYPE_CHECKING

import numpy as np

from pmjac_pin.algebra.c_kernels import COUNT, POINTER, address
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.values.arrays import aligned

if TYPE_CHECKING:
    from pmjac_pin.algebra.compiled_programs import CompiledProgram

#: What kernels that run programs include.
PROGRAM_SOURCES = ("algebra/lane_programs.h", "algebra/tape_kernel.c", "algebra/lanes.h")

_MOST_STAGES = 3


class ProgramStruct(ctypes.Structure):
    """`Program`."""

    _fields_ = (
        ("code", POINTER),
        ("length", COUNT),
        ("stages", COUNT * _MOST_STAGES),
        *((name, POINTER) for name in ("slots", "inputs", "outputs", "compiled")),
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
