"""Points: which values of motors and parameters a sweep goes over, chunk by chunk."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from pmjac_pin.errors import ArgumentError
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.columns import named_axes, named_samples

Region: TypeAlias = tuple[slice, ...]

_MOST_POINTS = 10**10  # they take a day, and hundreds of GB
_MOST_AT_ONCE = 10**7  # of a chunk: so many are in memory, for each process
_MOST_CHUNKS = 10**7  # each is known by its place


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

    def __post_init__(self) -> None:
        if self.count > _MOST_POINTS:
            sizes = " × ".join(map(str, self.shape))
            most = f"at most {_MOST_POINTS:.0e} are swept"
            raise ArgumentError(f"{sizes} = {self.count:.3g} points are too many; {most}")

    @classmethod
    def grid(cls, over: object, units: Mapping[str, str]) -> Points:
        """Return all combinations of the values of some axes, which have these units."""
        return cls(tuple(values := named_axes(over, "over", units)), values)

    @classmethod
    def samples(cls, given: object, units: Mapping[str, str]) -> Points:
        """Return values that belong together, one of each name, which have these units."""
        values = named_samples(given, "samples", units)
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

    @property
    def count(self) -> int:
        """How many points there are."""
        return math.prod(self.shape)

    def chunk(self, most: int) -> tuple[int, ...]:
        """Return the shape of chunks of at most so many points, whole along the last axes."""
        if min(most, self.count) > _MOST_AT_ONCE:
            raise ArgumentError(f"a chunk has at most {_MOST_AT_ONCE:.0e} points, got {most}")
        chunk: list[int] = []
        for size in reversed(self.shape):
            chunk.append(max(1, min(size, most // math.prod(chunk))))
        chunk.reverse()
        parts = (-(-size // step) for size, step in zip(self.shape, chunk, strict=True))
        if (count := math.prod(parts)) > _MOST_CHUNKS:
            told = f"{count:.3g} chunks are too many; at most {_MOST_CHUNKS:.0e} are kept"
            raise ArgumentError(f"{told}: `chunk` has to be larger than {most}")
        return tuple(chunk)

    def regions(self, chunk: tuple[int, ...]) -> list[Region]:
        """Return where the chunks are, row by row."""
        parts = (
            [slice(start, min(start + step, size)) for start in range(0, size, step)]
            for size, step in zip(self.shape, chunk, strict=True)
        )
        return list(itertools.product(*parts))

    def different(self, names: Iterable[str]) -> int:
        """Return how many different values these names have together, or, of samples, at least."""
        counts = [np.unique(self.values[name]).size for name in names]
        return math.prod(counts) if self.is_grid else max(counts, default=1)

    def at(self, region: Region) -> dict[str, Array]:
        """Return the values in a region by names, one a point, row by row."""
        if not self.is_grid:
            return {name: column[region[0]] for name, column in self.values.items()}
        axes = [column[part] for column, part in zip(self.values.values(), region, strict=True)]
        meshed = np.meshgrid(*axes, indexing="ij")
        return {name: mesh.ravel() for name, mesh in zip(self.values, meshed, strict=True)}
