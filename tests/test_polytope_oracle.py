"""Polytopes of a serial arm against pycapacity's."""

from __future__ import annotations

import importlib.util
import warnings

import numpy as np
import pytest
from scipy.spatial import cKDTree

import pmjac_pin as pj

pytestmark = [
    pytest.mark.slow,  # the peers are installed with the slow tests only
    pytest.mark.skipif(
        importlib.util.find_spec("pycapacity") is None, reason="a peer, of the extra `peers`"
    ),
]


@pytest.fixture(scope="module")
def robot():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it imports what NumPy calls deprecated
        from pycapacity import robot
    return robot


def assert_same_corners(ours, theirs):
    """Every corner of each is one of the other; theirs may come several times."""
    size = np.abs(ours).max()
    for one, other in ((ours, theirs), (theirs, ours)):
        apart, _ = cKDTree(other).query(one)
        np.testing.assert_allclose(apart, 0, atol=1e-8 * size)


@pytest.mark.parametrize("pose", range(4))
def test_reach_and_forces_of_an_arm_are_pycapacitys(pose, robot, rng):
    arm = pj.load("ur5")
    jacobian = arm.close(rng.uniform(-1.5, 1.5, 6) + 0.1 * pose).jacobian()
    rates, efforts = rng.uniform(0.5, 3.0, 6), rng.uniform(10.0, 100.0, 6)
    for rows, block in ((["vx", "vy", "vz"], jacobian.Jv_eq), (["wx", "wy", "wz"], jacobian.Jw_eq)):
        theirs = robot.velocity_polytope(block, dq_min=-rates, dq_max=rates)
        ours = jacobian.velocity_polytope(rates, rows)
        assert_same_corners(ours.vertices, theirs.vertices.T)
        theirs = robot.force_polytope(block, t_min=-efforts, t_max=efforts)
        ours = jacobian.force_polytope(efforts, rows)
        assert_same_corners(ours.vertices, theirs.vertices.T)
