"""Values whose arrays cannot be written to, through pickling as well, where NumPy forgets it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

AnyArray = TypeVar("AnyArray", bound=NDArray[Any])


@dataclass(frozen=True, eq=False)
class ReadOnlyArrays:
    """Base of frozen dataclasses: their arrays are read-only, a caller's writable ones copied."""

    def __post_init__(self) -> None:
        for name, value in self.__dict__.items():
            if isinstance(value, np.ndarray) and value.flags.writeable:
                self.__dict__[name] = read_only(value)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        ReadOnlyArrays.__post_init__(self)


def read_only(array: AnyArray) -> AnyArray:
    """Return a copy that stays read-only: over bytes, ``setflags(write=True)`` is refused."""
    if not array.size:
        array = array.copy()
        array.setflags(write=False)
        return array
    return np.frombuffer(array.tobytes(), array.dtype).reshape(array.shape)  # type: ignore[return-value]
