"""Runs a tape by the kernel where one was built with the package, else by NumPy."""

from __future__ import annotations

import ctypes
from functools import cache

import numpy as np

from pmjac_pin.algebra import numpy_tape
from pmjac_pin.algebra.c_kernels import COUNT, POINTER, address, loaded
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.values.arrays import Array

#: What `pmjac_run_tape` is given.
TAPE_TAKES = (POINTER, COUNT, POINTER, COUNT, COUNT, POINTER, COUNT, POINTER)


def run(tape: Tape, inputs: Array) -> Array:
    """Return the outputs, shape (outputs, N), of inputs of shape (inputs, N).

    The kernel lets other threads run.
    """
    built = tape_kernel()
    return numpy_tape.run(tape, inputs) if built is None else run_in(built, tape, inputs)


@cache
def tape_kernel() -> ctypes.CDLL | None:
    """Return the kernel that was built from the source beside it, None where there is none."""
    sources = ("algebra/tape_kernel.c", "algebra/lanes.h")
    return loaded("algebra/_tape_kernel.so", *sources, pmjac_run_tape=TAPE_TAKES)


def run_in(library: ctypes.CDLL, tape: Tape, inputs: Array) -> Array:
    """Return what the kernel makes of inputs.

    Raises
    ------
    MemoryError
    """
    given = np.ascontiguousarray(inputs, dtype=float)
    code = np.ascontiguousarray(tape.code)
    found = np.empty((tape.outputs, given.shape[1]))
    failed = library.pmjac_run_tape(
        address(code),
        len(code),
        address(tape.constants),
        len(tape.constants),
        tape.slots,
        address(given),
        given.shape[1],
        address(found),
    )
    if failed:
        raise MemoryError("no memory for the slots of a program")
    return found
