"""Paths of whole poses: waypoints between which a tool slides straight and turns about one axis.

R(s) = R₀ exp(s log(R₀ᵀ R₁)) between two of them, the shorter way, as s goes from 0 to 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.studies.follow.given_path import ascending_times, waypoint_times
from pmjac_pin.studies.reach.targets import given_pose
from pmjac_pin.values.arrays import Array

_POSE_SHAPE = (4, 4)
_HALF_TURN = 1e-6  # rad less than that: no way is the shorter one


@dataclass(frozen=True, slots=True, eq=False)
class PosePath:
    """A pose for each parameter.

    Attributes
    ----------
    at : callable
        t ↦ pin.SE3.
    times : ndarray, shape (k,)
        Where it begins and ends, and between these where it has kinks.
    """

    at: Callable[[float], pin.SE3]
    times: Array


def is_of_poses(path: Any) -> bool:
    """Tell whether waypoints are poses, by the first of them."""
    try:
        first = path[0]
    except (TypeError, KeyError, IndexError):
        return False
    return isinstance(first, pin.SE3) or np.shape(first) == _POSE_SHAPE


def pose_path(path: Any, times: Any) -> PosePath:
    """Return the path of waypoints (N poses), or of a function t ↦ pose.

    Raises
    ------
    ArgumentError
        What is no pose, or no two of them; times that do not fit; waypoints half a turn apart.
    """
    given = None if times is None else ascending_times(times)
    if callable(path):
        if given is None:
            raise ArgumentError("a path that is a function needs `times`, where it begins and ends")
        return PosePath(lambda t: _pose(path(t), f"the path at t = {t:g}"), given)
    if not is_of_poses(path):
        raise ArgumentError(f"poses are wanted, pin.SE3 or 4x4 matrices, got {quoted(path)}")
    poses = [_pose(one, f"waypoint {k}") for k, one in enumerate(path)]
    given = waypoint_times(len(poses), given)
    return PosePath(_Waypoints(poses, given), given)


class _Waypoints:
    """Straight ways between poses, turning about one axis each."""

    def __init__(self, poses: list[pin.SE3], times: Array) -> None:
        self._poses, self._times = poses, times
        pairs = list(pairwise(poses))
        self._turns = [pin.log3(one.rotation.T @ other.rotation) for one, other in pairs]
        for k, turn in enumerate(self._turns):
            if np.linalg.norm(turn) > np.pi - _HALF_TURN:
                raise ArgumentError(
                    f"waypoints {k} and {k + 1} are half a turn apart: put one between them"
                )

    def __call__(self, t: float) -> pin.SE3:
        last = len(self._turns) - 1
        k = min(max(int(np.searchsorted(self._times, t, "right")) - 1, 0), last)
        start, end = self._times[k], self._times[k + 1]
        share, one, other = (t - start) / (end - start), self._poses[k], self._poses[k + 1]
        slid = one.translation + share * (other.translation - one.translation)
        return pin.SE3(one.rotation @ pin.exp3(share * self._turns[k]), slid)


def _pose(given: Any, what: str) -> pin.SE3:
    pose = given_pose(given)
    if pose is None:
        wanted = "a pose, pin.SE3 or a 4x4 matrix"
        raise ArgumentError(f"{what} is no pose: {wanted} is wanted, got {quoted(given)}")
    return pose
