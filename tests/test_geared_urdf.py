"""A model file over a URDF whose joints follow others: they follow as where it is read alone."""

from __future__ import annotations

import numpy as np
import pytest
from looped import joint, link, robot

import pmjac_pin as pj

CONTROL = (
    '<ros2_control name="c" type="system"><joint name="right"><param name="mimic">left</param>'
    '<param name="multiplier">-2</param><param name="offset">0.5</param></joint></ros2_control>'
)
PLUGIN = (
    '<gazebo><plugin name="follow" filename="libroboticsgroup_gazebo_mimic_joint_plugin.so">'
    "<joint>left</joint><mimicJoint>right</mimicJoint><multiplier>-2</multiplier>"
    "<offset>0.5</offset></plugin></gazebo>"
)
MIMIC = '<mimic joint="left" multiplier="-2" offset="0.5"/>'
#: What the second joint holds and what stands beside the joints.
WAYS = {"mimic": (MIMIC, ""), "plugin": ("", PLUGIN), "ros2_control": ("", CONTROL)}
GEAR = pj.JointLoop(joints=("left", "right"), ratio=-2, offset=0.5)


def fingers(inside, beside="", kind="revolute"):
    """Two fingers on one motor: the second moves twice as far, the other way, from 0.5 on."""
    return robot(
        *(link(name) for name in ("palm", "a", "b", "tip")),
        joint("left", "revolute", "palm", "a"),
        joint("right", kind, "palm", "b", (1, 0, 0), inside=inside),
        joint("tip_fixed", "fixed", "b", "tip", (0.2, 0, 0)),
        beside,
    )


@pytest.fixture
def write(tmp_path):
    """Write a URDF and a model file over it; return both paths."""

    def write(text, loops="", actuated="left"):
        urdf, model_file = tmp_path / "fingers.urdf", tmp_path / "fingers.toml"
        urdf.write_text(text)
        model_file.write_text(
            f'urdf = "fingers.urdf"\nactuated = ["{actuated}"]\ntool.frame = "tip"\n{loops}\n'
            "[poses.home]\nleft = 0.1\n"
        )
        return urdf, model_file

    return write


def stated(first, second, ratio, offset):
    return (
        f'[[loop]]\nkind = "joint"\njoints = ["{first}", "{second}"]\n'
        f"ratio = {ratio}\noffset = {offset}\n"
    )


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    "loops",
    ["", stated("left", "right", -2, 0.5), stated("right", "left", -0.5, 0.25)],
    ids=["told by the URDF", "told twice", "told twice, seen from the other side"],
)
def test_joints_follow_as_where_the_urdf_is_read_alone(write, way, loops):
    urdf, model_file = write(fingers(*WAYS[way]), loops)
    alone, over = pj.load(urdf, actuated=["left"], tool="tip"), pj.load(model_file)
    assert alone.spec.loops == (GEAR,)
    assert len(over.spec.loops) == 1
    assert (over.passive, over.unread) == (alone.passive, alone.unread)
    one, other = alone.close([0.3]), over.close([0.3])
    np.testing.assert_allclose(other.q, one.q, rtol=0, atol=1e-12)
    np.testing.assert_allclose(other.jacobian().J_eq, one.jacobian().J_eq, rtol=0, atol=1e-12)
    np.testing.assert_allclose(other.jacobian().J_eq[5], [-2.0])


def test_a_gear_that_the_model_file_states_is_kept_as_it_states_it(write):
    loops = stated("right", "left", -0.5, 0.25)
    (loop,) = pj.load(write(fingers(MIMIC), loops)[1]).spec.loops
    assert loop == pj.JointLoop(joints=("right", "left"), ratio=-0.5, offset=0.25)


@pytest.mark.parametrize(
    "loop",
    [
        ("left", "right", 2, 0.5),
        ("left", "right", -2, 0.4),
        ("right", "left", -2, 0.5),
        ("right", "left", -0.5, -0.25),
    ],
)
def test_one_that_it_states_otherwise_is_refused(write, loop):
    said = (
        r"fingers.urdf: joint 'right' follows 'left' otherwise by its URDF "
        r"\(right = -2.0 left \+ 0.5\) than by the \[\[loop\]\] of the model file"
    )
    with pytest.raises(pj.ModelFileError, match=said):
        pj.load(write(fingers(MIMIC), stated(*loop))[1])


def test_what_gears_a_joint_to_another_one_stays(write):
    """Two equations of one joint, with different leaders, are two."""
    text = fingers(MIMIC).replace(
        "</robot>", link("c") + joint("thumb", "revolute", "palm", "c") + "</robot>"
    )
    loops = stated("thumb", "right", 3, 0)
    mechanism = pj.load(write(text, loops)[1])
    assert [loop.joints for loop in mechanism.spec.loops] == [("thumb", "right"), ("left", "right")]
    values = dict(zip(mechanism.passive, mechanism.close([0.3]).passive, strict=True))
    assert values == pytest.approx({"right": -0.1, "thumb": -0.1 / 3})


def test_a_fixed_joint_that_is_to_follow_is_told(write):
    text = (
        fingers(MIMIC)
        .replace("</robot>", "")
        .replace(
            joint("tip_fixed", "fixed", "b", "tip", (0.2, 0, 0)),
            joint("tip_fixed", "fixed", "b", "tip", (0.2, 0, 0), inside='<mimic joint="left"/>'),
        )
    )
    mechanism = pj.load(write(text + "</robot>")[1])
    assert "fixed, and follow no other joint: 'tip_fixed'" in mechanism.notes
    assert mechanism.spec.loops == (GEAR,)


@pytest.mark.parametrize(
    ("inside", "said"),
    [
        ('<mimic joint="lefft"/>', "the joint 'lefft' does not exist; did you mean 'left'"),
        ('<mimic joint="right"/>', "the joint follows itself"),
        ('<mimic joint="left" multplier="2"/>', "unknown attribute 'multplier'"),
    ],
)
def test_a_mimic_that_is_wrong_is_refused_by_the_name_of_its_file(write, inside, said):
    with pytest.raises(pj.ModelFileError, match=f"fingers.urdf: .*{said}"):
        pj.load(write(fingers(inside))[1])


def test_what_is_converted_says_it_once(write, tmp_path):
    """The gear of the URDF is a loop of the model file that is written, and no mimic any more."""
    pj.convert(write(fingers(MIMIC))[1], tmp_path / "mine.toml")
    mechanism = pj.load(tmp_path / "mine.toml")
    assert mechanism.spec.loops == (GEAR,)
    assert "<mimic" not in mechanism.urdf.text


def test_a_motor_may_follow(write):
    """The follower as the motor: the leader moves half as far."""
    mechanism = pj.load(write(fingers(MIMIC), actuated="right")[1])
    assert mechanism.passive == ("left",)
    np.testing.assert_allclose(mechanism.home.jacobian().J_eq[5], [1.0])
