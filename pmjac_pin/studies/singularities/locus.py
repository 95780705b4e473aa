"""SingularityLocus: the curves of singular poses in a slice of motor space, as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.model.coordinates import entry_names
from pmjac_pin.studies.datasets import Dataset, dataset
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.singularities.singular_equations import Freed
from pmjac_pin.values.arrays import Array, ReadOnlyArrays

LocusMark = Literal["cusp", "crossing", "touching", "branch point", "isolated point"]


@dataclass(frozen=True, eq=False, repr=False)
class LocusCurve(ReadOnlyArrays):
    """A curve of singular poses.

    Attributes
    ----------
    kind : {"gain", "loss"}
        Gosselin and Angeles' type II, where passive joints come free with the motors locked, or
        type I, where the tool loses a motion.
    places : ndarray, shape (N, 2)
        In the plane, m or rad.
    q : ndarray, shape (N, nq)
        The poses.
    directions : ndarray, shape (N, 2)
        How `places` change along the curve, by arc length in joint space: zero at a cusp.
    is_closed : bool
        Whether the last point is the first.
    modes : tuple of int
        The assembly modes on which it lies, by their numbers in `SingularityLocus.modes`: of a gain
        the two that meet there; fewer where these have no cell of the grid.
    residual : float
        The largest of what vanishes at a singular pose, over all points: gaps of the loops and the
        motion that is not held, without dimension.
    complete : bool
        Whether it ends at the window's border or where it began, not where it could not be followed
        further.
    branches : int
        How many of its ends could not be followed further because they are branch points: more than
        one way leads on there.
    """

    kind: Freed
    places: Array
    q: Array
    directions: Array
    is_closed: bool
    modes: tuple[int, ...]
    residual: float
    complete: bool
    branches: int = 0

    def __repr__(self) -> str:
        on = " and ".join(map(str, self.modes)) or "none that is known"
        closed = ", closed" if self.is_closed else ""
        return f"LocusCurve({self.kind}, {len(self.places)} points{closed}, on modes {on})"


@dataclass(frozen=True, eq=False, repr=False)
class LocusPoint(ReadOnlyArrays):
    """A special point of a locus.

    Attributes
    ----------
    mark : {"cusp", "crossing", "touching", "branch point", "isolated point"}
        A cusp of a curve of gain; a place at which two different poses are singular, where curves
        cross or have one tangent; a pose through which two curves lead; one through which none
        does, or only one that stays at its place, on which the machine moves with the motors of the
        plane at rest.
    place : ndarray, shape (2,)
    q : ndarray, shape (nq,)
        The pose, at a crossing that of the first curve.
    curves : tuple of int
        On which it is, by their numbers in `SingularityLocus.curves`.
    kind : {"gain", "loss"}
        Of the first curve.
    """

    mark: LocusMark
    place: Array
    q: Array
    curves: tuple[int, ...]
    kind: Freed

    def __repr__(self) -> str:
        place = ", ".join(f"{value:.9g}" for value in self.place)
        return f"LocusPoint({self.mark} of {self.kind} at ({place}))"


@dataclass(frozen=True, eq=False, repr=False)
class SingularityLocus(ReadOnlyArrays):
    """The singular poses in a two-dimensional slice.

    Attributes
    ----------
    at : Configuration
        The pose through which the slice leads.
    plane : tuple of two str
        What varies.
    units : tuple of two str
        "m" or "rad".
    held : mapping of str to float
        The values of what does not.
    lower, upper : ndarray, shape (2,)
        The window.
    curves : tuple of LocusCurve
    points : tuple of LocusPoint
        Cusps, crossings, touching and branch points, isolated points.
    modes : tuple of Configuration
        The assembly modes that were met, one pose of each.
    evidence : Evidence
    """

    at: Configuration
    plane: tuple[str, str]
    units: tuple[str, str]
    held: Mapping[str, float]
    lower: Array
    upper: Array
    curves: tuple[LocusCurve, ...]
    points: tuple[LocusPoint, ...]
    modes: tuple[Configuration, ...]
    evidence: Evidence

    @property
    def residual(self) -> float:
        """How far the worst point of all curves is from closed and singular, dimensionless."""
        return max((curve.residual for curve in self.curves), default=0.0)

    def marked(self, mark: LocusMark) -> tuple[LocusPoint, ...]:
        """Return the special points of one sort."""
        return tuple(point for point in self.points if point.mark == mark)

    def distance(self, place: Array) -> float:
        """Return how far a place is from the nearest point of a curve, m or rad; inf without."""
        apart = [np.linalg.norm(curve.places - place, axis=1).min() for curve in self.curves]
        return float(min(apart, default=np.inf))

    def to_xarray(self) -> Dataset:
        """Return curves and special points as a dataset.

        Dimensions are "vertex" (points of all curves, one behind the other; `curve` has the number
        of its own), "entry" (of q), "axis" (of the plane) and "special".

        Raises
        ------
        MissingDependencyError
            xarray is not installed.
        """
        return _locus_dataset(self)

    def __repr__(self) -> str:
        name, (first, second) = self.at.mechanism.name, self.plane
        marks = {one.mark: len(self.marked(one.mark)) for one in self.points}
        special = "".join(f", {mark}: {count}" for mark, count in marks.items())
        return (
            f"SingularityLocus({name}, {first} and {second}, {len(self.curves)} curves on "
            f"{len(self.modes)} assembly modes{special})"
        )


def _locus_dataset(locus: SingularityLocus) -> Dataset:
    """Return curves and special points as a dataset; see `SingularityLocus.to_xarray`."""
    curves, points = locus.curves, locus.points
    nq = locus.at.mechanism.nq
    numbers = [np.full(len(curve.places), k) for k, curve in enumerate(curves)]
    variables: dict[str, Any] = {
        "place": (("vertex", "axis"), _rows_of_all([c.places for c in curves], 2)),
        "q": (("vertex", "entry"), _rows_of_all([c.q for c in curves], nq)),
        "curve": ("vertex", np.concatenate([np.zeros(0, dtype=int), *numbers])),
        "kind": ("curve_number", [curve.kind for curve in curves]),
        "closed": ("curve_number", [curve.is_closed for curve in curves]),
        "on_modes": ("curve_number", [" ".join(map(str, curve.modes)) for curve in curves]),
        "special_place": (("special", "axis"), _rows_of_all([p.place[None] for p in points], 2)),
        "special_q": (("special", "entry"), _rows_of_all([p.q[None] for p in points], nq)),
        "mark": ("special", [point.mark for point in points]),
    }
    coordinates = {
        "axis": list(locus.plane),
        "entry": list(entry_names(locus.at.mechanism.model)),
    }
    held = {f"held {name}": value for name, value in locus.held.items()}
    attributes = {"mechanism": locus.at.mechanism.name, "evidence": str(locus.evidence), **held}
    return dataset(variables, coordinates, attributes)


def _rows_of_all(parts: list[Any], width: int) -> Any:
    return np.concatenate([np.zeros((0, width)), *parts])
