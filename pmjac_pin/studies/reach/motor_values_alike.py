"""Whether two poses have the same motor values."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.values.arrays import norm

_SAME_MOTORS = 1e-6  # rad or characteristic lengths


def same_values(one: Configuration, other: Configuration, joints: Iterable[str]) -> bool:
    """Tell whether joints have the same values in two poses of a mechanism, full turns aside."""
    mechanism = one.mechanism
    coordinates, partition = mechanism.coordinates, mechanism.problem.partition
    columns = coordinates.columns(joints)
    apart = coordinates.motion_to(one.q, columns, coordinates.values_of(other.q, columns))
    turned = np.remainder(apart + np.pi, 2.0 * np.pi) - np.pi
    apart = np.where(coordinates.rotational[columns], turned, apart)
    return norm(apart / partition.column_scale[columns]) <= _SAME_MOTORS * partition.length
