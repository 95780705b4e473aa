"""Joint values on one side, Pinocchio's q on the other."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.model.coordinates import JointCoordinates

JOINTS = [
    ("slide", "prismatic", "a", "b", (0, 0, 0), (1, 0, 0)),
    ("turn", "continuous", "b", "c", (0, 0, 0), (0, 0, 1)),
    ("lean", "revolute", "c", "d", (0, 0, 0), (0, 1, 0)),
    ("plane", "planar", "d", "e", (0, 0, 0), (0, 0, 1)),
    ("free", "floating", "e", "f", (0, 0, 0)),
]


@pytest.fixture(scope="module")
def coordinates():
    return JointCoordinates(pin.buildModelFromXML(mechanisms.tree(*JOINTS)))


def test_names_and_columns(coordinates):
    names = ("turn", "free", "slide")
    assert coordinates.dof_names(names) == (
        "turn", "free.x", "free.y", "free.z", "free.rx", "free.ry", "free.rz", "slide",
    )  # fmt: skip
    assert coordinates.columns(names).tolist() == [1, 6, 7, 8, 9, 10, 11, 0]
    assert coordinates.rotational.tolist() == [0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 1]


def test_what_turns_is_what_pinocchio_turns():
    model = loaded("ankle").model
    for joint in (pin.JointModelPlanar(), pin.JointModelHZ(0.2), pin.JointModelSphericalZYX()):
        model.addJoint(1, joint, pin.SE3.Random(), joint.shortname())
    motions = pin.computeJointJacobians(model, model.createData(), pin.neutral(model))
    turns = np.abs(motions[3:]).max(axis=0) > 0.0
    assert JointCoordinates(model).rotational.tolist() == turns.tolist()


def test_values_and_back(coordinates, rng):
    for _ in range(50):
        pose = {
            "slide": rng.normal(),
            "turn": rng.uniform(-3.1, 3.1),
            "lean": rng.uniform(-6, 6),
            "plane": [*rng.normal(size=2), rng.uniform(-3.1, 3.1)],
            "free": rng.uniform(-1.7, 1.7, 6),
        }
        q = coordinates.q(pose)
        expected = np.concatenate([np.atleast_1d(value) for value in pose.values()])
        np.testing.assert_allclose(coordinates.values(q), expected, atol=1e-14)
        np.testing.assert_array_equal(coordinates.q(coordinates.pose(q)), q)
        by_columns = coordinates.with_values(q, np.array([1, 2]), np.array([0.5, -0.4]))
        np.testing.assert_allclose(coordinates.values(by_columns)[[1, 2]], [0.5, -0.4])


def test_pinocchios_own_entries_are_taken_too(coordinates):
    q = coordinates.q({"turn": (0.0, 1.0), "free": (1, 2, 3, 0, 0, 1, 0)})
    np.testing.assert_allclose(coordinates.values(q)[1], np.pi / 2)
    np.testing.assert_allclose(np.abs(coordinates.values(q)[6:]), [1, 2, 3, 0, 0, np.pi])


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        ({"plane": [1, 2]}, "joint 'plane' takes 3 or 4 values, got 2"),
        ({"lean": [1, 2]}, "joint 'lean' takes 1 value, got 2"),
        ({"free": [0] * 7}, "the quaternion or (cos, sin) of joint 'free' is not of unit length"),
        ({"turn": (1, 1)}, "the quaternion or (cos, sin) of joint 'turn' is not of unit length"),
        ({"lean": "0.1"}, "the value of joint 'lean' must be real numbers, got '0.1'"),
    ],
)
def test_bad_values(coordinates, pose, message):
    with pytest.raises(pj.ArgumentError) as caught:
        coordinates.q(pose)
    assert str(caught.value) == message
