"""Reach: motor values that put a tool at a target, and every other answer by its name."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import CATALOGUE, loaded, random_closed

import pmjac_pin as pj

TURN = pin.SE3(pin.exp3(np.array([0.4, -1.1, 0.7])), np.array([0.2, -0.1, 0.4]))
FAR = pin.SE3(np.eye(3), np.array([5.1e6, -4.3e6, 120.0]))


def nearby(name, rng, spread=0.1):
    """Two closed poses of a machine, the motors at most `spread` apart."""
    mechanism = loaded(name)
    while True:
        [start] = random_closed(mechanism, rng, 1, 0.2)
        step = spread * rng.uniform(-1.0, 1.0, len(mechanism.actuated))
        try:
            return start, mechanism.close(start.actuated + step, guess=start)
        except (pj.ClosureError, pj.LimitError):
            continue


@pytest.mark.parametrize("guess", ["near", "home"])
@pytest.mark.parametrize("name", CATALOGUE)
def test_reach_takes_back_what_close_does(name, guess, rng):
    start, wanted = nearby(name, rng)
    mechanism = wanted.mechanism
    guessed = start if guess == "near" else "home"
    found = pj.reach(mechanism, wanted.tool_pose(), guess=guessed)
    assert found.status == "reached"
    assert max(found.error) < 1e-9
    np.testing.assert_allclose(found.actuated, wanted.actuated, rtol=0.0, atol=1e-9)
    assert found.configuration.mechanism is mechanism


@pytest.mark.parametrize("name", CATALOGUE)
def test_a_position_is_met_whatever_freedom_it_leaves(name, rng):
    start, wanted = nearby(name, rng, 0.03)
    found = pj.reach(wanted.mechanism, wanted.tool_pose().translation, guess=start)
    assert found.status == "reached"
    there = found.configuration.tool_pose().translation
    length = wanted.mechanism.characteristic_length
    np.testing.assert_allclose(there, wanted.tool_pose().translation, atol=1e-9 * length)
