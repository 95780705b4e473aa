"""What a tool can do within the limits of each motor."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.optimize import linprog

import pmjac_pin as pj

CASES = {
    "five_bar": ["vx", "vy"],
    "serial_2r": ["vx", "vy"],
    "three_rps": ["wx", "wy"],
    "delta": ["vx", "vy", "vz"],
    "stewart_gough": ["vx", "vy", "vz"],
    "ur5": ["wx", "wy", "wz"],
    "slider_crank": ["vx"],
}
ROWS = ("vx", "vy", "vz", "wx", "wy", "wz")


def block_at(name, rng):
    mechanism = pj.load(name)
    scale = mechanism.problem.partition.column_scale[mechanism.problem.partition.actuated]
    step = 0.05 * mechanism.characteristic_length * scale * rng.uniform(-1, 1, scale.size)
    jacobian = mechanism.close(mechanism.home.actuated + step, enforce_limits=False).jacobian()
    return jacobian, jacobian.J_eq[[ROWS.index(row) for row in CASES[name]]]


@pytest.mark.parametrize("name", CASES)
def test_velocities_are_those_that_rates_within_limits_make(name, rng):
    jacobian, block = block_at(name, rng)
    limits = rng.uniform(0.2, 3.0, block.shape[1])
    reach = jacobian.velocity_polytope(limits, CASES[name])
    for rates in limits * rng.uniform(-1, 1, (50, limits.size)):
        assert reach.contains(block @ rates * (1 - 1e-9))
    size = np.abs(reach.vertices).max()
    for corner in reach.vertices:
        box = [(-limit, limit) for limit in limits]
        found = linprog(np.zeros(limits.size), A_eq=block, b_eq=corner * (1 - 1e-9), bounds=box)
        assert found.status == 0
        assert not reach.contains(corner * (1 + 1e-6))
    # The farthest in any direction, by the motors' signs: Σ |uᵀ bᵢ| limitᵢ.
    for way in rng.normal(size=(20, len(block))):
        farthest = np.abs(way @ block) @ limits
        assert (reach.vertices @ way).max() == pytest.approx(farthest, abs=1e-9 * size)


@pytest.mark.parametrize("name", CASES)
def test_forces_are_those_that_efforts_within_limits_hold(name, rng):
    jacobian, block = block_at(name, rng)
    limits = rng.uniform(0.2, 3.0, block.shape[1])
    held = jacobian.force_polytope(limits, CASES[name])
    for corner in held.vertices:
        efforts = np.abs(block.T @ corner) / limits
        assert efforts.max() == pytest.approx(1.0, abs=1e-9)
        assert (efforts > 1.0 - 1e-9).sum() >= len(block)  # a corner: as many motors at limits
    for way in rng.normal(size=(20, len(block))):
        most = 1.0 / (np.abs(block.T @ way) / limits).max()
        assert held.along(way) == pytest.approx(most * np.linalg.norm(way), rel=1e-9)
        assert held.contains(way * most * (1 - 1e-9))
        assert not held.contains(way * most * (1 + 1e-6))


def test_two_that_push_together(rng):
    jacobian, block = block_at("five_bar", rng)
    one, other = (jacobian.velocity_polytope(limits, ["vx", "vy"]) for limits in ([1, 2], [3, 1]))
    both = one + other
    for way in rng.normal(size=(20, 2)):
        farthest = np.abs(way @ block) @ [4, 3]
        assert (both.vertices @ way).max() == pytest.approx(farthest)
    with pytest.raises(pj.ArgumentError, match="in m/s and in N have no sum"):
        one + jacobian.force_polytope([1, 1], ["vx", "vy"])


def test_a_direction_that_leads_nowhere():
    held = pj.load("five_bar").home.jacobian().force_polytope([1.0, 1.0], ["vx", "vy"])
    with pytest.raises(pj.ArgumentError, match="a direction is not zero"):
        held.along([0.0, 0.0])
    away = dataclasses.replace(held, offsets=held.offsets + held.normals @ [100.0, 0.0])
    with pytest.raises(pj.ArgumentError, match="the origin, which is not in the polytope"):
        away.along([1.0, 0.0])


@pytest.mark.parametrize(
    ("limits", "rows", "message"),
    [
        ([1.0, 1.0], ["vx", "vy", "vz"], "some direction is not reached.*choose `rows`"),
        ([1.0], ["vx", "vy"], r"motor limits: 2 numbers expected, got shape \(1,\)"),
        ([1.0, 0.0], ["vx", "vy"], "motor limits are numbers above 0"),
        ([1.0, np.inf], ["vx", "vy"], "finite"),
        ([1.0, 1.0], ["vx", "wz"], "of linear or of angular rows, not of both"),
    ],
)
def test_what_is_no_polytope(limits, rows, message):
    jacobian = pj.load("five_bar").home.jacobian()
    with pytest.raises(pj.ArgumentError, match=message):
        jacobian.velocity_polytope(limits, rows)
    if "reached" not in message:
        with pytest.raises(pj.ArgumentError, match=message):
            jacobian.force_polytope(limits, rows)
    else:
        with pytest.raises(pj.ArgumentError, match="held at no effort"):
            jacobian.force_polytope(limits, rows)
