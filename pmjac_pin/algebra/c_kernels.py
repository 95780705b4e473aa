"""Kernels in C, as they are built with the package: loaded where they are of the sources beside."""

from __future__ import annotations

import ctypes
import hashlib
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

_PMJAC_PIN = Path(__file__).parents[1]
POINTER, COUNT, NUMBER = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
_OF_OTHER_SOURCES = (
    "was built from other sources than those beside it and is left aside: NumPy does its work, "
    "slower, until pmjac_pin is installed again"
)
_address_of, _first_byte = ctypes.addressof, ctypes.c_char.from_buffer


def loaded(
    built: str | Path, *sources: str | Path, **arguments: Sequence[Any]
) -> ctypes.CDLL | None:
    """Return a kernel that was built from some sources, None where there is none.

    One that was built from others is not loaded, with a warning: sources of an editable
    installation have changed.

    Parameters
    ----------
    built, *sources : str or Path
        Where they are, seen from the package's folder.
    **arguments : sequence of types
        What its functions take, by their names.
    """
    try:
        text = b"".join((_PMJAC_PIN / source).read_bytes() for source in sources)
        library, digest = ctypes.CDLL(str(_PMJAC_PIN / built)), hashlib.sha256(text).hexdigest()
        library.pmjac_source.restype = ctypes.c_char_p
        if library.pmjac_source() != digest.encode():
            warnings.warn(f"{built} {_OF_OTHER_SOURCES}", RuntimeWarning, stacklevel=2)
            return None
    except (OSError, AttributeError):
        return None
    for function, types in arguments.items():
        getattr(library, function).argtypes = types
    return library


def address(array: NDArray[Any]) -> int:
    """Return where an array's numbers are, for arguments that are said to be `POINTER`."""
    try:  # some times faster, where an array can be written to and is not empty
        return _address_of(_first_byte(array))  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return array.ctypes.data
