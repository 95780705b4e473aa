"""Shapes of results of many poses, and arrays of these shapes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.memory_left import LARGE, in_memory_left

_OF_ONE_POSE: dict[str, tuple[int, ...]] = {  # -1: one for each motor
    "J_eq": (6, -1), "status": (), "velocity_radii": (3,), "angular_radii": (3,),
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
def shapes_of(kind: type, count: int, motors: int) -> ResultShapes:
    """Return the shapes of what is found at so many poses: of the arrays of a kind of results."""
    names = {one.name for one in fields(kind)}
    return ResultShapes(
        {
            name: (count, *(motors if size < 0 else size for size in shape))
            for name, shape in _OF_ONE_POSE.items()
            if name in names
        }
    )


@lru_cache(maxsize=64)
def shapes_of_closed(count: int, nq: int) -> ResultShapes:
    """Return the shapes of the arrays of so many paths."""
    return ResultShapes({"q": (count, nq), "share": (count,), "status": (count,)})


def maker_of(shapes: ResultShapes) -> Callable[[tuple[int, ...], np.dtype[Any]], NDArray[Any]]:
    """Return what makes one of such arrays."""
    return np.empty if 8 * shapes.numbers < LARGE else in_memory_left


def empty_arrays(shapes: ResultShapes) -> dict[str, NDArray[Any]]:
    """Return arrays of results that are to be filled."""
    empty = maker_of(shapes)
    return {name: empty(shape, kind) for name, shape, kind in shapes.kinds}
