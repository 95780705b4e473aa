"""Ranks of loops, on matrices whose dependencies were put in."""

from __future__ import annotations

import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.rates.redundancy import dependent_rows, loop_ranks


def partition_of(matrix):
    columns = matrix.shape[1]
    return pj.Partition.from_matrices(matrix, np.eye(6, columns), [0], range(1, columns))


@pytest.mark.parametrize("shared", [0, 1, 2])
@pytest.mark.parametrize("inside", [0, 1])
def test_what_was_put_in_is_found(shared, inside, rng):
    """Loop b repeats combinations of rows of a, and c has rows that follow from its others."""
    for _ in range(10):
        a, b, c = rng.normal(size=(3, 10)), rng.normal(size=(3, 10)), rng.normal(size=(2, 10))
        b[:shared] = rng.normal(size=(shared, 3)) @ a
        c = np.vstack([c, rng.normal(size=(inside, 2)) @ c])
        mixed = np.vstack([a, rng.normal(size=(3, 3)) @ b, c])
        slices, partition = [slice(0, 3), slice(3, 6), slice(6, 8 + inside)], partition_of(mixed)
        scaled = partition.scaled(mixed)
        first, second, third = loop_ranks(scaled, slices, partition)
        implied = [loop.rank - loop.needed for loop in (first, second, third)]
        assert implied == [shared, shared, 0]
        assert [loop.redundant_inside for loop in (first, second, third)] == [0, 0, inside]
        dependent = dependent_rows(scaled, partition)
        assert len(dependent) == shared + inside
        own = range(6, 8 + inside)
        for row, others in dependent.items():
            assert set(others) <= (set(own) if row in own else set(range(6)))
            assert others
