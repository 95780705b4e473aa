"""The factorisation: what it says of the way from one matrix to another."""

from __future__ import annotations

import numpy as np
import pytest

from pmjac_pin.factorisation import factorise


def of_rank(rng, rows, columns, rank, weakest):
    """A matrix with singular values from 1 down to `weakest`."""
    left = np.linalg.qr(rng.normal(size=(rows, rank)))[0]
    right = np.linalg.qr(rng.normal(size=(columns, rank)))[0]
    return (left * np.geomspace(1.0, weakest, rank)) @ right.T


def way(start, straight, bend):
    return lambda s: start + s * straight + s**2 * bend


def says_regular(path, rank):
    factors = factorise(path(0.0), 1.0)
    return factors.stays_regular(path(1.0), lambda: path(0.5), rank)


SHAPES = [(3, 3, 3), (5, 3, 3), (3, 5, 3), (6, 6, 4), (9, 4, 2), (1, 1, 1)]


@pytest.mark.parametrize("shape", SHAPES)
def test_a_way_that_is_called_regular_loses_no_rank(shape, rng):
    """Exact for quadratic ways, whatever the shape and however much the rest changes."""
    rows, columns, rank = shape
    answers = []
    for size in np.geomspace(1e-3, 1.0, 100):
        start = of_rank(rng, rows, columns, rank, 10.0 ** rng.uniform(-4, 0))
        left, values, right = np.linalg.svd(start)
        part = np.zeros((rows, columns))
        # Changes that grow with what they change: only such steps are longer than σ_r.
        part[:rank, :rank] = values[:rank, None] * rng.normal(size=(rank, rank))
        bend = left @ part @ right * size
        straight = left @ rng.permuted(part, axis=1) @ right * size
        outside = rng.normal(size=(rows, columns))
        outside = outside - left[:, :rank] @ left[:, :rank].T @ outside
        path = way(start, straight + outside, bend)
        factors = factorise(start, 1.0)
        if np.linalg.norm(factors.change_to(path(1.0), rank)) < 0.7 * values[rank - 1]:
            continue
        answers.append(says_regular(path, rank))
        if answers[-1]:
            worst = min(
                np.linalg.svd(path(s), compute_uv=False)[rank - 1] for s in np.linspace(0, 1, 41)
            )
            assert worst > 0.2 * values[rank - 1]
    assert rank == 1 or {True, False} <= set(answers)


def test_a_strong_direction_may_change_by_more_than_the_weak_one_is():
    start = np.diag([1.0, 1e-4])
    for change in (np.diag([0.5, 0.0]), np.array([[0.3, 0.5], [0.0, 0.0]])):
        assert says_regular(way(start, change, 0.0), 2)
        assert not says_regular(way(start, change.T[::-1, ::-1], 0.0), 2)


@pytest.mark.parametrize(("dip", "expected"), [(0.3, True), (1.5, False), (40.0, False)])
def test_a_weak_direction_that_dips_on_the_way_is_seen(dip, expected):
    """σ(s) = σ (1 − 4 s (1 − s) dip): both ends alike, and beyond 1 two singularities between."""
    start, weak = np.diag([1.0, 1e-4]), np.diag([0.0, 1e-4])
    path = way(start, np.diag([0.3, 0.0]) - 4 * dip * weak, 4 * dip * weak)
    np.testing.assert_allclose(path(1.0), np.diag([1.3, 1e-4]))
    assert says_regular(path, 2) is expected


def test_short_ways_are_not_looked_at_twice(rng):
    for _ in range(50):
        start = of_rank(rng, 4, 4, 4, 1e-3)
        change = rng.normal(size=(4, 4))
        change *= 0.69e-3 / np.linalg.norm(change)
        factors = factorise(start, 1.0)
        assert factors.stays_regular(start + change, lambda: pytest.fail("evaluated"), 4)
