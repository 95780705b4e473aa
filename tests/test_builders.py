"""Machines made of points and lengths: against the catalogue's and against textbook formulas."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj


def platform_points(rng, scale):
    """Six points on the base and six on the platform, none of them in a special place."""
    turn = np.sort(rng.uniform(0.0, 2.0 * np.pi, 6)) + 0.2 * np.arange(6)
    ring = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    base = ring + 0.2 * rng.normal(size=(6, 3))
    held = 0.6 * np.roll(ring, 1, axis=0) + 0.1 * rng.normal(size=(6, 3))
    pose = pin.SE3(pin.exp3(0.3 * rng.normal(size=3)), np.array([0.1, -0.2, 1.3]))
    pose.translation *= scale
    return scale * base, scale * held, pose


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("seed", range(4))
def test_inverse_jacobian_of_a_stewart_platform_are_its_leg_lines(seed, scale):
    base, held, pose = platform_points(np.random.default_rng(seed), scale)
    machine = pj.stewart(base, held, pose)
    home = machine.home
    arms = held @ pose.rotation.T
    legs = arms + pose.translation - base
    np.testing.assert_allclose(home.actuated, np.linalg.norm(legs, axis=1), rtol=1e-12)
    np.testing.assert_allclose(home.tool_pose().homogeneous, pose.homogeneous, atol=1e-12 * scale)
    n = legs / np.linalg.norm(legs, axis=1)[:, None]
    lines = np.hstack([n, np.cross(arms, n)])
    np.testing.assert_allclose(lines @ home.jacobian().J_eq, np.eye(6), atol=1e-9)


def test_the_catalogues_platform_made_of_its_points():
    known = loaded("stewart_gough")
    model, data = known.model, known.model.createData()
    pin.framesForwardKinematics(model, data, known.home.q)
    world = [data.oMf[model.getFrameId(f"P{k}")].translation for k in range(1, 7)]
    feet = [data.oMi[model.getJointId(f"alpha{k}")].translation for k in range(1, 7)]
    pose = known.home.tool_pose()
    held = (np.array(world) - pose.translation) @ pose.rotation
    made = pj.stewart(np.array(feet), held, pose)
    expected = known.home.jacobian().J_eq
    np.testing.assert_allclose(made.home.jacobian().J_eq, expected, atol=1e-9)
    moved = known.home.actuated + np.array([0.02, -0.01, 0.0, 0.03, 0.01, -0.02])
    np.testing.assert_allclose(
        made.close(moved).tool_pose().homogeneous,
        known.close(moved).tool_pose().homogeneous,
        atol=1e-10,
    )


def test_legs_that_hang_down_are_regular():
    base, held, _ = platform_points(np.random.default_rng(0), 1.0)
    hanging = pj.stewart(base, held, -1.3)
    assert hanging.home.singularity().kind == "regular"


def test_the_catalogues_delta_made_of_its_lengths():
    known = loaded("delta_rods")
    lengths = {name: known.parameters[name] for name in ("base", "arm", "rod", "plate")}
    made = pj.delta(**lengths, tool=0.065)
    for values in ([0.3, 0.3, 0.3], [0.1, 0.5, 0.4]):
        one, other = made.close(values), known.close(values)
        np.testing.assert_allclose(
            one.tool_pose().homogeneous, other.tool_pose().homogeneous, atol=1e-10
        )
        np.testing.assert_allclose(one.jacobian().J_eq, other.jacobian().J_eq, atol=1e-9)


@pytest.mark.parametrize("directions", [(0.0, 120.0, 240.0), (10.0, 100.0, 250.0)])
def test_jacobian_of_a_delta_is_that_of_its_rods(directions):
    """s · v = s · (ω × a) θ̇, with s along a rod and a the arm."""
    base, arm, rod, plate, angle = 0.25, 0.3, 0.75, 0.08, 0.4
    made = pj.delta(base, arm, rod, plate, directions=directions, home=angle)
    configuration = made.close([0.5, 0.2, 0.4])
    place = configuration.tool_pose().translation
    by_v, by_motors = np.zeros((3, 3)), np.zeros((3, 3))
    for k, (turn, theta) in enumerate(
        zip(np.deg2rad(directions), configuration.actuated, strict=True)
    ):
        out, up = np.array([np.cos(turn), np.sin(turn), 0.0]), np.array([0.0, 0.0, 1.0])
        arm_way = np.cos(theta) * out - np.sin(theta) * up
        down = -np.sin(theta) * out - np.cos(theta) * up
        s = place + plate * out - (base * out + arm * arm_way)
        assert abs(np.linalg.norm(s) - rod) < 1e-12
        by_v[k], by_motors[k, k] = s, arm * s @ down
    expected = np.linalg.solve(by_v, by_motors)
    np.testing.assert_allclose(configuration.jacobian().Jv_eq, expected, atol=1e-12)
    np.testing.assert_allclose(configuration.jacobian().Jw_eq, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: pj.stewart(np.eye(3), np.eye(3), 1.0), r"base_points of shape \(6, 3\) expected"),
        (lambda: pj.stewart(np.zeros((6, 3)), np.zeros((6, 3)), 0.0), "leg 1 has no length"),
        (lambda: pj.stewart(np.eye(6)[:, :3], np.ones((6, 3)), "high"), "the platform's height"),
        (
            lambda: pj.stewart(np.zeros((6, 3)), np.zeros((6, 3)), 2.0, stroke=(0.5, 1.0)),
            "leg 1 is 2 m long at home, beyond its stroke of 0.5 to 1 m",
        ),
        (
            lambda: pj.stewart(np.zeros((6, 3)), np.zeros((6, 3)), 2.0, stroke=(-1, 1)),
            "stroke: 2 lengths",
        ),
        (
            lambda: pj.stewart(
                np.zeros((6, 3)), np.eye(6, 3), pin.SE3(np.diag([1.0, 1.0, -1.0]), np.ones(3))
            ),
            "the platform's pose is a reflection",
        ),
        (lambda: pj.delta(0.2, 0.3, 0.2, 0.06), "do not reach the plate at home"),
        (lambda: pj.delta(-0.2, 0.3, 0.7, 0.06), "base must be"),
        (lambda: pj.delta(0.2, 0.3, [0.7, 0.7], 0.06), "rod"),
        (lambda: pj.delta(0.2, 0.3, 0.7, 0.06, directions=(0, 0, 120)), "point the same way"),
        (lambda: pj.delta(0.2, 0.3, 0.7, 0.06, directions=(0, 120)), "3 angles in degrees"),
        (lambda: pj.delta(0.2, 0.3, 0.7, 0.06, home=float("nan")), "home"),
    ],
)
def test_what_is_no_machine_is_refused(make, said):
    with pytest.raises(pj.ArgumentError, match=said):
        make()


def test_arms_and_rods_of_unlike_lengths_close():
    made = pj.delta(0.2, [0.3, 0.31, 0.29], [0.7, 0.69, 0.7], 0.06)
    assert made.home.residual_norm < 1e-12
    assert made.home.singularity().kind == "regular"
