"""All complex solutions, by monodromy and a trace test, against counts that are known."""

from __future__ import annotations

import mechanisms
import numpy as np
import pytest
from test_modes import LECTURE_A, same_sets

import pmjac_pin as pj
from pmjac_pin.modes.polynomial_loops import PolynomialLoops
from pmjac_pin.modes.search_problem import search_problem


@pytest.mark.parametrize("name", [*mechanisms.CLOSED])
def test_real_poses_are_solutions_and_derivatives_are_exact(name, rng):
    mechanism = pj.load(name)
    home = mechanism.home
    problem, _ = search_problem(mechanism._parts, home.q)
    try:
        loops = PolynomialLoops(problem, problem.base[None], rng)
    except pj.ArgumentError as error:
        assert "no homotopy for this mechanism" in str(error)
        return
    x = loops.unknowns(problem.base[None])
    residual, _ = loops.evaluate(x, np.zeros(1, dtype=complex))
    assert np.abs(residual).max() <= 1e-12
    np.testing.assert_allclose(loops.poses(x.real), problem.base[None], atol=1e-12)
    point = rng.normal(size=(1, loops.count + 1)) + 1j * rng.normal(size=(1, loops.count + 1))
    _, jacobian = loops.evaluate(point[:, :-1], point[:, -1])
    h = 1e-6
    for column in range(loops.count + 1):
        step = h * np.eye(loops.count + 1)[column]
        ahead, behind = (
            loops.evaluate((point + sign * step)[:, :-1], (point + sign * step)[:, -1])[0]
            for sign in (1, -1)
        )
        difference = (ahead - behind) / (2 * h)
        scale = 1e-7 * np.abs(jacobian).max()
        np.testing.assert_allclose(jacobian[:, :, column], difference, atol=scale)


@pytest.mark.parametrize(("name", "count"), [("four_bar", 2), ("slider_crank", 2), ("five_bar", 2)])
def test_planar_mechanisms(name, count):
    mechanism = pj.load(name)
    found = pj.complex_modes(mechanism, mechanism.home.actuated, rng=0)
    assert (found.count, found.complete) == (count, True)
    modes = mechanism.assembly_modes(mechanism.home.actuated, rng=0)
    same_sets(found.q, [mode.q for mode in modes], 1e-8)


def test_out_of_reach_all_are_complex():
    found = pj.complex_modes(mechanisms.rocker_rocker(), [2.5], rng=0)
    assert (found.count, len(found.q), found.complete) == (2, 0, True)


@pytest.mark.slow
@pytest.mark.parametrize(("lengths", "real"), [([2 / 3, 3 / 5, 3 / 4], 8), ([0.5, 1.0, 2.0], 4)])
def test_sixteen_of_the_3_rps(lengths, real):
    """Its eliminant has degree 16: eight or four of the solutions are real at these lengths."""
    mechanism = pj.load("three_rps_ss")
    found = pj.complex_modes(mechanism, lengths, rng=0)
    assert (found.count, len(found.q), found.complete) == (16, real, True)
    if real == 8:
        same_sets(found.q[:, [0, 2, 4]], np.vstack([LECTURE_A, -LECTURE_A]), 1e-7)


def test_what_has_no_isolated_solutions_is_refused():
    with pytest.raises(pj.ArgumentError, match="passive motions that idle"):
        pj.complex_modes(mechanisms.rssr(), [0.4], rng=0)
