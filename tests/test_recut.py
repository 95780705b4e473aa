"""Recut: J_eq does not change with the joint at which the loops are cut."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj

MECHANISMS = {
    **{name: (lambda name=name: loaded(name)) for name in mechanisms.CLOSED},
    "yawing_four_bar": mechanisms.yawing_four_bar,
    "rssr": mechanisms.rssr,
    "rssr_rod": lambda: mechanisms.rssr(rod=False),
    "three_crank_parallelogram": mechanisms.three_crank_parallelogram,
}


def cuts_of(mechanism):
    """Yield each joint that is part of a loop, and the mechanism cut there."""
    for joint in list(mechanism.model.names)[1:]:
        try:
            yield joint, pj.recut(mechanism, joint)
        except pj.ArgumentError as error:
            assert "is in no loop" in str(error)


@pytest.mark.parametrize(
    "name", mechanisms.mostly_slow(MECHANISMS, {*mechanisms.SAMPLE, "yawing_four_bar", "rssr_rod"})
)
def test_j_eq_is_the_same_cut_at_every_joint(name, rng):
    mechanism = MECHANISMS[name]()
    poses = [mechanism.home, *mechanisms.random_closed(mechanism, rng, 3, 0.2)]
    cuts = dict(cuts_of(mechanism))
    assert cuts
    for joint, recut in cuts.items():
        assert recut.actuated == mechanism.actuated
        for configuration in poses:
            twin = recut.close(configuration.actuated)
            np.testing.assert_allclose(
                twin.tool_pose().homogeneous, configuration.tool_pose().homogeneous, atol=1e-9
            )
            J_eq = configuration.jacobian().J_eq
            difference = np.abs(twin.jacobian().J_eq - J_eq).max()
            assert difference <= 1e-9 * np.abs(J_eq).max(), joint


@pytest.mark.parametrize("name", ["three_rps", "three_rps_ss"])
def test_named_poses_stay_on_their_assembly_modes(name):
    mechanism = loaded(name)
    recut = pj.recut(mechanism, "theta2")
    for pose in mechanism.poses:
        np.testing.assert_allclose(
            recut.pose(pose).tool_pose().homogeneous,
            mechanism.pose(pose).tool_pose().homogeneous,
            atol=1e-10,
        )


def hinges(loop, count):
    """A motor, `count` hinges about skew axes, and a loop of some kind back to the ground."""
    rng = np.random.default_rng(6)
    joints, link = [], "ground"
    for k in range(count + 1):
        axis = rng.normal(size=3).tolist()
        xyz = rng.uniform(0.3, 0.8, 3).tolist()
        rpy = rng.uniform(-1, 1, 3).tolist()
        joints.append((f"q{k}", "revolute", link, f"link{k}", xyz, axis, rpy))
        link = f"link{k}"
    model = pin.buildModelFromXML(mechanisms.tree(*joints))
    # The loop's frames coincide at home.
    q = rng.uniform(-0.5, 0.5, model.nq)
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    hand = data.oMi[model.njoints - 1]
    end = pin.SE3(pin.exp3(np.array([0.3, -0.4, 0.2])), np.array([0.2, 0.1, 0.3]))
    model.addFrame(pin.Frame("hand", model.njoints - 1, end, pin.FrameType.OP_FRAME))
    model.addFrame(pin.Frame("wall", 0, hand * end * OFFSETS[type(loop)], pin.FrameType.OP_FRAME))
    return pj.Mechanism.from_pinocchio(
        model, [loop], ["q0"], f"link{count // 2}", home=q, name=type(loop).__name__
    )


QUARTER = pin.SE3(pin.AngleAxis(0.4, np.array([0.0, 0.0, 1.0])).matrix(), np.zeros(3))
SLID = pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.2]))
FLAT = pin.SE3(np.eye(3), np.array([0.1, 0.2, 0.0]))
CROSS = pin.SE3(pin.rpy.rpyToMatrix(0.3, 0.5, 0.0), np.zeros(3)).inverse()
OFFSETS = {
    pj.PointLoop: QUARTER,
    pj.FrameLoop: pin.SE3.Identity(),
    pj.RevoluteLoop: QUARTER,
    pj.PrismaticLoop: SLID,
    pj.CylindricalLoop: SLID * QUARTER,
    pj.PlanarLoop: FLAT * QUARTER,
    pj.UniversalLoop: CROSS,
    pj.DistanceLoop: pin.SE3(np.eye(3), np.array([0.3, 0.0, 0.4])),
}
# Passive hinges that leave one degree of freedom.
KINDS = {
    pj.PointLoop: 3,
    pj.FrameLoop: 6,
    pj.RevoluteLoop: 5,
    pj.PrismaticLoop: 5,
    pj.CylindricalLoop: 4,
    pj.PlanarLoop: 3,
    pj.UniversalLoop: 4,
    pj.DistanceLoop: 1,
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("order", [("hand", "wall"), ("wall", "hand")])
def test_every_kind_of_loop_becomes_a_joint(kind, order):
    loop = kind(frames=order, **({"length": 0.5} if kind is pj.DistanceLoop else {}))
    if kind is pj.UniversalLoop and order[0] == "wall":
        loop = pj.UniversalLoop(frames=order, axes=((0, 1, 0), (1, 0, 0)))
    mechanism = hinges(loop, KINDS[kind])
    assert mechanism.mobility == 1
    theta = mechanism.home.actuated
    for joint in list(mechanism.model.names)[1:]:
        recut = pj.recut(mechanism, joint)
        for step in (-0.01, 0.0, 0.01):
            one, other = mechanism.close(theta + step), recut.close(theta + step)
            np.testing.assert_allclose(
                other.jacobian().J_eq, one.jacobian().J_eq, rtol=0, atol=1e-9
            )


def test_a_recut_mechanism_can_be_recut():
    mechanism = loaded("three_rps")
    recut = pj.recut(pj.recut(mechanism, "theta1"), "theta3")
    J_eq = mechanism.home.jacobian().J_eq
    np.testing.assert_allclose(recut.home.jacobian().J_eq, J_eq, atol=1e-10)


def test_names_of_new_frames_do_not_collide():
    mechanism = loaded("four_bar")
    J_eq = mechanism.home.jacobian().J_eq
    again = pj.recut(pj.recut(mechanism, "theta1"), "theta1")
    np.testing.assert_allclose(again.home.jacobian().J_eq, J_eq, atol=1e-10)
    model = mechanism.model
    for name in ("phi1_child", "phi1_parent"):
        model.addFrame(pin.Frame(name, 0, pin.SE3.Random(), pin.FrameType.OP_FRAME))
    taken = pj.Mechanism.from_pinocchio(
        model, mechanism.spec.loops, ["theta1"], "coupler_midpoint", home=mechanism.home.q
    )
    np.testing.assert_allclose(pj.recut(taken, "phi1").home.jacobian().J_eq, J_eq, atol=1e-10)


def test_bad_joints():
    mechanism = loaded("three_rps")
    with pytest.raises(pj.UnknownNameError, match="did you mean 'theta1'"):
        pj.recut(mechanism, "thet1")
    with pytest.raises(pj.ArgumentError, match="'elbow_joint' is in no loop"):
        pj.recut(loaded("ur5"), "elbow_joint")


def test_limits_of_a_joint_that_is_cut_are_said_to_be_lost():
    mechanism = loaded("five_bar")
    model = mechanism.model.copy()
    index = model.joints[model.getJointId("phi1")].idx_q
    model.lowerPositionLimit[index], model.upperPositionLimit[index] = -2.5, 2.5
    index = model.joints[model.getJointId("phi2")].idx_q
    model.lowerPositionLimit[index], model.upperPositionLimit[index] = (
        -np.finfo(float).max,
        np.finfo(float).max,
    )
    limited = pj.Mechanism.from_pinocchio(
        model,
        mechanism.spec.loops,
        mechanism.actuated,
        mechanism.spec.tool.frame,
        home=mechanism.home.joint_values,
    )
    assert limited.limits("phi1") == (-2.5, 2.5)
    assert np.isinf(limited.limits("phi2")).all()
    assert pj.recut(limited, "phi1").notes == (
        "joint 'phi1' is cut: a loop closure has no limits, so its own are lost",
    )
    assert pj.recut(limited, "phi2").notes == ()
