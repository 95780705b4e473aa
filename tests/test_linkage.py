"""Linkage: a model taken apart and put together again is the same model."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.model.linkage import build, edges_of, with_spherical

BALL = mechanisms.tree(
    ("motor", "revolute", "ground", "arm", (0, 0, 0.2), (1, 2, 0), (0.3, 0, 0.1)),
    ("ball", "floating", "arm", "hand", (0.5, 0, 0)),
    ("slide", "prismatic", "hand", "finger", (0, 0.1, 0), (0, 1, 1)),
    ("wheel", "continuous", "finger", "rim", (0, 0, 0.3), (1, 1, 1)),
    ("flat", "planar", "rim", "plate", (0, 0, 0), (0, 0, 1)),
)


@pytest.mark.parametrize("name", [*mechanisms.CATALOGUE, "all kinds"])
def test_rebuilding_changes_no_pose_and_no_twist(name, rng):
    model = pin.buildModelFromXML(BALL) if name == "all kinds" else loaded(name).model
    twin = build(model, edges_of(model).values(), {})
    assert list(twin.names) == list(model.names)
    np.testing.assert_array_equal(twin.lowerPositionLimit, model.lowerPositionLimit)
    q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
    datas = [one.createData() for one in (model, twin)]
    for one, data in zip((model, twin), datas, strict=True):
        pin.computeJointJacobians(one, data, q)
        pin.updateFramePlacements(one, data)
    for index, frame in enumerate(model.frames):
        if frame.type == pin.FrameType.JOINT:
            continue
        other = next(
            k
            for k, candidate in enumerate(twin.frames)
            if candidate.name == frame.name and candidate.type == frame.type
        )
        np.testing.assert_allclose(
            datas[1].oMf[other].homogeneous, datas[0].oMf[index].homogeneous, atol=1e-14
        )
    if name != "all kinds":  # motions of several degrees of freedom keep their frames, too
        np.testing.assert_allclose(datas[1].J, datas[0].J, atol=1e-14)
    assert pin.computeTotalMass(twin) == pytest.approx(pin.computeTotalMass(model))


TURN = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, 0.7), np.zeros(3))
MOTIONS = {
    "revolute": TURN,
    "continuous": TURN,
    "prismatic": pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.4])),
    "planar": pin.SE3(TURN.rotation, np.array([0.3, -0.2, 0.0])),
    "free": pin.SE3(pin.exp3(np.array([0.3, 0.2, -0.5])), np.array([0.3, -0.2, 0.1])),
}


def test_a_turned_joint_keeps_its_value():
    model = pin.buildModelFromXML(BALL)
    for edge in edges_of(model).values():
        one, motion = pin.SE3.Random(), MOTIONS[edge.kind.name]
        other = one * edge.before * motion * edge.after
        entries = edge.entries(one, other)
        back = edge.turned().turned()
        np.testing.assert_allclose(back.entries(one, other), entries, atol=1e-14)
        if edge.kind.name in ("revolute", "prismatic", "continuous"):
            turned = edge.turned().entries(other, one)
            np.testing.assert_allclose(turned, entries, atol=1e-14)


def test_a_ball_joint():
    model = with_spherical(pin.buildModelFromXML(BALL), ["ball"])
    assert model.joints[model.getJointId("ball")].shortname() == "JointModelSpherical"
    assert (model.nq, model.nv) == (1 + 4 + 1 + 2 + 4, 1 + 3 + 1 + 1 + 3)
    with pytest.raises(pj.ArgumentError, match="writes as floating, got 'slide'"):
        with_spherical(model, ["slide"])


def test_a_ball_joint_in_a_model_file(tmp_path):
    (tmp_path / "ball.urdf").write_text(BALL)
    (tmp_path / "ball.toml").write_text(
        'urdf = "ball.urdf"\nactuated = ["motor"]\nspherical = ["ball"]\n'
        'tool.frame = "plate"\n[poses.home]\nball = [0.1, 0.2, 0.3]\n'
    )
    mechanism = pj.load(tmp_path / "ball.toml")
    assert mechanism.passive[:3] == ("ball.rx", "ball.ry", "ball.rz")
    np.testing.assert_allclose(mechanism.home.passive[:3], [0.1, 0.2, 0.3])
