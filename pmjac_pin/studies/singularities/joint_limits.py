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
    columns = limited(coordinates)
    values = coordinates.values_of(q, columns)
    lower, upper = coordinates.lower[columns], coordinates.upper[columns]
    turning = coordinates.angles[columns] & np.isfinite(lower)
    least = lower[turning] - _LENIENT
    values[:, turning] = least + np.remainder(values[:, turning] - least, _WHOLE_TURN)
    inside = (values >= lower - _LENIENT) & (values <= upper + _LENIENT)
    return np.asarray(inside.all(axis=1))
