"""Points: which values of motors and parameters a sweep goes over, chunk by chunk."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_numbers

Region: TypeAlias = tuple[slice, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Values by names, as the axes of a grid or as samples.

    Attributes
    ----------
    dims : tuple of str
        The names of the axes, or "sample" alone.
    values : mapping of str to ndarray, shape (k,)
        Those of an axis, or of all samples.
    """

    dims: tuple[str, ...]
    values: Mapping[str, Array]

    @classmethod
    def grid(cls, over: object) -> Points:
        """Return all combinations of the values of some axes."""
        return cls(tuple(values := _columns(over, "over")), values)

    @classmethod
    def samples(cls, given: object) -> Points:
        """Return values that belong together, one of each name."""
        values = _columns(given, "samples")
        sizes = {name: column.size for name, column in values.items()}
        if len(set(sizes.values())) > 1:
            counts = ", ".join(f"{count} of {name!r}" for name, count in sizes.items())
            raise ArgumentError(f"`samples` has as many values of each name, got {counts}")
        return cls(("sample",), values)

    @property
    def is_grid(self) -> bool:
        """Whether the names are axes."""
        return self.dims == tuple(self.values)

    @property
    def shape(self) -> tuple[int, ...]:
        """How many points there are along each axis."""
        sizes = tuple(column.size for column in self.values.values())
        return sizes if self.is_grid else sizes[:1]

    def chunk(self, most: int) -> tuple[int, ...]:
        """Return the shape of chunks of at most so many points, whole along the last axes."""
        chunk: list[int] = []
        for size in reversed(self.shape):
            chunk.append(max(1, min(size, most // math.prod(chunk))))
        return tuple(reversed(chunk))

    def regions(self, chunk: tuple[int, ...]) -> list[Region]:
        """Return where the chunks are, row by row."""
        parts = (
            [slice(start, min(start + step, size)) for start in range(0, size, step)]
            for size, step in zip(self.shape, chunk, strict=True)
        )
        return list(itertools.product(*parts))

    def at(self, region: Region) -> dict[str, Array]:
        """Return the values in a region by names, one a point, row by row."""
        if not self.is_grid:
            return {name: column[region[0]] for name, column in self.values.items()}
        axes = [column[part] for column, part in zip(self.values.values(), region, strict=True)]
        meshed = np.meshgrid(*axes, indexing="ij")
        return {name: mesh.ravel() for name, mesh in zip(self.values, meshed, strict=True)}


def _columns(given: object, what: str) -> dict[str, Array]:
    if not isinstance(given, Mapping) or not given:
        raise ArgumentError(f"`{what}` is a mapping of names to values, got {quoted(given)}")
    columns = {}
    for name, values in given.items():
        # Plain lists, NumPy's arrays, and such with labels of their own, as xarray's.
        column = as_numbers(getattr(values, "values", values), f"`{what}`: the values of {name!r}")
        if not isinstance(name, str) or column.ndim != 1 or not column.size:
            wanted = f"`{what}`: a list of values for {quoted(name)} expected"
            raise ArgumentError(f"{wanted}, got shape {column.shape}")
        columns[name] = column
    return columns
