"""What rounding must not decide: signs, and which of equal entries is meant."""

from __future__ import annotations

import mechanisms
import numpy as np
import pytest
import scipy.linalg
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.model.linkage import turned_to
from pmjac_pin.model.rows import across
from pmjac_pin.rates.actuation import analyse_actuation
from pmjac_pin.rates.ellipsoid import velocity_ellipsoid
from pmjac_pin.rates.partition import independent_rows
from pmjac_pin.rates.singularity import analyse_singularity
from pmjac_pin.values.ties import first_largest, first_smallest, pivots
from pmjac_pin.viewer.framing import _direction

NOISE = 1e-14


def noisy(matrix, rng, count=20):
    """The same but for rounding, and with its rows mixed: another decomposition each time."""
    for _ in range(count):
        mixing = np.linalg.qr(rng.normal(size=(matrix.shape[0],) * 2))[0]
        yield mixing @ (matrix + NOISE * rng.normal(size=matrix.shape))


@pytest.mark.parametrize("entries", [(1, -1), (-2, 1, 2), (0, 0, 0), (-1, -1, -1, 1)])
def test_the_first_of_equal_ones_is_meant(entries, rng):
    for _ in range(20):
        values = np.array(entries) + NOISE * rng.normal(size=len(entries))
        assert first_largest(values) == np.argmax(np.abs(entries)) or not any(entries)
        assert first_smallest(values) == np.argmin(np.abs(entries)) or not any(entries)


def test_forbidden_rates_and_free_motions_keep_their_signs(rng):
    """Two motors that must turn against each other; two joints that come free together."""
    tool = np.ones((6, 4))
    both = np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 1.0, -1.0]])
    regular = pj.Partition.from_matrices(both, tool, [0, 1], [2, 3])
    drops = np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0]])
    for matrix in noisy(drops, rng):
        found = analyse_singularity(matrix, tool, regular)
        half = np.sqrt(0.5)
        np.testing.assert_allclose(found.forbidden_rates, [[half], [half]], atol=1e-9)
        assert list(found.free_motion().values()) == pytest.approx([1.0, -1.0])
        free = analyse_actuation(matrix, tool, regular).free
        np.testing.assert_allclose(free, [[1.0], [-1.0]], atol=1e-9)


def test_the_idle_motion_that_an_error_tells_keeps_its_sign(rng):
    matrix = np.array([[1.0, 1.0, 1.0], [0.0, 1.0, 1.0]])
    matrix[1] = 0.0
    tool = np.arange(18.0).reshape(6, 3)
    for noise in noisy(matrix[:1], rng):
        partition = pj.Partition.from_matrices(noise, tool, [0], [1, 2])
        with pytest.raises(pj.IdleMotionError) as caught:
            pj.equivalent_jacobian(pj.SplitJacobian(noise, tool, "LOCAL", partition))
        assert list(caught.value.idle_motion.values()) == pytest.approx([1.0, -1.0])


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (0, -1, 0), (1, 1, 0), (1, 1, 1)])
def test_bases_across_an_axis_do_not_depend_on_rounding(axis, rng):
    unit = np.array(axis) / np.linalg.norm(axis)
    ellipsoid = velocity_ellipsoid(np.diag([3.0, 2.0, 1.0]))
    bases = [across(unit), turned_to(unit).rotation, ellipsoid.section(unit).basis]
    for _ in range(10):
        other = unit + 1e-15 * rng.normal(size=3)
        others = [across(other), turned_to(other).rotation, ellipsoid.section(other).basis]
        for base, again in zip(bases, others, strict=True):
            np.testing.assert_allclose(again, base, atol=1e-13)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_what_is_free_is_told_alike_after_rounding(name, rng):
    """At home, or where the catalogue's own singular poses are."""
    mechanism = loaded(name)
    partition = mechanism.problem.partition
    for pose in mechanism.poses:
        split = mechanism.pose(pose).split_jacobian()
        C, J = split.constraint_jacobian, split.tool_jacobian
        found = analyse_singularity(C, J, partition)
        if found.free_motions.shape[1] != 1 and found.forbidden_rates.shape[1] != 1:
            continue
        for _ in range(5):
            shaken = C + NOISE * rng.normal(size=C.shape)
            again = analyse_singularity(shaken, J, partition)
            if found.free_motions.shape[1] == 1:
                expected = pytest.approx(found.free_motion(), abs=1e-6)
                assert again.free_motion() == expected
            if found.forbidden_rates.shape[1] == 1:
                np.testing.assert_allclose(again.forbidden_rates, found.forbidden_rates, atol=1e-6)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_rows_and_motors_that_are_chosen_stay_after_rounding(name, rng):
    mechanism = loaded(name)
    partition = mechanism.problem.partition
    for pose in mechanism.poses:
        split = mechanism.pose(pose).split_jacobian()
        C, J = split.constraint_jacobian, split.tool_jacobian
        rank = partition.factorise(partition.scaled(C), np.linalg.norm(partition.scaled(C))).rank
        rows = independent_rows(partition.scaled(C), rank)
        chosen = analyse_actuation(C, J, partition)
        for _ in range(10):
            shaken = C + 1e-15 * np.abs(C).max(initial=0.0) * rng.normal(size=C.shape)
            assert independent_rows(partition.scaled(shaken), rank).tolist() == rows.tolist()
            again = analyse_actuation(shaken, J, partition)
            assert again.sufficient.tolist() == chosen.sufficient.tolist()
            np.testing.assert_allclose(again.free, chosen.free, atol=1e-6)


@pytest.mark.parametrize("shape", [(3, 5), (6, 6), (4, 9), (40, 60)])
def test_pivots_are_as_independent_as_those_of_qr(shape, rng):
    columns = rng.normal(size=shape) * 10.0 ** rng.uniform(-3, 0, shape[1])
    ours = pivots(columns, shape[0])
    theirs = scipy.linalg.qr(columns, mode="r", pivoting=True)[1][: shape[0]]
    assert len(set(ours.tolist())) == shape[0]
    least = [np.linalg.svd(columns[:, some], compute_uv=False)[-1] for some in (ours, theirs)]
    assert least[0] > 0.1 * least[1]


@pytest.mark.parametrize("axis", range(3))
def test_a_bar_is_looked_at_from_one_side(axis, rng):
    """It is thin in two directions alike."""
    bar = np.outer(np.linspace(-1.0, 1.0, 5), np.eye(3)[axis])
    sides = [_direction(bar + 1e-16 * rng.normal(size=bar.shape)) for _ in range(20)]
    np.testing.assert_array_equal(sides, [sides[0]] * 20)
