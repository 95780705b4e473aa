"""Motor rates that loops allow and motions that no motor commands, on random loops."""

from __future__ import annotations

import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.rates.actuation import analyse_actuation, sparse_basis


@pytest.mark.parametrize(
    ("motors", "passive", "rows"), [(1, 3, 3), (2, 1, 2), (1, 4, 2), (3, 2, 4)]
)
def test_allowed_and_free_motions_satisfy_the_loop_equations(motors, passive, rows, rng):
    for length in (0.05, 1.0, 30.0):
        C = rng.normal(size=(rows, motors + passive))
        J = rng.normal(size=(6, motors + passive))
        columns = list(range(motors + passive))
        partition = pj.Partition.from_matrices(
            C, J, columns[:motors], columns[motors:], length=length
        )
        found = analyse_actuation(C, J, partition)
        K, K_star = C[:, :motors], C[:, motors:]
        np.testing.assert_allclose(K_star @ found.free, 0.0, atol=1e-9)
        assert found.free.shape == (passive, max(0, passive - rows))
        assert found.allowed.shape == (motors, max(0, min(motors, motors + passive - rows)))
        for rates in found.allowed.T:
            rest = np.linalg.lstsq(K_star, -K @ rates, rcond=None)[0]
            np.testing.assert_allclose(K @ rates + K_star @ rest, 0.0, atol=1e-9)
        np.testing.assert_allclose(found.allowed[found.sufficient], np.eye(found.sufficient.size))
        assert found.felt.all()
        assert found.felt_rank == found.free.shape[1]


def test_motions_without_a_joint_in_common_come_apart(rng):
    apart = np.zeros((7, 3))
    apart[:2, 0], apart[2:5, 1], apart[5:, 2] = rng.normal(size=2), rng.normal(size=3), [1.0, 2.0]
    basis, pivots = sparse_basis(apart @ rng.normal(size=(3, 3)))
    assert np.count_nonzero(basis) == 7
    np.testing.assert_allclose(basis[pivots], np.eye(3), atol=1e-12)
    assert np.linalg.matrix_rank(np.column_stack([basis, apart]), tol=1e-9) == 3
