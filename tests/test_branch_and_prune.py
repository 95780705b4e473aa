"""Branch and prune: whatever it drops, it drops no closed pose."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.studies.modes.box_problem import box_problem, given_values
from pmjac_pin.studies.modes.branch_and_prune import Budget, branch_and_prune

LENGTHS = np.array([2 / 3, 3 / 5, 3 / 4])


@pytest.fixture(scope="module")
def problem():
    mechanism = loaded("three_rps_ss")
    return box_problem(mechanism, given_values(mechanism, LENGTHS), False)


@pytest.fixture(scope="module")
def modes(problem):
    found = pj.assembly_modes(loaded("three_rps_ss"), LENGTHS, rng=0, limits=False)
    return np.array([[mode.joint_values[name] for name in problem.names] for mode in found])


def pruned(problem, start, budget):
    return branch_and_prune(problem.loops, start, problem.scale, budget)


@pytest.mark.parametrize("boxes", [1, 10, 50, 100, 200, 400, 10_000])
def test_no_mode_is_lost_however_early_it_ends(problem, modes, boxes):
    left = pruned(problem, problem.domain[None], Budget(boxes=boxes))
    both = Intervals.join([left.small, left.unfinished])
    for mode in modes:
        assert both.widened(1e-12).holds(mode).all(axis=1).any()
    assert (len(left.unfinished.lower) == 0) == (boxes == 10_000)


@pytest.mark.slow
def test_modes_at_faces_edges_and_corners_of_boxes_are_kept(problem, modes, rng):
    """Boxes that begin or end at a mode's own values, in one, two or three angles."""
    for mode in modes:
        for sides in np.ndindex(3, 3, 3):
            size = rng.uniform(0.1, 1.0, 3)
            lower = mode - size * (np.array(sides) != 0)
            upper = mode + size * (np.array(sides) != 1)
            left = pruned(problem, Intervals(lower[None], upper[None]), Budget())
            assert left.small.widened(1e-10).holds(mode).all(axis=1).any()


def test_what_is_left_is_small_and_near_modes_only(problem, modes):
    left = pruned(problem, problem.domain[None], Budget())
    assert left.small.width.max() <= 1e-7
    for box in left.small.middle:
        assert np.abs(modes - box).max(axis=1).min() < 1e-6


def test_boxes_without_modes_leave_nothing(problem, modes):
    lower = modes[0] + 0.01
    left = pruned(problem, Intervals(lower[None], lower[None] + 0.02), Budget())
    assert (len(left.small.lower), len(left.unfinished.lower)) == (0, 0)
