"""What a sweep can say of each pose, by name."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.batch import Batch
from pmjac_pin.batches.results import ManyClosed, ManyJacobians, ManyMeasures, Status, Statuses
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.coordinates import entry_names
from pmjac_pin.values.arrays import Array, Index, Mask

_MEASURED = frozenset(ManyMeasures.__dataclass_fields__) - set(ManyJacobians.__dataclass_fields__)
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
        if not _MEASURED.isdisjoint(self._names):
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
        self, points: Sequence[int], labels: Mapping[str, Sequence[str]], *, not_done: bool = False
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


def labels_of(mechanism: Mechanism) -> dict[str, Sequence[str]]:
    """Return the labels of the axes that are not those of the points."""
    return {
        "row": _ROWS,
        "motor": mechanism.actuated,
        "entry": entry_names(mechanism.model),
        "radius": ("1", "2", "3"),
        "xyz": ("x", "y", "z"),
        "tool_axis": ("x", "y", "z"),
    }


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
        "velocity_radii": _measure("velocity_radii", "radius"),
        "angular_radii": _measure("angular_radii", "radius"),
        "smallest": _measure("smallest"),
        "condition": _measure("condition"),
        "position": _measure("position", "xyz"),
        "rotation": _measure("rotation", "xyz", "tool_axis"),
    }
)
