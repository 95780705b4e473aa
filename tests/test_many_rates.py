"""What the kernels find of many poses, row by row, is what programs and NumPy say of columns."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import SAMPLE, loaded

import pmjac_pin as pj
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.batches import many_rates
from pmjac_pin.batches.judge import certain_jacobians
from pmjac_pin.batches.many_rates import ManyRates
from pmjac_pin.batches.rates_in_lanes import rates_kernel
from pmjac_pin.closing.recorded_rates import DOUBTS
from pmjac_pin.rates.many_radii import _radii_of_blocks, fill_radii, radii_kernel

COUNTS = [1, 63, 64, 65, 200]


def poses_of_all_kinds(mechanism, count, rng):
    """Closed ones, such as lie on the brink of being open, and open ones."""
    targets = mechanism.home.actuated + rng.uniform(-0.3, 0.3, (count, len(mechanism.actuated)))
    q = pj.batch(mechanism).close(targets, enforce_limits=False, threads=1).q.copy()
    off = 10.0 ** rng.uniform(-14.0, 0.0, (count, 1)) * (rng.random((count, 1)) < 0.6)
    return q + off * mechanism.characteristic_length * rng.uniform(-1.0, 1.0, q.shape)


@pytest.mark.skipif(rates_kernel() is None, reason="no kernel was built")
@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("name", SAMPLE)
def test_rates_to_the_last_bit(name, count, rng):
    mechanism = loaded(name)
    recorded, tolerance = mechanism.recorded, mechanism.problem.tolerance
    tape, partition = recorded.ellipsoids, recorded.rates.partition
    q, n = poses_of_all_kinds(mechanism, count, rng), len(mechanism.actuated)
    J_eq = np.empty((count, 6, n))
    others, certain = ManyRates(tape, partition, tolerance).fill(q, J_eq)
    told = run(tape, q.T)
    entries = told[DOUBTS : DOUBTS + 6 * n].reshape(6, n, count)
    np.testing.assert_array_equal(J_eq, entries.transpose(2, 0, 1))
    np.testing.assert_array_equal(others, told[DOUBTS + 6 * n :])
    np.testing.assert_array_equal(certain, certain_jacobians(partition, tolerance, told))
    if count == COUNTS[-1] and not partition.isolated and partition.passive_rank:
        assert 0 < certain.sum() < count


@pytest.mark.parametrize("name", SAMPLE)
def test_without_a_kernel(name, rng, monkeypatch):
    mechanism = loaded(name)
    recorded, tolerance = mechanism.recorded, mechanism.problem.tolerance
    given = recorded.ellipsoids, recorded.rates.partition, tolerance
    q = poses_of_all_kinds(mechanism, 70, rng)
    by_kernel, by_numpy = np.empty((2, 70, 6, len(mechanism.actuated)))
    told = ManyRates(*given).fill(q, by_kernel)
    monkeypatch.setattr(many_rates, "rates_kernel", lambda: None)
    others, certain = ManyRates(*given).fill(q, by_numpy)
    np.testing.assert_array_equal(by_numpy, by_kernel)
    np.testing.assert_array_equal(others, told[0])
    np.testing.assert_array_equal(certain, told[1])


@pytest.mark.parametrize("without", ["nothing", "rates_kernel", "radii_kernel"])
@pytest.mark.parametrize("name", SAMPLE)
def test_radii_behind_rates_are_those_of_them(name, without, rng, monkeypatch):
    mechanism = loaded(name)
    recorded, tolerance = mechanism.recorded, mechanism.problem.tolerance
    q = poses_of_all_kinds(mechanism, 70, rng)
    J_eq = np.empty((70, 6, len(mechanism.actuated)))
    found, expected = np.full((2, 2, 70, 3), 7.0)
    if without != "nothing":
        monkeypatch.setattr(many_rates, without, lambda: None)
    rates = ManyRates(recorded.ellipsoids, recorded.rates.partition, tolerance)
    sizes, _ = rates.fill(q, J_eq, tuple(found))
    fill_radii(J_eq, sizes, *expected)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.skipif(radii_kernel() is None, reason="no kernel was built")
@pytest.mark.parametrize("count", [1, 31, 32, 33, 100])
@pytest.mark.parametrize("motors", [0, 1, 2, 3, 6, 12])
def test_radii_to_the_last_bit(motors, count, rng):
    """Of any size, of less rank, rounding beside sizes, and none where J_eq is none."""
    J_eq = rng.standard_normal((count, 6, motors)) * 10.0 ** rng.uniform(-12, 3, (count, 1, 1))
    J_eq[::3, 1:3] = J_eq[::3, :1]
    J_eq[::5, 3:] *= 1e-14
    J_eq[7::11] = np.nan
    sizes = 10.0 ** rng.uniform(-2.0, 2.0, (2, count))
    found = np.full((2, count, 3), 7.0)
    fill_radii(J_eq, sizes, *found)
    for block, size, radii in zip((J_eq[:, :3], J_eq[:, 3:]), sizes, found, strict=True):
        np.testing.assert_array_equal(radii, _radii_of_blocks(block.transpose(1, 2, 0), size).T)
    expected = [np.linalg.svd(block, compute_uv=False) for block in J_eq[0].reshape(2, 3, motors)]
    for radii, values, size in zip(found[:, 0], expected, sizes[:, 0], strict=True):
        least = max(1e-9 * values.max(initial=0.0), 1e-12 * size)
        wanted = np.where(values > least, values, 0.0)
        np.testing.assert_allclose(radii[: len(values)], wanted, rtol=1e-6)
        assert not radii[len(values) :].any()
