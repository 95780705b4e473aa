"""Measures of many poses, as `EquivalentJacobian` and `Singularity` define them for one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.singular_values import singular_values
from pmjac_pin.batches.results import Status
from pmjac_pin.rates.many_radii import fill_radii
from pmjac_pin.rates.partition import Partition
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


def fill_nearness(
    extremes: Array, size: Array, partition: Partition, smallest: Array, condition: Array
) -> None:
    """Find `Singularity.smallest` and `condition` of poses, shape (N,).

    Parameters
    ----------
    extremes : ndarray, shape (2, N)
        As `with_extremes` returns them.
    size : ndarray, shape (N,)
        ‖[K K*]‖.
    partition : Partition
    smallest, condition : ndarray, shape (N,)
        Where they go.
    """
    condition[:] = np.inf
    if not partition.passive_rank:
        smallest[:], condition[:] = np.inf, 1.0
        return
    largest, smallest[:] = extremes / np.maximum(size, partition.least_size)
    np.divide(largest, smallest, out=condition, where=smallest > 0.0)


def fill_measures(
    told: Array, extremes: Array, partition: Partition, found: Sequence[NDArray[Any]]
) -> None:
    """Find what is measured at poses whose J_eq is settled.

    Parameters
    ----------
    told : ndarray, shape (15, N)
        What `RecordedRates.measures_tape` gives between J_eq and the last.
    extremes : ndarray, shape (2, N)
        As `with_extremes` returns them.
    partition : Partition
    found : sequence of ndarray
        The arrays of `ManyMeasures`: the first two are known, the others are filled.
    """
    J_eq, status, linear, angular, smallest, condition, position, rotation = found
    fill_radii(J_eq, told[1:3], linear, angular)
    fill_nearness(extremes, told[0], partition, smallest, condition)
    position[:] = told[3:6].T
    rotation[:] = told[6:].reshape(3, 3, -1).transpose(2, 0, 1)
    is_open = status == Status.OPEN
    if is_open.any():
        for array in (smallest, condition, position, rotation):
            array[is_open] = np.nan
