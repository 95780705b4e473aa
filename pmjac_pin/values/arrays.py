"""Arrays: by what they hold, their norm, and such as cannot be written to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Self, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Complex: TypeAlias = NDArray[np.complex128]
Index: TypeAlias = NDArray[np.intp]
Mask: TypeAlias = NDArray[np.bool_]
AnyArray = TypeVar("AnyArray", bound=NDArray[Any])

_ALIGNMENT = 64  # bytes, of the longest vectors


def norm(array: Array) -> float:
    """Return the Frobenius norm: NumPy's own costs three times as much on small arrays."""
    flat = array.ravel()
    return math.sqrt(flat.dot(flat))


@dataclass(frozen=True, eq=False)
class ReadOnlyArrays:
    """Base of frozen dataclasses: their arrays are read-only, a caller's writable ones copied.

    Through pickling as well, where NumPy forgets it.
    """

    @classmethod
    def of_sealed(cls, arrays: dict[str, Any]) -> Self:
        """Return what holds arrays, all of its own by their names, that nobody can write to."""
        made = object.__new__(cls)
        object.__setattr__(made, "__dict__", arrays)
        return made

    def __post_init__(self) -> None:
        for name, value in self.__dict__.items():
            if isinstance(value, np.ndarray) and value.flags.writeable:
                self.__dict__[name] = read_only(value)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        ReadOnlyArrays.__post_init__(self)


def read_only(array: AnyArray) -> AnyArray:
    """Return a copy that stays read-only: over bytes, ``setflags(write=True)`` is refused."""
    return np.ndarray(array.shape, array.dtype, array.tobytes())  # type: ignore[return-value]


def sealed(array: AnyArray) -> AnyArray:
    """Return an array that stays read-only, without a copy: for what nobody else holds."""
    return np.asarray(array.data.toreadonly())  # type: ignore[return-value]


def aligned(count: int, width: int) -> Array:
    """Return zeros (count, width) that lie where vector instructions load them from."""
    memory = np.zeros(8 * count * width + _ALIGNMENT, dtype=np.uint8)
    start = -memory.ctypes.data % _ALIGNMENT
    found: Array = memory[start : start + 8 * count * width].view(float).reshape(count, width)
    return found
