"""The transmission of parallel joints: an ankle by closed formulas, laws over other machines."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest

import pmjac_pin as pj

RADIUS = 0.025
CRANKS = np.array([[-0.041, 0.0, 0.195], [-0.041, 0.0, 0.14]])
FEET = np.array([[-0.041, -0.025, 0.009], [-0.041, 0.025, 0.009]])
RODS, OFFSETS = np.array([0.195, 0.14]), np.array([1.2028, -1.2030])


def ankle():
    """A humanoid's ankle: pitch, then roll; two cranks about x pull its foot by rods."""
    return mechanisms.loaded("humanoid_ankle")


def motors_by_hand(pitch, roll):
    """Each rod alone: A cos a + B sin a = C, on the branch near q = 0."""
    turned = FEET @ (pin.utils.rotate("y", pitch) @ pin.utils.rotate("x", roll)).T
    q = []
    for foot, crank, rod, offset in zip(turned, CRANKS, RODS, OFFSETS, strict=True):
        x, y, z = foot - crank
        a, b = -2 * RADIUS * z, 2 * RADIUS * y
        c = rod**2 - RADIUS**2 - x**2 - y**2 - z**2
        middle, spread = np.arctan2(b, a), np.arccos(c / np.hypot(a, b))
        near = [np.angle(np.exp(1j * (middle + s * spread - offset))) for s in (1, -1)]
        q.append(min(near, key=abs))
    return np.array(q)


#: Pitch and roll, and the motors' angles there, as published.
MOTORS = {
    (0.0, 0.0): (3.628e-5, 4.334e-5),
    (0.1, 0.05): (-0.12185667, 0.23719927),
    (-0.3, 0.1): (0.60835779, -0.41537587),
}
RATIOS = {
    (0.0, 0.0): [[-1.751856, 1.071505], [1.749516, 1.071366]],
    (0.1, 0.05): [[-1.795086, 1.14147], [1.89118, 1.17648]],
}


@pytest.mark.parametrize("joints", MOTORS)
def test_an_ankles_motors(joints):
    geared = pj.transmission(ankle(), ["pitch", "roll"]).at_joints(joints)
    np.testing.assert_allclose(geared.motors, MOTORS[joints], atol=1e-8)
    np.testing.assert_allclose(geared.motors, motors_by_hand(*joints), atol=1e-13)


def test_an_ankles_motors_wherever_its_foot_is(rng):
    mechanism = ankle()
    transmission = pj.transmission(mechanism, ["pitch", "roll"])
    for joints in rng.uniform([-0.5, -0.15], [0.25, 0.15], (20, 2)):
        by_hand = motors_by_hand(*joints)
        np.testing.assert_allclose(
            transmission.at_joints(joints).motors, by_hand, rtol=0, atol=1e-12
        )
        there = transmission.at_motors(by_hand).joints
        np.testing.assert_allclose(there, joints, rtol=0, atol=1e-12)


@pytest.mark.parametrize("joints", RATIOS)
def test_an_ankles_ratios(joints):
    geared = pj.transmission(ankle(), ["pitch", "roll"]).at_joints(joints)
    np.testing.assert_allclose(geared.ratio, RATIOS[joints], atol=1e-5)
    h = 1e-5
    found = [
        (motors_by_hand(*(joints + step)) - motors_by_hand(*(joints - step))) / (2 * h)
        for step in h * np.eye(2)
    ]
    np.testing.assert_allclose(geared.ratio, np.transpose(found), atol=1e-9)


def test_an_ankles_effort_limits_are_a_rhombus():
    """Motors of 1 N m: (±3.5014, 0) and (0, ±2.1429) N m; no box of pitch and roll."""
    geared = pj.transmission(ankle(), ["pitch", "roll"]).at_joints([0.0, 0.0])
    corners = geared.effort_limits([1.0, 1.0]).vertices
    assert len(corners) == 4
    for wanted in ((3.5014, 0.0), (-3.5014, 0.0), (0.0, 2.1429), (0.0, -2.1429)):
        assert np.linalg.norm(corners - wanted, axis=1).min() < 3e-3
    turned = np.arctan2(corners[:, 1], corners[:, 0])
    assert (np.diff(np.unwrap(turned)) > 0.0).all()
    faster = geared.rate_limits([2.0, 2.0]).vertices
    np.testing.assert_allclose(np.abs(geared.ratio @ faster.T), 2.0, atol=1e-12)


MACHINES = {
    "humanoid_ankle": (ankle, ["pitch", "roll"]),
    "ankle": (lambda: pj.load("ankle"), None),
    "four_bar": (lambda: pj.load("four_bar"), ["phi1"]),
    "five_bar": (lambda: pj.load("five_bar"), ["phi1", "phi2"]),
    "slider_crank": (lambda: pj.load("slider_crank"), None),
    "watt_six_bar": (lambda: pj.load("watt_six_bar"), None),
}


def geared_at(name, rng):
    make, joints = MACHINES[name]
    mechanism = make()
    if joints is None:
        joints = mechanism.passive[: len(mechanism.actuated)]
    size = 0.05 * np.where([mechanism.units[m] == "m" for m in mechanism.actuated], 0.1, 1.0)
    away = 0.5 if name == "four_bar" else 0.0  # at home, its rocker all but turns back
    values = mechanism.home.actuated + away + size * rng.uniform(-1, 1, len(mechanism.actuated))
    return pj.transmission(mechanism, joints).at_motors(values)


