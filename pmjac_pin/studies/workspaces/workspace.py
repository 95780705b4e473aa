"""Workspace: the region of a slice that a mechanism reaches, as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.model.coordinates import entry_names
from pmjac_pin.studies.datasets import Dataset, dataset
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.values.arrays import Array, Mask, ReadOnlyArrays


@dataclass(frozen=True, eq=False)
class BorderPiece(ReadOnlyArrays):
    """A smooth piece of a workspace's border, what is reached on its left.

    Attributes
    ----------
    places : ndarray, shape (N, 2)
        m or rad.
    reason : str
        What keeps the machine within: "gain", "loss", "window", or a joint and its limit.
    """

    places: Array
    reason: str


@dataclass(frozen=True, eq=False, repr=False)
class Workspace(ReadOnlyArrays):
    """What a mechanism reaches in a two-dimensional slice.

    Attributes
    ----------
    at : Configuration
        The pose through which the slice leads, and whose mode was followed.
    plane, units : tuple of two str
    held : mapping of str to float
        The values of what does not vary.
    mode : str
        Which assembly and working mode this is.
    first, second : ndarray, shapes (a,) and (b,)
        The grid's axes, m or rad.
    reached : ndarray of bool, shape (a, b)
    q : ndarray, shape (a, b, nq)
        A pose at each cell that is reached, NaN elsewhere.
    measure : str
        By what the map is coloured; empty where nothing was asked for.
    values : ndarray, shape (a, b)
        NaN where nothing is reached.
    border : tuple of BorderPiece
    area : float
        That the border encloses, m², rad² or m rad; NaN where it does not close.
    evidence : Evidence
    """

    at: Configuration
    plane: tuple[str, str]
    units: tuple[str, str]
    held: Mapping[str, float]
    mode: str
    first: Array
    second: Array
    reached: Mask
    q: Array
    measure: str
    values: Array
    border: tuple[BorderPiece, ...]
    area: float
    evidence: Evidence

    @property
    def cell_area(self) -> float:
        """That of the cells that are reached: an estimate of `area` by counting."""
        steps = [float(axis[1] - axis[0]) for axis in (self.first, self.second)]
        return float(self.reached.sum()) * steps[0] * steps[1]

    def to_xarray(self) -> Dataset:
        """Return the grid as a dataset: `reached`, `q` and the measure over the plane.

        Raises
        ------
        MissingDependencyError
            xarray is not installed.
        """
        variables: dict[str, Any] = {
            "reached": (self.plane, self.reached),
            "q": ((*self.plane, "entry"), self.q),
        }
        if self.measure:
            variables[self.measure] = (self.plane, self.values)
        coordinates = {
            self.plane[0]: self.first,
            self.plane[1]: self.second,
            "entry": list(entry_names(self.at.mechanism.model)),
        }
        attributes = {
            "mechanism": self.at.mechanism.name,
            "mode": self.mode,
            "area": self.area,
            "evidence": str(self.evidence),
            **{f"held {name}": value for name, value in self.held.items()},
        }
        return dataset(variables, coordinates, attributes)

    def __repr__(self) -> str:
        area = f"area {self.area:.6g}" if np.isfinite(self.area) else "border not closed"
        return (
            f"Workspace({self.at.mechanism.name}, {self.plane[0]} and {self.plane[1]}, "
            f"{self.mode}, {int(self.reached.sum())} of {self.reached.size} cells, {area})"
        )
