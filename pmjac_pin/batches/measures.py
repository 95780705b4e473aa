"""Measures of many poses, as `EquivalentJacobian` and `Singularity` define them for one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pmjac_pin.algebra.singular_values import singular_values
from pmjac_pin.batches.results import ManyEllipsoids, ManyMeasures, Status, Statuses
from pmjac_pin.rates.ellipse import flattened
from pmjac_pin.rates.partition import Partition
from pmjac_pin.rates.tool_reach import RADIUS_ROUNDING
from pmjac_pin.values.arrays import Array

_TOGETHER = 512  # poses whose matrices like K* stay in the processor's cache


def with_extremes(
    by: Callable[[Array], Array], inputs: Array, numbers: int, partition: Partition
) -> tuple[Array, Array]:
    """Return what is told of poses, and extreme singular values of what is like K*.

    Parameters
    ----------
    by : callable
        Runs `RecordedRates.measures_tape`: inputs (nq, N) ↦ outputs.
    inputs : ndarray, shape (nq, N)
    numbers : int
        How many of the outputs are told; the others are the entries of what is like K*.
    partition : Partition

    Returns
    -------
    ndarray, ndarray
        Shapes (numbers, N), and (2, N): the largest and the smallest of K*'s generic rank.
    """
    rank, count = partition.passive_rank, inputs.shape[1]
    told, extremes = np.empty((numbers, count)), np.zeros((2, count))
    for start in range(0, count, _TOGETHER):
        part = slice(start, start + _TOGETHER)
        found = by(inputs[:, part])
        told[:, part] = found[:numbers]
        if rank:
            like = found[numbers:].reshape(-1, partition.passive.size, found.shape[1])
            extremes[:, part] = singular_values(like, (0, rank - 1))
    return told, extremes


def with_radii(J_eq: Array, status: Statuses, sizes: Array) -> ManyEllipsoids:
    """Return the radii of poses.

    Parameters
    ----------
    J_eq, status : ndarray, shapes (6, n, N) and (N,)
    sizes : ndarray, shape (2, N)
        What the linear and the angular entries are compared with.
    """
    return ManyEllipsoids(
        J_eq=J_eq.transpose(2, 0, 1),
        status=status,
        velocity_radii=_radii_of_blocks(J_eq[:3], sizes[0]).T,
        angular_radii=_radii_of_blocks(J_eq[3:], sizes[1]).T,
    )


def measured(
    J_eq: Array, status: Statuses, told: Array, extremes: Array, partition: Partition
) -> ManyMeasures:
    """Return the measures of poses.

    Parameters
    ----------
    J_eq, status : ndarray, shapes (6, n, N) and (N,)
    told : ndarray, shape (15, N)
        What `RecordedRates.measures_tape` gives between J_eq and the last.
    extremes : ndarray, shape (2, N)
        As `with_extremes` returns them.
    partition : Partition
    """
    is_open = status == Status.OPEN
    smallest, condition = _nearness(extremes, told[0], partition)
    smallest[is_open] = condition[is_open] = np.nan
    tool = np.where(is_open, np.nan, told[3:])
    return ManyMeasures(
        **vars(with_radii(J_eq, status, told[1:3])),
        smallest=smallest,
        condition=condition,
        position=tool[:3].T,
        rotation=tool[3:].reshape(3, 3, -1).transpose(2, 0, 1),
    )


def _radii_of_blocks(block: Array, size: Array) -> Array:
    """Return singular values of (3, n, N) blocks, (3, N), zero where they are rounding."""
    radii = np.zeros((3, block.shape[2]))
    values = singular_values(block)
    radii[: len(values)] = values
    flat = flattened(radii, radii[0])
    flat[flat <= RADIUS_ROUNDING * size] = 0.0
    flat[:, np.isnan(radii).any(axis=0)] = np.nan
    return flat


def _nearness(extremes: Array, size: Array, partition: Partition) -> tuple[Array, Array]:
    """Return `Singularity.smallest` and `condition`."""
    count = size.size
    if not partition.passive_rank:
        return np.full(count, np.inf), np.ones(count)
    largest, smallest = extremes / np.maximum(size, partition.least_size)
    condition = np.full(count, np.inf)
    np.divide(largest, smallest, out=condition, where=smallest > 0.0)
    return smallest.copy(), condition
