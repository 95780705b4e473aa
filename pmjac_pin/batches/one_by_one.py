"""One by one: what the single calls say where a program is not certain."""

from __future__ import annotations

from typing import Any

import numpy as np

from pmjac_pin.batches.results import Status
from pmjac_pin.errors import ClosureError, NoJacobianError, SingularError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.values.arrays import Array


def close_one(mechanism: Mechanism, start: Array, values: Array) -> tuple[Array, float]:
    """Walk a path; return its end, and the share of the way."""
    guess = mechanism.configuration(start)
    try:
        return mechanism.close(values, guess, enforce_limits=False).q, 1.0
    except ClosureError as error:
        return (start if error.reached is None else error.reached.q), error.share


def jacobian_of_one(mechanism: Mechanism, q: Array, frame: str) -> tuple[Any, Status]:
    """Return J_eq at a pose, or why there is none."""
    try:
        return mechanism.configuration(q).jacobian(frame).J_eq, Status.CLOSED
    except ClosureError:
        return np.nan, Status.OPEN
    except SingularError:
        return np.nan, Status.SINGULAR
    except NoJacobianError:
        return np.nan, Status.NO_JACOBIAN


def measures_of_one(mechanism: Mechanism, q: Array) -> dict[str, Any]:
    """Return the entries of `ManyMeasures` that are known at a pose."""
    J_eq, status = jacobian_of_one(mechanism, q, "LOCAL_WORLD_ALIGNED")
    found: dict[str, Any] = {"J_eq": J_eq, "status": status}
    if status == Status.OPEN:
        return found
    configuration = mechanism.configuration(q)
    singularity, tool = configuration.singularity(), configuration.tool_pose()
    found |= {"smallest": singularity.smallest, "condition": singularity.condition}
    found |= {"position": tool.translation, "rotation": tool.rotation}
    if status == Status.CLOSED:
        jacobian = configuration.jacobian()
        found["velocity_radii"] = jacobian.velocity_ellipsoid().radii
        found["angular_radii"] = jacobian.angular_ellipsoid().radii
    return found
