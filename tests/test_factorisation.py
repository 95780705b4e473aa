"""The factorisation: pseudoinverses of a given rank."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.rates.rank_bounds import RankBounds


@pytest.mark.parametrize(
    "shape", [(3, 3, 3), (5, 3, 3), (3, 5, 3), (6, 6, 4), (9, 4, 2), (1, 1, 1)]
)
def test_the_inverse_by_the_generic_rank_is_the_pseudoinverse(shape, rng):
    rows, columns, rank = shape
    matrix = rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, columns))
    inverse = factorise(matrix, 1.0).inverse(rank)
    np.testing.assert_allclose(inverse, np.linalg.pinv(matrix, rcond=1e-10), atol=1e-10)


@pytest.mark.parametrize("share", [0.0, 1e-16, 1e-9, 0.5e-6, 0.999e-6, 1.001e-6, 2e-6, 1e-3, 1.0])
@pytest.mark.parametrize("count", [1, 2, 5, 18])
def test_what_the_inverse_tells_is_what_singular_values_tell(share, count, rng):
    """Ranks on either side of the tolerance, whichever way they are found."""
    for _ in range(10):
        left, right = (np.linalg.qr(rng.normal(size=(count, count)))[0] for _ in range(2))
        values = np.append(rng.uniform(0.5, 1.0, count - 1), share)
        matrix, size = (left * values) @ right, np.linalg.norm(values) or 1.0
        factors, b = factorise(matrix, size), rng.normal(size=(count, 3))
        expected = np.linalg.svd(matrix)[1]
        rank = np.count_nonzero(expected > 1e-6 * size)
        assert factors.rank == rank
        for least in (0.0, 0.1 * share, 0.99 * share, 1.01 * share, 2.0):
            assert factors.exceeds(count, least) == (expected[-1] > least)
        np.testing.assert_array_equal(factors.singular_values, expected)
        if rank:
            pseudo = np.linalg.pinv(matrix, rcond=1e-6 * size / expected[0])
            scale = np.linalg.norm(pseudo)
            np.testing.assert_allclose(factors.inverse(rank), pseudo, atol=1e-8 * scale)
            np.testing.assert_allclose(factors.solve(b), pseudo @ b, atol=1e-8 * scale)


@pytest.mark.parametrize("share", [0.0, 1e-9, 0.999e-6, 1.001e-6, 1e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("shape", [(41, 40), (90, 60)])
def test_of_many_columns_it_is_the_same(shape, share, rng):
    """Where AᵀA loses half of the digits, Q R does not."""
    rows, columns = shape
    for _ in range(3):
        left, right = (np.linalg.qr(rng.normal(size=(count, columns)))[0] for count in shape)
        values = np.append(rng.uniform(0.5, 1.0, columns - 1), share)
        size, b = np.linalg.norm(values), rng.normal(size=(rows, 3))
        values[-1] *= size
        matrix = (left * values) @ right.T
        factors = factorise(matrix, size)
        assert factors.surely_exceeds(0.9 * values[-1]) == (share >= 1e-5)
        rank = columns - (share < 1e-6)
        assert factors.rank == rank
        pseudo = (right[:, :rank] / values[:rank]) @ left[:, :rank].T
        atol = 1e-13 * np.linalg.norm(pseudo) / values[rank - 1]
        np.testing.assert_allclose(factors.inverse(rank), pseudo, rtol=0.0, atol=atol)
        np.testing.assert_allclose(factors.solve(b), pseudo @ b, rtol=0.0, atol=30.0 * atol)
        np.testing.assert_array_equal(factors.singular_values, np.linalg.svd(matrix)[1])


@pytest.mark.parametrize("rows", [5, 6, 15])
def test_weak_columns_are_solved_for_as_precisely_whether_rows_are_redundant_or_not(rows, rng):
    """AᵀA has the square of their share: no digits are lost by it."""
    for _ in range(10):
        left, right = (np.linalg.qr(rng.normal(size=(count, 5)))[0] for count in (rows, 5))
        matrix = (left * [1.0, 0.9, 0.5, 0.1, 5e-3]) @ right
        pseudo, b = np.linalg.pinv(matrix), rng.normal(size=(rows, 3))
        factors, atol = factorise(matrix, np.linalg.norm(matrix)), 1e-12 * np.linalg.norm(pseudo)
        assert factors.surely_exceeds(1e-4)
        np.testing.assert_allclose(factors.inverse(5), pseudo, rtol=0.0, atol=atol)
        np.testing.assert_allclose(factors.solve(b), pseudo @ b, rtol=0.0, atol=10.0 * atol)


@pytest.mark.parametrize("size", [0.0, 1e-3, 1.0, 50.0])
def test_what_bounds_call_certain_is_so_by_singular_values(size, rng):
    """Of K* of all smallest singular values, one at a time and all at once."""
    bounds = RankBounds(tolerance=1e-6, least_size=0.1, share=0.999, weakest=1e-4)
    inverse = np.concatenate([[0.0, math.inf], 10.0 ** rng.uniform(-2.0, 9.0, 200)])
    forbidden = np.concatenate([[0.0, math.inf], 10.0 ** rng.uniform(-12.0, 0.0, 200)])
    zero = 1e-6 * max(size, 0.1)
    smallest = 1.0 / np.maximum(inverse, 1e-300)
    certain, follows = bounds.regular(inverse, size), bounds.follows(forbidden, size)
    assert (certain == (smallest > max(zero, 1e-4 * size) / 0.999)).all()
    assert (follows == (forbidden <= 0.999 * zero)).all()
    one_by_one = [bounds.regular(one, size) for one in inverse.tolist()]
    assert one_by_one == certain.tolist()
    assert [bounds.follows(one, size) for one in forbidden.tolist()] == follows.tolist()


@pytest.mark.parametrize("share", [1e-80, 1e-100, 1e-160, 1e-200, 1e-300, 5e-324, 0.0])
@pytest.mark.parametrize("shape", [(2, 2), (3, 2), (60, 45)])
def test_a_matrix_that_is_singular_but_for_next_to_nothing_has_no_rank_there(shape, share):
    """Squares of its inverse overflow, which is told to nobody."""
    matrix = np.eye(*shape)
    matrix[1, 1] = share
    factors = factorise(matrix, 1.0)
    assert factors.rank == shape[1] - 1
    assert factors.exceeds(factors.rank, 0.5)
    assert not factors.surely_exceeds(0.5)
