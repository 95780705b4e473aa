"""Bodies: where everything is at one q, and how fast its points move. Pinocchio is called here."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from pmjac_pin.values.arrays import Array, Index

_SAME_LINE = 1e-9  # the sine of an angle, or a pitch in m/rad: less is rounding


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """A point fixed to a body: Pinocchio's index of its joint and the place in that joint."""

    body: int
    place: Array


@dataclass(frozen=True, slots=True, eq=False)
class PointsOfBodies:
    """Points of bodies, stacked: bodies (k,) and places (k, 3)."""

    bodies: Index
    places: Array

    @classmethod
    def of(cls, points: Sequence[Point]) -> PointsOfBodies:
        """Stack points."""
        places = np.array([point.place for point in points], dtype=np.float64).reshape(-1, 3)
        return cls(np.array([point.body for point in points], dtype=np.intp), places)

    def at(self, placements: Array) -> Array:
        """Return the points in the world, shape (k, 3), for placements of shape (bodies, 4, 4)."""
        chosen = placements[self.bodies]
        turned: Array = (chosen[:, :3, :3] @ self.places[:, :, None])[:, :, 0]
        return turned + chosen[:, :3, 3]


class AxisInBodies(NamedTuple):
    """The constant axis of a joint.

    Attributes
    ----------
    direction : ndarray, shape (3,)
        In the joint's own frame.
    turns, slides : bool
        What it does about it and along it: a screw both.
    """

    direction: Array
    turns: bool
    slides: bool


class Bodies:
    """Placements and velocities of the bodies of a model; may be shared between threads.

    Parameters
    ----------
    model : pin.Model
        Kept, not copied: it must not be changed afterwards.

    Attributes
    ----------
    axes : mapping of int to Axis
        For each joint that moves along and about one axis only.
    """

    __slots__ = ("_data", "_lock", "axes", "model")

    def __init__(self, model: pin.Model) -> None:
        self.model = model
        self._data = model.createData()
        self._lock = threading.Lock()
        self.axes: Mapping[int, AxisInBodies] = _joint_axes(model, self._data)

    def placements(self, q: Array) -> Array:
        """Return oMi of all joints, the universe first, shape (njoints, 4, 4)."""
        with self._lock:
            pin.forwardKinematics(self.model, self._data, q)
            return np.array([placement.homogeneous for placement in self._data.oMi])

    def velocities(self, q: Array, v: Array, points: PointsOfBodies) -> Array:
        """Return the velocities of points in world axes, shape (k, 3)."""
        with self._lock:
            pin.forwardKinematics(self.model, self._data, q, v)
            rotations = np.array([placement.rotation for placement in self._data.oMi])
            motions = np.array([motion.vector for motion in self._data.v])
        motions, rotations = motions[points.bodies], rotations[points.bodies]
        local = motions[:, :3] + np.cross(motions[:, 3:], points.places)
        moved: Array = (rotations @ local[:, :, None])[:, :, 0]
        return moved


def _joint_axes(model: pin.Model, data: pin.Data) -> dict[int, AxisInBodies]:
    motions = pin.computeJointJacobians(model, data, pin.neutral(model)).reshape(6, -1)
    found = {}
    for index, joint in list(enumerate(model.joints))[1:]:
        own = slice(joint.idx_v, joint.idx_v + joint.nv)
        linear, angular = np.split(data.oMi[index].actionInverse @ motions[:, own], 2)
        ways = np.where(angular.any(axis=0), angular, linear)
        ways = ways / np.linalg.norm(ways, axis=0)
        axis = ways[:, 0]
        if (np.abs(np.cross(axis, ways.T)) <= _SAME_LINE).all():
            slides = bool((np.abs(axis @ linear) > _SAME_LINE).any())
            found[index] = AxisInBodies(axis, bool(angular.any()), slides)
    return found
