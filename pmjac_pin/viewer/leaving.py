"""Leaving singular poses: a path that starts there cannot know which mode it is to follow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ClosureError
from pmjac_pin.values.arrays import Array

# Near a fold the passive joints move with the square root of the motors' way: how far the motors
# go, as a share of the way to the target, and how far the linkage may go along its free motion.
_SHARES = (1e-4, 1e-3, 1e-2)
_SHARES_OF_MOTION = (0.0, 0.01, -0.01, 0.03, -0.03, 0.1, -0.1)  # times the motion, of norm 1


_STEP_BACK = 1e-3  # m or rad, of all motors together


def shortly_before(start: Configuration, singular: Configuration) -> Configuration:
    """Return a pose on the way from a start to the singular pose where it ended.

    From there, and not from the start itself, which may be far away, the motors move on.
    """
    way = singular.actuated - start.actuated
    distance = float(np.linalg.norm(way))
    if distance <= _STEP_BACK:
        return start
    near = start.actuated + (1.0 - _STEP_BACK / distance) * way
    return _closed_beside(start, near, start) or start


def beside_singularity(configuration: Configuration, values: Array) -> Configuration | None:
    """Return a regular pose next to a singular one, on the way to these motor values.

    Two assembly modes are one at a fold, and branches may cross there: the one that leads home
    is preferred. Nothing where the loops close on none of them, as beyond a fold.

    Parameters
    ----------
    configuration : Configuration
        Singular: with the motors locked something is free to move.
    values : ndarray, shape (n,)
        Motor values, m or rad.
    """
    for share in _SHARES:
        near = configuration.actuated + share * (values - configuration.actuated)
        tried = (_closed_beside(configuration, near, guess) for guess in _guesses(configuration))
        found = [pose for pose in tried if pose and not pose.singularity().is_singular]
        if found:
            return next(filter(_leads_home, found), found[0])
    return None


def _closed_beside(
    pose: Configuration, values: Array, guess: Configuration | Mapping[str, Any]
) -> Configuration | None:
    try:
        return pose.mechanism.close(values, guess=guess)
    except ClosureError:
        return None


def _leads_home(pose: Configuration) -> bool:
    home = pose.mechanism.home
    reached = _closed_beside(pose, home.actuated, pose)
    return reached is not None and bool(np.allclose(reached.q, home.q, atol=1e-6))


def _guesses(configuration: Configuration) -> Iterator[Mapping[str, Any]]:
    """Yield values of the passive joints beside the pose, along what is free there."""
    mechanism = configuration.mechanism
    model = mechanism.model
    joints = [
        (name, joint)
        for name, joint in list(zip(model.names, model.joints, strict=True))[1:]
        if name not in mechanism.spec.actuated
    ]
    v = np.zeros(model.nv)
    columns = configuration.split_jacobian().partition.passive
    for distance in _SHARES_OF_MOTION:
        for rates in configuration.singularity().free_motions.T:
            v[columns] = distance * rates
            q = pin.integrate(model, configuration.q, v)
            yield {name: q[joint.idx_q : joint.idx_q + joint.nq] for name, joint in joints}
