"""Values whose arrays stay read-only, through pickling as well, where NumPy forgets it."""

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
                self.__dict__[name] = read_only(value.copy())

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        ReadOnlyArrays.__post_init__(self)


def read_only(array: AnyArray) -> AnyArray:
    """Make an array of our own read-only and return it."""
    array.setflags(write=False)
    return array
