"""What a sweep can say of each pose, by name."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.batch import Batch
from pmjac_pin.batches.results import ManyClosed, ManyJacobians, ManyMeasures, Status, Statuses
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.coordinates import entry_names
from pmjac_pin.studies.sweep.own_measures import OwnMeasure
from pmjac_pin.values.arrays import Array, Index, Mask

_UNMEASURED = frozenset({"status", "share", "q", "J_eq", "Jv_eq", "Jw_eq"})
#: Along an axis that is not one of the points.
AxisLabels: TypeAlias = Sequence[str] | range
_ROWS = ("vx", "vy", "vz", "wx", "wy", "wz")


class ClosedPoses(Protocol):
    """What says of closed poses what is asked for."""

    def jacobian(self, q: Array) -> ManyJacobians: ...  # noqa: D102
    def measures(self, q: Array) -> ManyMeasures: ...  # noqa: D102
    def part(self, which: Index) -> ClosedPoses:
        """Return what says that of some of the poses."""
        ...


class AlikePoses:
    """Poses of one machine."""

    def __init__(self, many: Batch) -> None:
        self._many = many

    def jacobian(self, q: Array) -> ManyJacobians:
        """Return J_eq."""
        return self._many.jacobian(q, threads=1)

    def measures(self, q: Array) -> ManyMeasures:
        """Return all measures."""
        return self._many.measures(q, threads=1)

    def part(self, which: Index) -> AlikePoses:
        """Return itself: all are of one machine."""
        return self


class SeenPoses:
    """Poses, and what is known where their loops are closed.

    Parameters
    ----------
    many : ClosedPoses
    poses : ManyClosed
    names : collection of str
        Of the variables that are asked for.
    """

    def __init__(self, many: ClosedPoses, poses: ManyClosed, names: Collection[str]) -> None:
        self._many, self.poses, self._names = many, poses, names

    @cached_property
    def _closed(self) -> Index:
        return np.flatnonzero(self.poses.status == Status.CLOSED)

    @cached_property
    def jacobians(self) -> ManyJacobians:
        """J_eq at the closed poses: with the measures, where some of these are asked for."""
        if not _UNMEASURED.issuperset(self._names):
            return self.measures
        return self._many.part(self._closed).jacobian(self.poses.q[self._closed])

    @cached_property
    def measures(self) -> ManyMeasures:
        """Measures of the closed poses."""
        return self._many.part(self._closed).measures(self.poses.q[self._closed])

    def status(self) -> Statuses:
        """Return what became of each pose: of its loops and, where these are closed, of J_eq."""
        found: Statuses = self.poses.status.copy()
        found[self._closed] = self.jacobians.status
        return found

    @cached_property
    def _with_jacobian(self) -> Index:
        return np.flatnonzero(self.status() == Status.CLOSED)

    def own(self, of: OwnMeasure) -> Array:
        """Return a caller's own measure: of the poses that have J_eq, and NaN elsewhere."""
        found = np.full((len(self.poses.q), *of.shape), np.nan)
        if self._with_jacobian.size:
            found[self._with_jacobian] = of.at(*self._for_callers)
        return found

    @cached_property
    def _for_callers(self) -> tuple[ManyClosed, ManyMeasures]:
        """The poses that have J_eq, and their measures."""
        poses, which = self.poses, self._with_jacobian
        if which.size == len(poses.q):
            return poses, self.measures
        return poses.part(which), self.measures.part(np.searchsorted(self._closed, which))

    def known(self) -> Mask:
        """Tell of which poses all is known that was asked for until now."""
        found: Mask = self.status() != Status.NOT_DONE
        return found

    def spread(self, values: Array) -> Array:
        """Return values of the closed poses for all, NaN where there are none."""
        found = np.full((len(self.poses.q), *values.shape[1:]), np.nan)
        found[self._closed] = values
        return found


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable of the dataset.

    Attributes
    ----------
    dims : tuple of str
        Behind those of the points.
    nothing, not_done : number
        What stands where there is no value, and where nothing was computed; they tell the type of
        the others.
    of : callable
        What computes it for many poses, shape (points, ...).
    """

    dims: tuple[str, ...]
    nothing: np.float64 | np.int8
    not_done: np.float64 | np.int8
    of: Callable[[SeenPoses], NDArray[Any]]

    def empty(
        self, points: Sequence[int], labels: Mapping[str, AxisLabels], *, not_done: bool = False
    ) -> NDArray[Any]:
        """Return an array without values.

        Parameters
        ----------
        points : sequence of int
            Its shape along the axes of the points.
        labels : mapping
            Those of the other axes.
        not_done : bool
            Whether nothing was computed yet.
        """
        filler = self.not_done if not_done else self.nothing
        shape = (*points, *(len(labels[dim]) for dim in self.dims))
        return np.full(shape, filler, dtype=filler.dtype)


def labels_of(mechanism: Mechanism) -> dict[str, AxisLabels]:
    """Return the labels of the axes that are not those of the points."""
    return {
        "row": _ROWS,
        "motor": mechanism.actuated,
        "entry": entry_names(mechanism.model),
        "radius": ("1", "2", "3"),
        "xyz": ("x", "y", "z"),
        "tool_axis": ("x", "y", "z"),
    }


def own_variable(measure: OwnMeasure) -> Variable:
    """Return the variable of a caller's own measure."""
    return _per_pose(lambda seen: seen.own(measure), *measure.dims)


def _per_pose(of: Callable[[SeenPoses], Array], *dims: str) -> Variable:
    return Variable(dims, np.float64(np.nan), np.float64(np.nan), of)


def _measure(name: str, *dims: str) -> Variable:
    return _per_pose(lambda seen: seen.spread(getattr(seen.measures, name)), *dims)


VARIABLES: Mapping[str, Variable] = MappingProxyType(
    {
        "status": Variable(
            (), np.int8(Status.NOT_ASSEMBLED), np.int8(Status.NOT_DONE), SeenPoses.status
        ),
        "share": _per_pose(lambda seen: seen.poses.share),
        "q": _per_pose(lambda seen: seen.poses.q, "entry"),
        "J_eq": _per_pose(lambda seen: seen.spread(seen.jacobians.J_eq), "row", "motor"),
        "Jv_eq": _per_pose(lambda seen: seen.spread(seen.jacobians.Jv_eq), "xyz", "motor"),
        "Jw_eq": _per_pose(lambda seen: seen.spread(seen.jacobians.Jw_eq), "xyz", "motor"),
        "velocity_radii": _measure("velocity_radii", "radius"),
        "velocity_rank": _measure("velocity_rank"),
        "velocity_volume": _measure("velocity_volume"),
        "angular_radii": _measure("angular_radii", "radius"),
        "angular_rank": _measure("angular_rank"),
        "angular_volume": _measure("angular_volume"),
        "smallest": _measure("smallest"),
        "condition": _measure("condition"),
        "position": _measure("position", "xyz"),
        "rotation": _measure("rotation", "xyz", "tool_axis"),
    }
)
