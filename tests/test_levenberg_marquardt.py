"""One Levenberg–Marquardt: steps of least squares, from one start as from many."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import CLOSED, loaded

from pmjac_pin.closing.damped_closure import assemble, motor_weights
from pmjac_pin.closing.levenberg_marquardt import by_normal_equations, by_singular_values
from pmjac_pin.studies.modes.search import ManyClosures
from pmjac_pin.studies.modes.search_problem import search_problem
from pmjac_pin.studies.modes.starts import StartSpace


def least_squares(rows, error, damping):
    """Return x of the smallest ‖J x − e‖² + λ ‖x‖², as one ordinary least-squares problem."""
    found = []
    for J, e, squared in zip(rows, error, damping, strict=True):
        below = np.sqrt(squared) * np.eye(J.shape[1])
        right = np.concatenate([e, np.zeros(len(below))])
        found.append(np.linalg.lstsq(np.vstack([J, below]), right, rcond=None)[0])
    return np.array(found)


@pytest.mark.parametrize("shape", [(5, 3, 3), (4, 6, 2), (3, 2, 5), (1, 1, 1)])
@pytest.mark.parametrize("damping", [1e-2, 1.0, 1e3])
def test_both_solutions_are_those_of_damped_least_squares(shape, damping, rng):
    rows = rng.normal(size=shape)
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    error, held = rng.normal(size=shape[:2]), np.full(shape[0], damping)
    expected = least_squares(rows, error, held)
    assert by_normal_equations(rows, error, held) == pytest.approx(expected, abs=1e-8)
    largest = np.linalg.svd(rows, compute_uv=False)[:, 0]
    assert by_singular_values(rows, error, held / largest**2) == pytest.approx(expected, abs=1e-8)


def test_singular_values_are_solved_where_their_squares_are_rounded_off(rng):
    left, right = (np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(2))
    rows = left @ np.diag([1.0, 1e-3, 1e-6]) @ right.T
    wanted = rng.normal(size=3)
    found = by_singular_values(rows[None], (rows @ wanted)[None], np.zeros(1))
    assert found[0] == pytest.approx(wanted, rel=1e-5)


def test_what_cannot_move_stays():
    nothing = np.zeros((2, 3, 2))
    assert not by_singular_values(nothing, np.ones((2, 3)), np.ones(2)).any()
    assert not by_normal_equations(nothing, np.ones((2, 3)), np.ones(2)).any()


#: Their loops determine all passive joints, and a search leaves out no legs.
DETERMINED = set(CLOSED) - {"ankle", "stewart_gough", "stewart_gough_dietmaier"}


@pytest.mark.parametrize("name", sorted(DETERMINED))
def test_one_start_closes_where_it_closes_among_many(name, rng):
    """By singular values, and by normal equations: near home is one mode."""
    mechanism = loaded(name)
    problem = search_problem(mechanism, mechanism.home.q)
    weights = motor_weights(mechanism.problem, 0.0)
    away = 1e-3 * problem.length * weights * problem.partition.column_scale
    homes = np.tile(mechanism.home.q, (4, 1))
    starts = problem.tree.moved(homes, away * rng.normal(size=(4, away.size)))
    strides = StartSpace.of(problem, limits=False).strides(problem)
    closed = ManyClosures(problem, strides).closed(starts)
    assert len(closed) == len(starts)
    for start, among_many in zip(starts, closed, strict=True):
        alone = assemble(mechanism.problem, start, weights)
        apart = mechanism.problem.difference(alone.q, among_many) / problem.partition.column_scale
        assert np.abs(apart).max() <= 1e-9 * problem.length
