"""What is found of many poses: arrays, and a status each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import InitVar, dataclass, field, fields
from enum import IntEnum
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.filled_again import Refillable
from pmjac_pin.errors import ArgumentError
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.limits import beyond_limits
from pmjac_pin.values.arrays import Array, Index, Mask, read_only

Statuses: TypeAlias = NDArray[np.int8]


class Status(IntEnum):
    """What became of one pose among many."""

    CLOSED = 0
    STOPPED = 1
    LIMITS = 2
    OPEN = 3
    SINGULAR = 4
    NO_JACOBIAN = 5
    NOT_ASSEMBLED = 6
    NOT_DONE = 7
    INVALID = 8


CLOSED = int(Status.CLOSED)  #: NumPy asks a Status itself for its number, each time


@dataclass(frozen=True, eq=False)
class ManyClosed(Refillable):
    """Closed poses, or where their paths ended.

    Attributes
    ----------
    q : ndarray, shape (N, nq)
        Pinocchio's configuration vectors. Where a path ended early, its last closed pose.
    share : ndarray, shape (N,)
        Of the way from the guess to the target; 1 where it was reached.
    status : ndarray of int, shape (N,)
        `Status`: CLOSED; STOPPED where `close` raises ClosureError; LIMITS where it raises
        LimitError; OPEN where its loops are open at the guess, and INVALID where motor values or
        the guess are no finite numbers, or a turn of it is not of unit length: q and share are NaN
        then; NOT_DONE where somebody interrupted (`Interrupted`).
    """

    q: Array
    share: Array
    status: Statuses
    coordinates: InitVar[JointCoordinates | None] = field(default=None, kw_only=True)

    def __post_init__(self, coordinates: JointCoordinates | None = None) -> None:  # noqa: RUF033
        super().__post_init__()
        self.__dict__["_coordinates"] = coordinates

    @property
    def beyond_limits(self) -> Mask:
        """Where a joint is beyond its limits, motors or others, shape (N,); False with no pose.

        What `Configuration.limits_violated` names. With ``enforce_limits="all"`` no pose is both
        CLOSED and beyond.
        """
        return read_only(beyond_limits(self._known_coordinates, self.q))

    def joint(self, name: str) -> Array:
        """Return a joint's values by its name: one a pose, or its degrees of freedom, m or rad.

        Raises
        ------
        UnknownNameError, ArgumentError
            No such joint.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> poses = pj.batch(pj.load("four_bar")).close([[0.9], [1.0]])
        >>> poses.joint("phi1").round(3).tolist()
        [2.024, 2.025]
        """
        columns = self._known_coordinates.columns([name])
        values = self._known_coordinates.values_of(self.q, columns)
        return read_only(values[..., 0] if columns.size == 1 else values)

    def part(self, which: Index) -> Self:
        """Return some of the poses, by their numbers."""
        arrays = {one.name: getattr(self, one.name)[which] for one in fields(self)}
        return type(self)(**arrays, coordinates=self.__dict__["_coordinates"])

    @property
    def _known_coordinates(self) -> JointCoordinates:
        coordinates: JointCoordinates | None = self.__dict__["_coordinates"]
        if coordinates is None:
            raise ArgumentError(
                "joints and their limits are known to the poses that `pmjac_pin.batch` closes"
            )
        return coordinates


@dataclass(frozen=True, eq=False)
class ManyInGrid(ManyClosed):
    """Closed poses of a grid of motor values.

    Attributes
    ----------
    q, share, status, beyond_limits : ndarray, shapes (*grid, nq), and (*grid,) of the others
        As of `ManyClosed`, of the path that reached a cell or was the last to be tried.
    actuated : ndarray, shape (*grid, n)
        The motor values of each cell.
    source : ndarray of int, shape (*grid,)
        The number of the cell from which that path came, row by row; −1 for the guess. A cell
        that the straight path from the guess does not reach may be reached around an obstacle.
    """

    actuated: Array
    source: Index


@dataclass(frozen=True, eq=False)
class ManyJacobians(Refillable):
    """J_eq of many poses.

    Attributes
    ----------
    J_eq : ndarray, shape (N, 6, n)
        J − J* K*⁻¹ K, linear rows first; NaN where there is none.
    status : ndarray of int, shape (N,)
        `Status`: CLOSED; OPEN where `configuration` raises ClosureError; SINGULAR where
        `jacobian` raises SingularError; NO_JACOBIAN where it raises another NoJacobianError;
        INVALID where q is no finite numbers, or a turn in it is not of unit length.
    """

    J_eq: Array
    status: Statuses

    def part(self, which: Index) -> Self:
        """Return those of some of the poses, by their numbers."""
        return type(self)(**{one.name: getattr(self, one.name)[which] for one in fields(self)})

    @property
    def Jv_eq(self) -> Array:
        """Linear rows of each J_eq, shape (N, 3, n): m/s per unit rate of a motor."""
        return self.J_eq[:, :3]

    @property
    def Jw_eq(self) -> Array:
        """Angular rows of each J_eq, shape (N, 3, n): rad/s per unit rate of a motor."""
        return self.J_eq[:, 3:]


@dataclass(frozen=True, eq=False)
class ManyEllipsoids(ManyJacobians):
    """J_eq of many poses, in LOCAL_WORLD_ALIGNED, and the radii of its ellipsoids.

    NaN where there is no J_eq.

    Attributes
    ----------
    velocity_radii : ndarray, shape (N, 3)
        Singular values of the linear rows of J_eq, descending: `velocity_ellipsoid().radii`.
    angular_radii : ndarray, shape (N, 3)
        Of the angular rows: `angular_ellipsoid().radii`.
    """

    velocity_radii: Array
    angular_radii: Array

    @property
    def velocity_rank(self) -> Array:
        """How many velocity radii are not zero, shape (N,): `velocity_ellipsoid().rank`."""
        return _ranks_of_radii(self.velocity_radii)

    @property
    def angular_rank(self) -> Array:
        """How many angular radii are not zero, shape (N,): `angular_ellipsoid().rank`."""
        return _ranks_of_radii(self.angular_radii)

    @property
    def velocity_volume(self) -> Array:
        """4/3 π r₁ r₂ r₃, (m/s)³, shape (N,): `velocity_ellipsoid().volume`, 0 where it is flat."""
        return _volumes_of_radii(self.velocity_radii)

    @property
    def angular_volume(self) -> Array:
        """As `velocity_volume`, (rad/s)³, shape (N,): `angular_ellipsoid().volume`."""
        return _volumes_of_radii(self.angular_radii)


@dataclass(frozen=True, eq=False)
class ManyMeasures(ManyEllipsoids):
    """What is asked of a map: J_eq, its singular values, how near K* is to singular, the tool.

    NaN where the loops are open; J_eq and the radii also where there is no J_eq.

    Attributes
    ----------
    smallest, condition : ndarray, shape (N,)
        Of K*, as those of `Singularity`.
    position, rotation : ndarray, shapes (N, 3) and (N, 3, 3)
        Of the tool, in the world: those of `tool_pose()`.
    """

    smallest: Array
    condition: Array
    position: Array
    rotation: Array


def _ranks_of_radii(radii: Array) -> Array:
    """Return numbers, since none is NaN: of no whole number it could be told that it is none."""
    return read_only(np.where(np.isnan(radii).any(axis=1), np.nan, (radii != 0.0).sum(axis=1)))


def _volumes_of_radii(radii: Array) -> Array:
    return read_only(4 / 3 * math.pi * radii.prod(axis=1))


def say_nothing(found: Sequence[NDArray[Any]], which: Any, status: Status | Statuses) -> None:
    """Say of some poses, in arrays of results, why nothing is known of them."""
    for array in found:
        array[which] = np.nan if array.dtype == np.float64 else status
