"""Measures of many poses, as `EquivalentJacobian` and `Singularity` define them for one."""

from __future__ import annotations

import numpy as np

from pmjac_pin.algebra.singular_values import singular_values
from pmjac_pin.batches.results import ManyMeasures, Status, Statuses
from pmjac_pin.rates.ellipse import flattened
from pmjac_pin.rates.partition import Partition
from pmjac_pin.rates.tool_reach import RADIUS_ROUNDING
from pmjac_pin.values.arrays import Array


def measured(J_eq: Array, status: Statuses, found: Array, partition: Partition) -> ManyMeasures:
    """Return the measures of poses.

    Parameters
    ----------
    J_eq, status : ndarray, shapes (6, n, N) and (N,)
    found : ndarray, shape (15 + k m_p, N)
        What `RecordedRates.measures_tape` gives after J_eq.
    partition : Partition
    """
    size, linear, angular = found[:3]
    tool = np.where(status == Status.OPEN, np.nan, found[3:15]).T
    smallest, condition = _nearness(found[15:], size, partition)
    smallest[status == Status.OPEN] = condition[status == Status.OPEN] = np.nan
    return ManyMeasures(
        J_eq=J_eq.transpose(2, 0, 1),
        status=status,
        velocity_radii=_radii_of_blocks(J_eq[:3], linear),
        angular_radii=_radii_of_blocks(J_eq[3:], angular),
        smallest=smallest,
        condition=condition,
        position=tool[:, :3],
        rotation=tool[:, 3:].reshape(-1, 3, 3),
    )


def _radii_of_blocks(block: Array, size: Array) -> Array:
    """Return singular values of (3, n, N) blocks, (N, 3), zero where they are rounding."""
    values = singular_values(block).T
    radii = np.zeros((len(values), 3))
    radii[:, : values.shape[1]] = values
    flat = flattened(radii, radii[:, :1])
    flat[flat <= RADIUS_ROUNDING * size[:, None]] = 0.0
    flat[np.isnan(radii).any(axis=1)] = np.nan
    return flat


def _nearness(entries: Array, size: Array, partition: Partition) -> tuple[Array, Array]:
    """Return `Singularity.smallest` and `condition` of (k m_p, N) entries like K*."""
    rank, count = partition.passive_rank, entries.shape[1]
    if not rank:
        return np.full(count, np.inf), np.ones(count)
    blocks = entries.reshape(-1, partition.passive.size, count)
    values = singular_values(blocks, (0, rank - 1)) / np.maximum(size, partition.least_size)
    largest, smallest = values
    condition = np.full(count, np.inf)
    np.divide(largest, smallest, out=condition, where=smallest > 0.0)
    return smallest.copy(), condition
