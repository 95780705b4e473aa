"""Runs a tape by the kernel where one was built with the package, else by NumPy."""

from __future__ import annotations

import ctypes
import hashlib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra import numpy_tape
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.values.arrays import Array

_FOLDER = Path(__file__).parent


def run(tape: Tape, inputs: Array) -> Array:
    """Return the outputs, shape (outputs, N), of inputs of shape (inputs, N).

    The kernel lets other threads run.
    """
    built = kernel()
    return numpy_tape.run(tape, inputs) if built is None else run_in(built, tape, inputs)


@cache
def kernel() -> ctypes.CDLL | None:
    """Return the kernel that was built from the source beside it, None where there is none."""
    return loaded(_FOLDER / "_tape_kernel.so", _FOLDER / "tape_kernel.c", _FOLDER / "lanes.h")


def loaded(built: Path, *sources: Path) -> ctypes.CDLL | None:
    """Return a kernel that was built from some sources, None where there is none."""
    try:
        text = b"".join(source.read_bytes() for source in sources)
        library, digest = ctypes.CDLL(str(built)), hashlib.sha256(text).hexdigest()
        library.pmjac_source.restype = ctypes.c_char_p
        return library if library.pmjac_source() == digest.encode() else None
    except (OSError, AttributeError):
        return None


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
        ctypes.c_int64(len(code)),
        address(tape.constants),
        ctypes.c_int64(len(tape.constants)),
        ctypes.c_int64(tape.slots),
        address(given),
        ctypes.c_int64(given.shape[1]),
        address(found),
    )
    if failed:
        raise MemoryError("no memory for the slots of a program")
    return found


def address(array: NDArray[Any]) -> ctypes.c_void_p:
    """Return where an array's numbers are."""
    return ctypes.c_void_p(array.ctypes.data)
