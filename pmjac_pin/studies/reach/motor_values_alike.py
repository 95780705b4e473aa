"""Poses that differ in the values of some joints, and those that do not."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.values.arrays import norm

_SAME_MOTORS = 1e-6  # rad or characteristic lengths


def of_other_values(poses: Iterable[Configuration], joints: Sequence[str]) -> list[Configuration]:
    """Return each pose in which these joints have other values than in those before it."""
    distinct: list[Configuration] = []
    for pose in poses:
        if not any(_same_values(pose, one, joints) for one in distinct):
            distinct.append(pose)
    return distinct


def _same_values(one: Configuration, other: Configuration, joints: Sequence[str]) -> bool:
    """Tell whether joints have the same values in two poses of a mechanism, full turns aside."""
    mechanism = one.mechanism
    coordinates, partition = mechanism.coordinates, mechanism.problem.partition
    columns = coordinates.columns(joints)
    apart = coordinates.motion_to(one.q, columns, coordinates.values_of(other.q, columns))
    turned = np.remainder(apart + np.pi, 2.0 * np.pi) - np.pi
    apart = np.where(coordinates.rotational[columns], turned, apart)
    return norm(apart / partition.column_scale[columns]) <= _SAME_MOTORS * partition.length
