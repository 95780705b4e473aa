"""Measures of many poses, as `EquivalentJacobian` and `Singularity` define them for one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.singular_values import singular_values
from pmjac_pin.batches.results import Status
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, Mask

_TOGETHER = 512  # poses whose matrices like K* stay in the processor's cache

#: (some of the poses, their J_eq) ↦ what `RecordedRates.measures_tape` gives behind J_eq, and where
#: this is certain; it fills J_eq.
FillPart: TypeAlias = Callable[[slice, Array], tuple[Array, Mask]]


def fill_measures(
    fill: FillPart, partition: Partition, found: Sequence[NDArray[Any]]
) -> tuple[Array, Mask]:
    """Find what is measured at poses, but for what rests on a J_eq that is certain.

    Parameters
    ----------
    fill : callable
    partition : Partition
    found : sequence of ndarray
        The arrays of `ManyMeasures`: all are filled but the status and the radii.

    Returns
    -------
    ndarray, ndarray of bool
        Sizes that the radii are compared with, shape (2, N), and where J_eq is certain, (N,).
    """
    J_eq, _, _, _, smallest, condition, position, rotation = found
    sizes, certain = np.empty((2, len(J_eq))), np.empty(len(J_eq), dtype=bool)
    for start in range(0, len(J_eq), _TOGETHER):
        part = slice(start, start + _TOGETHER)
        told, certain[part] = fill(part, J_eq[part])
        sizes[:, part] = told[1:3]
        position[part] = told[3:6].T
        rotation[part] = told[6:15].reshape(3, 3, -1).transpose(2, 0, 1)
        extremes = _extreme_values(told[15:], partition)
        _fill_nearness(extremes, told[0], partition, smallest[part], condition[part])
    return sizes, certain


def blank_open(found: Sequence[NDArray[Any]]) -> None:
    """Say of poses whose loops are open, in the arrays of `ManyMeasures`, that nothing is known."""
    _, status, _, _, *others = found
    is_open = status == Status.OPEN
    if is_open.any():
        for array in others:
            array[is_open] = np.nan


def _extreme_values(entries: Array, partition: Partition) -> Array:
    """Return the largest and the smallest singular value of K*'s generic rank, shape (2, N)."""
    rank, count = partition.passive_rank, entries.shape[1]
    if not rank:
        return np.zeros((2, count))
    like = entries.reshape(-1, partition.passive.size, count)
    return singular_values(like, (0, rank - 1))


def _fill_nearness(
    extremes: Array, size: Array, partition: Partition, smallest: Array, condition: Array
) -> None:
    """Find `Singularity.smallest` and `condition` of poses, beside ‖[K K*]‖."""
    condition[:] = np.inf
    if not partition.passive_rank:
        smallest[:], condition[:] = np.inf, 1.0
        return
    largest, smallest[:] = extremes / np.maximum(size, partition.least_size)
    np.divide(largest, smallest, out=condition, where=smallest > 0.0)