@pytest.mark.parametrize("name", MACHINES)
def test_both_ways_undo_each_other(name, rng):
    geared = geared_at(name, rng)
    n = len(geared.joints)
    rates, efforts = rng.normal(size=(2, n))
    np.testing.assert_allclose(geared.joint_rates(geared.motor_rates(rates)), rates, atol=1e-9)
    np.testing.assert_allclose(
        geared.motor_efforts(geared.joint_efforts(efforts)), efforts, atol=1e-9
    )
    power = geared.motor_rates(rates) @ efforts
    assert power == pytest.approx(rates @ geared.joint_efforts(efforts), abs=1e-10)
    back = geared.transmission.at_joints(geared.joints, geared.configuration.joint_values)
    np.testing.assert_allclose(back.motors, geared.motors, atol=1e-10)


@pytest.mark.parametrize("name", MACHINES)
def test_gains_under_load_are_how_efforts_change(name, rng):
    """−∂τ_x/∂x of motors that pull back with K δθ on top of what they exert."""
    geared = geared_at(name, rng)
    n = len(geared.joints)
    stiffness, exerted = rng.uniform(1, 50, n), rng.normal(size=n) * 10
    found = np.zeros((n, n))
    h = 1e-4

    def efforts(step):
        there = geared.transmission.by_joints.close(
            geared.joints + step, guess=geared.configuration, enforce_limits=False
        )
        there = geared.transmission.at(there)
        return there.joint_efforts(exerted - stiffness * (there.motors - geared.motors))

    for k, step in enumerate(h * np.eye(n)):
        near, far = efforts(step) - efforts(-step), efforts(2 * step) - efforts(-2 * step)
        found[:, k] = -(8 * near - far) / (12 * h)
    np.testing.assert_allclose(
        geared.stiffness(stiffness, exerted), found, atol=1e-6 * max(1.0, np.abs(found).max())
    )


def test_gains_and_armatures_are_matrices():
    geared = pj.transmission(ankle(), ["pitch", "roll"]).at_joints([0.1, 0.05])
    R = geared.ratio
    np.testing.assert_allclose(geared.armature([0.2, 0.3]), R.T @ np.diag([0.2, 0.3]) @ R)
    np.testing.assert_allclose(geared.damping(np.diag([1.0, 2.0])), geared.damping([1.0, 2.0]))
    assert abs(geared.armature([0.2, 0.3])[0, 1]) > 1e-3


def test_masses_in_the_joints_coordinates():
    """M_x = Rᵀ M_θ R: the same machine in the coordinates of pitch and roll."""
    mechanism = ankle()
    model = mechanism.model
    for joint in range(1, model.njoints):
        model.inertias[joint] = pin.Inertia(1.0, np.array([0.01, 0.02, 0.03]), 0.01 * np.eye(3))
    loops = [
        pj.DistanceLoop(frames=(f"tip{k}", f"heel{k}"), length=rod)
        for k, rod in enumerate(RODS, start=1)
    ]
    mechanism = pj.Mechanism.from_pinocchio(model, loops, ["motor1", "motor2"], "sole")
    geared = pj.transmission(mechanism, ["pitch", "roll"]).at_joints([0.1, 0.05])
    by_joints = geared.configuration.dynamics()
    by_motors = mechanism.configuration(geared.configuration.q).dynamics()
    R = geared.ratio
    np.testing.assert_allclose(by_joints.mass_matrix, R.T @ by_motors.mass_matrix @ R, atol=1e-12)
    np.testing.assert_allclose(by_joints.gravity, R.T @ by_motors.gravity, atol=1e-12)


@pytest.mark.parametrize(
    ("joints", "error", "message"),
    [
        (["phi3"], pj.PmjacError, "phi3"),
        (["phi1", "phi2"], pj.ArgumentError, "as many joints as motors, 1, got 2"),
        ("phi1", pj.ArgumentError, "a list of names"),
    ],
)
def test_joints_that_do_not_fit(joints, error, message):
    with pytest.raises(error, match=message):
        pj.transmission(pj.load("four_bar"), joints)


def test_where_the_joints_do_not_determine_the_motors():
    """At the rocker's dead point the crank moves on and the rocker rests."""
    l0, l1, l2, l3 = mechanisms.CRANK_ROCKER
    dead = np.arccos((l0**2 + (l1 + l2) ** 2 - l3**2) / (2 * l0 * (l1 + l2)))
    mechanism = pj.load(
        "four_bar", dict(zip(("l0", "l1", "l2", "l3"), (l0, l1, l2, l3), strict=True))
    )
    stuck = pj.transmission(mechanism, ["phi1"]).at(mechanism.close([dead]))
    with pytest.raises(pj.SingularError):
        stuck.motor_rates([1.0])


def test_motors_that_idle_are_not_determined():
    """The spin of a rod: no pose of crank and rocker tells it."""
    mechanism = mechanisms.rssr()
    spun = pj.Mechanism.from_pinocchio(
        mechanism.model, mechanism.spec.loops, ["rz"], "rocker_tip", home=mechanism.home.q
    )
    geared = pj.transmission(spun, ["theta"]).at(spun.home)
    with pytest.raises(pj.ArgumentError, match="do not determine what idles: rz"):
        geared.motor_rates([1.0])
    crank = pj.transmission(mechanism, ["psi"]).at(mechanism.home)
    ratio = mechanisms.rssr(rod=False).home.jacobian().passive_rates  # ψ̇ by θ̇
    assert crank.ratio[0, 0] * ratio[0, 0] == pytest.approx(1.0, rel=1e-6)


def test_a_ragged_matrix_is_told():
    geared = pj.transmission(ankle(), ["pitch", "roll"]).at_joints([0.0, 0.0])
    with pytest.raises(pj.ArgumentError, match="motor stiffness"):
        geared.stiffness([[1.0, 2.0], [3.0]])
