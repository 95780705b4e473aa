"""Goal: where a tool, or some joints, are to be, and how far from there a pose is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias, assert_never

import numpy as np
import pinocchio as pin

from pmjac_pin.kinematics.tool import tool_kinematics
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.tool_spec import Tool
from pmjac_pin.studies.reach.task import Task, heading
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.ties import first_smallest

_ENOUGH_FOR_TARGETS = 1e-9  # of the characteristic length, or rad
_TOLERANCES_OF_TARGETS = 4.0  # of the machine: far from the world's origin, nothing is closer


class Miss(NamedTuple):
    """How far a pose is from a target: all its positions, m, and all its turns, rad."""

    linear: float
    angular: float


class GapsToTarget(NamedTuple):
    """What is missing to a target, and how fast the joints make up for it.

    Attributes
    ----------
    linear, angular : ndarray, shapes (k,) and (a,)
        m and rad.
    linear_rates, angular_rates : ndarray, shapes (k, nv) and (a, nv)
        ½ |gap|² falls by exactly gapᵀ rates v, and the gap itself by rates v where it is small.
    """

    linear: Array
    angular: Array
    linear_rates: Array
    angular_rates: Array

    @property
    def miss(self) -> Miss:
        """Their norms."""
        return Miss(norm(self.linear), norm(self.angular))

    def in_metres(self, length: float) -> tuple[Array, Array]:
        """Return all gaps and all rates as rows, a rad counted as a length."""
        gap = np.concatenate([self.linear, length * self.angular])
        return gap, np.vstack([self.linear_rates, length * self.angular_rates])


@dataclass(frozen=True, eq=False)
class ToolGoal:
    """A tool's target.

    Attributes
    ----------
    tool : Tool
    task : Task
        What of the target counts.
    target : pin.SE3
        In the world.
    """

    tool: Tool
    task: Task
    target: pin.SE3

    def gaps(self, mechanism: Mechanism, q: Array) -> GapsToTarget:
        """Return what is missing at a closed pose."""
        twists, pose = tool_at(mechanism, self.tool, q)
        directions = self.task.linear
        linear = directions @ (self.target.translation - pose.translation)
        turning = self._turning(pose.rotation) @ twists[3:]
        return GapsToTarget(linear, self._turn(pose.rotation), directions @ twists[:3], turning)

    def pose_from(self, pose: pin.SE3) -> pin.SE3:
        """Return the target as a pose: where an axis is to point, turned the shortest way there."""
        if self.task.turning != "pointing":
            return self.target
        turn = pin.exp3(self._turn(pose.rotation))
        return pin.SE3(turn @ pose.rotation, self.target.translation)

    def _turn(self, rotation: Array) -> Array:
        wanted, axis = self.target.rotation, np.array(self.task.axis)
        match self.task.turning:
            case "free":
                return np.zeros(0)
            case "heading":
                turn = heading(wanted, axis) - heading(rotation, axis)
                return np.array([turn - 2.0 * np.pi * np.round(turn / (2.0 * np.pi))])
            case "pointing":
                return turn_between(rotation @ axis, wanted @ axis)
            case "orientation":
                return np.asarray(pin.log3(wanted @ rotation.T))
            case _:
                assert_never(self.task.turning)

    def _turning(self, rotation: Array) -> Array:
        """Return what of an angular velocity counts, as rows that fit those of `_turn`."""
        if self.task.turning != "pointing":
            return self.task.angular(rotation)
        pointing = rotation @ np.array(self.task.axis)
        return np.eye(3) - np.outer(pointing, pointing)


@dataclass(frozen=True, eq=False)
class JointGoal:
    """Values of degrees of freedom.

    Attributes
    ----------
    joints : tuple of str
        Of one degree of freedom each.
    values : ndarray, shape (k,)
        m or rad.
    """

    joints: tuple[str, ...]
    values: Array

    def gaps(self, mechanism: Mechanism, q: Array) -> GapsToTarget:
        """Return what is missing at a closed pose; what turns endlessly goes the shorter way."""
        coordinates = mechanism.coordinates
        columns = coordinates.columns(self.joints)
        missing, turns = coordinates.motion_to(q, columns, self.values), coordinates.rotational
        rows, angular = np.eye(mechanism.nv)[columns], turns[columns]
        return GapsToTarget(missing[~angular], missing[angular], rows[~angular], rows[angular])


Goal: TypeAlias = ToolGoal | JointGoal


def gaps_of(goals: Sequence[Goal], mechanism: Mechanism, q: Array) -> GapsToTarget:
    """Return what is missing to several goals."""
    found = [goal.gaps(mechanism, q) for goal in goals]
    return GapsToTarget(
        np.concatenate([one.linear for one in found]),
        np.concatenate([one.angular for one in found]),
        np.vstack([one.linear_rates for one in found]),
        np.vstack([one.angular_rates for one in found]),
    )


def is_met(goals: Sequence[Goal], mechanism: Mechanism, q: Array) -> bool:
    """Tell whether all goals are met: to 1e-9 of the characteristic length, and 1e-9 rad."""
    miss, length = gaps_of(goals, mechanism, q).miss, mechanism.characteristic_length
    closed = _TOLERANCES_OF_TARGETS * mechanism.tolerance
    return (
        miss.linear <= _ENOUGH_FOR_TARGETS * length + closed
        and miss.angular <= _ENOUGH_FOR_TARGETS + closed / length
    )


def tool_at(mechanism: Mechanism, tool: Tool, q: Array) -> tuple[Array, pin.SE3]:
    """Return a tool's Jacobian (6, nv), LOCAL_WORLD_ALIGNED, and its pose in the world."""
    kinematics = mechanism.kinematics
    twists, pose = kinematics.tool_at(q, tool_kinematics(kinematics.model, tool))
    return twists, pin.SE3(pose.rotation, pose.translation + mechanism.place)


def turn_between(one: Array, other: Array) -> Array:
    """Return the shortest rotation vector that takes a unit vector to another, shape (3,).

    Examples
    --------
    >>> turn_between(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])).round(4).tolist()
    [0.0, 0.0, 1.5708]
    """
    turn, cosine = np.cross(one, other), float(one @ other)
    sine = norm(turn)
    if sine == 0.0 and cosine > 0.0:
        return np.zeros(3)
    if sine == 0.0:
        turn = np.cross(one, np.eye(3)[first_smallest(one)])
        return np.asarray(np.pi * turn / norm(turn))
    return np.asarray(np.arctan2(sine, cosine) / sine * turn)
