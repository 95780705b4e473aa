"""Shapes of results of many poses, and arrays of these shapes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.memory_left import LARGE, in_memory_left

_OF_ONE_POSE: dict[str, tuple[int, ...]] = {  # -1: one for each motor, -2: for each entry of q
    "q": (-2,), "share": (), "J_eq": (6, -1), "status": (),
    "velocity_radii": (3,), "angular_radii": (3,),
    "smallest": (), "condition": (), "position": (3,), "rotation": (3, 3),
}  # fmt: skip


class ResultShapes(dict[str, tuple[int, ...]]):
    """The shapes of arrays of results, by their names.

    Attributes
    ----------
    numbers : int
        How many they hold.
    kinds : list of (str, tuple of int, dtype)
        Statuses, and numbers.
    status : int
        The place of the statuses among them.
    """

    def __init__(self, shapes: Mapping[str, tuple[int, ...]]) -> None:
        super().__init__(shapes)
        self.numbers = sum(map(math.prod, shapes.values()))
        self.status = list(shapes).index("status") if "status" in shapes else -1
        self.kinds = [
            (name, shape, np.dtype(np.int8 if name == "status" else np.float64))
            for name, shape in shapes.items()
        ]


@lru_cache(maxsize=64)
def shapes_of(kind: type, count: int, motors: int, nq: int = 0) -> ResultShapes:
    """Return the shapes of what is found at so many poses: of the arrays of a kind of results."""
    names, sizes = {one.name for one in fields(kind)}, {-1: motors, -2: nq}
    return ResultShapes(
        {
            name: (count, *(sizes.get(size, size) for size in shape))
            for name, shape in _OF_ONE_POSE.items()
            if name in names
        }
    )


def empty_arrays(shapes: ResultShapes) -> dict[str, NDArray[Any]]:
    """Return arrays of results that are to be filled."""
    empty = np.empty if 8 * shapes.numbers < LARGE else in_memory_left
    return {name: empty(shape, kind) for name, shape, kind in shapes.kinds}
