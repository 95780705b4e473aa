"""The limits of motor rates and efforts that a model states."""

from __future__ import annotations

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.values.arrays import Array


def motor_rate_limits(mechanism: Mechanism) -> Array:
    """Return limits of motor rates (n,), m/s or rad/s, infinite where the model states none.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> motor_rate_limits(pj.load("five_bar")).tolist()
    [10.0, 10.0]
    """
    partition = mechanism.problem.partition
    return partition.rate_limits[partition.actuated]


def motor_effort_limits(mechanism: Mechanism) -> Array:
    """Return limits of motor efforts (n,), N or N m, infinite where the model states none.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> motor_effort_limits(pj.load("planar_3rpr")).tolist()
    [1000.0, 1000.0, 1000.0]
    """
    partition = mechanism.problem.partition
    return partition.effort_limits[partition.actuated]
