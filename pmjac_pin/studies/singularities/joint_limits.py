"""Whether poses are within the limits of all joints, wherever full turns lead there."""

from __future__ import annotations

import numpy as np

from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.values.arrays import Array, Index, Mask

_WHOLE_TURN = 2.0 * np.pi
_LENIENT = 1e-9  # m or rad


def limited(coordinates: JointCoordinates) -> Index:
    """Return the columns of the freedoms that limits keep from something: no whole turn."""
    bounded = np.isfinite(coordinates.lower) | np.isfinite(coordinates.upper)
    turns = coordinates.angles & (coordinates.upper - coordinates.lower >= _WHOLE_TURN - _LENIENT)
    return np.flatnonzero(bounded & ~turns)


def within_joint_limits(coordinates: JointCoordinates, q: Array) -> Mask:
    """Tell which poses (N, nq) have all joints within their limits, angles less full turns."""
    return limits_between(coordinates, q, q)


def limits_between(coordinates: JointCoordinates, q: Array, other: Array) -> Mask:
    """Tell between which poses (N, nq) and others each joint may be within its limits.

    As values do that change by less than half a turn, and never back on the way.
    """
    columns = limited(coordinates)
    values = coordinates.values_of(q, columns)
    change = coordinates.values_of(other, columns) - values
    lower, upper = coordinates.lower[columns], coordinates.upper[columns]
    angles = coordinates.angles[columns]
    change[:, angles] -= _WHOLE_TURN * np.round(change[:, angles] / _WHOLE_TURN)
    low, high = values + np.minimum(change, 0.0), values + np.maximum(change, 0.0)
    turning = angles & np.isfinite(lower)
    # The least turn of the upper end that is not below the lower limit.
    least = lower[turning] - _LENIENT
    turned = least + np.remainder(high[:, turning] - least, _WHOLE_TURN) - high[:, turning]
    low[:, turning] += turned
    high[:, turning] += turned
    within = (high >= lower - _LENIENT) & (low <= upper + _LENIENT)
    return np.asarray(within.all(axis=1))
