"""Ties of SDFormat models that are no joints: mimics, detachable joints, Drake's constraints."""

from __future__ import annotations

import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.files.sdf.reader import read_sdf

AXIS = "<axis><xyz>0 0 1</xyz>{}</axis>"


def sdf(body, version="1.11"):
    return (
        f'<sdf version="{version}" xmlns:drake="http://drake.mit.edu">'
        f'<model name="m">{body}</model></sdf>'
    )


def link(name, x=0.0, y=0.0):
    return f'<link name="{name}"><pose>{x} {y} 0 0 0 0</pose></link>'


def joint(name, parent, child, inside="", kind="revolute"):
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f'<joint name="{name}" type="{kind}">{ends}{AXIS.format(inside)}</joint>'


RHOMBUS = (
    link("crank") + link("coupler", 0, 1) + link("rocker", 4)
    + joint("a", "world", "crank") + joint("b", "crank", "coupler") + joint("d", "world", "rocker")
)  # fmt: skip
BALL = (
    "<drake:ball_constraint><drake:ball_constraint_body_A>coupler</drake:ball_constraint_body_A>"
    "<drake:ball_constraint_body_B>rocker</drake:ball_constraint_body_B>"
    "<drake:ball_constraint_p_AP>3 1 0</drake:ball_constraint_p_AP>"
    "<drake:ball_constraint_p_BQ>-1 2 0</drake:ball_constraint_p_BQ></drake:ball_constraint>"
)
DETACHABLE = (
    link("pin", 3, 2) + joint("c", "coupler", "pin")
    + '<plugin name="hold" filename="gz-sim-detachable-joint-system">'
    "<parent_link>rocker</parent_link><child_model>{}</child_model><child_link>pin</child_link>"
    "</plugin>"
)  # fmt: skip


@pytest.fixture
def write(tmp_path):
    def write(text):
        path = tmp_path / "robot.sdf"
        path.write_text(text)
        return path

    return write


@pytest.mark.parametrize(
    "tie", [BALL, DETACHABLE.format("m"), DETACHABLE.format("__model__")], ids=["ball", "m", "own"]
)
def test_a_tie_closes_the_rhombus(write, tie):
    """By hand: the tip C moves with the coupler and the rocker, (−1 − ω, 3ω) = (−2δ, −δ)."""
    path = write(sdf(RHOMBUS + tie))
    mechanism = pj.load(path, actuated=["a"], tool="coupler")
    assert (mechanism.mobility, len(mechanism.spec.loops)) == (1, 1)
    expected = [-1, 0, 0, 0, 0, -1 / 7]
    np.testing.assert_allclose(mechanism.home.jacobian().J_eq[:, 0], expected, atol=1e-12)
    assert mechanism.unread == ()


def test_a_gripper_is_told(write):
    """Gazebo makes a joint of it as soon as it holds something."""
    gripper = '<gripper name="g"><palm_link>rocker</palm_link></gripper>'
    found = read_sdf(write(sdf(RHOMBUS + gripper)))
    assert found.unread == ("not read: <gripper> 'g' in model 'm'",)


def test_what_is_tied_to_another_model_is_told(write):
    found = read_sdf(write(sdf(RHOMBUS + DETACHABLE.format("other"))))
    assert found.unread == ("not read: <plugin> 'gz-sim-detachable-joint-system' in model 'm'",)


PAIR = link("base") + link("left") + link("right", 1) + joint("hold", "world", "base", kind="fixed")
MIMIC = (
    '<mimic joint="lead"><multiplier>-2</multiplier><offset>0.1</offset>'
    "<reference>0.3</reference></mimic>"
)
FOLLOWS = {
    "mimic": joint("lead", "base", "left") + joint("follow", "base", "right", MIMIC),
    "Drake's": joint("lead", "base", "left")
    + joint("follow", "base", "right").replace(
        "</joint>", '<drake:mimic joint="lead" multiplier="-2" offset="0.7"/></joint>'
    ),
    "plugin": joint("lead", "base", "left")
    + joint("follow", "base", "right")
    + '<plugin name="p" filename="libroboticsgroup_upatras_gazebo_mimic_joint_plugin.so">'
    "<joint>lead</joint><mimicJoint>follow</mimicJoint><multiplier>-2</multiplier>"
    "<offset>0.7</offset><maxEffort>3</maxEffort></plugin>",
    "continuous": joint("lead", "base", "left", kind="continuous")
    + joint("follow", "base", "right", MIMIC, kind="continuous"),
}


@pytest.mark.parametrize("joints", FOLLOWS.values(), ids=FOLLOWS)
def test_a_joint_follows_another(write, joints):
    """follow = −2 (lead − 0.3) + 0.1."""
    mechanism = pj.load(write(sdf(PAIR + joints)), actuated=["lead"], tool="right")
    (loop,) = mechanism.spec.loops
    assert (loop.joints, loop.ratio) == (("lead", "follow"), -2.0)
    assert loop.offset == pytest.approx(0.7, abs=1e-15)
    assert mechanism.unread == ()
    configuration = mechanism.close([0.25])
    assert configuration.joint_values["follow"] == pytest.approx(0.2, abs=1e-12)
    np.testing.assert_allclose(configuration.jacobian().J_eq[5], [-2.0])


def test_an_axis_of_a_universal_joint_leads(write):
    cross = (
        '<joint name="lead" type="universal"><parent>base</parent><child>left</child>'
        "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint>"
    )
    mimic = '<mimic joint="lead" axis="axis2"><multiplier>3</multiplier></mimic>'
    found = read_sdf(write(sdf(PAIR + cross + joint("follow", "base", "right", mimic))))
    assert found.loops == (pj.JointLoop(joints=("lead_axis2", "follow"), ratio=3.0),)


def test_joints_that_follow_are_not_cut(write):
    """The rocker's joint comes last and would be cut."""
    mimic = '<mimic joint="a"><multiplier>1</multiplier></mimic>'
    body = link("crank") + link("coupler", 0, 1) + link("rocker", 4)
    chain = joint("a", "world", "crank") + joint("b", "crank", "coupler")
    tip = joint("tip", "coupler", "rocker")
    found = read_sdf(write(sdf(body + chain + tip + joint("d", "world", "rocker", mimic))))
    assert [type(loop) for loop in found.loops] == [pj.RevoluteLoop, pj.JointLoop]
    assert found.loops[0].ends[0].startswith("tip_on")


BAD = {
    "leader": (MIMIC.replace("lead", "leed"), "the joint 'leed' does not exist; did you mean"),
    "axis": (MIMIC.replace('"lead"', '"lead" axis="axis2"'), "joint 'lead' has no 'axis2'"),
    "itself": (MIMIC.replace("lead", "follow"), "the joint follows itself"),
    "number": (MIMIC.replace("-2", "two"), "<multiplier> is 'two', not a finite number"),
}


@pytest.mark.parametrize(("mimic", "message"), BAD.values(), ids=BAD)
def test_what_is_wrong_with_a_mimic(write, mimic, message):
    joints = joint("lead", "base", "left") + joint("follow", "base", "right", mimic)
    with pytest.raises(pj.ModelFileError, match=message):
        read_sdf(write(sdf(PAIR + joints)))


TIE_ERRORS = {
    "coupler": ("<drake:coupler_constraint/>", "is not read; gear the joints by <mimic> in an"),
    "weld": ("<drake:weld_constraint/>", "<drake:weld_constraint> is not read; write it as a"),
    "link": (BALL.replace(">coupler<", ">copler<"), "the link 'copler' does not exist; did you"),
    "itself": (BALL.replace(">coupler<", ">rocker<"), "joins link 'rocker' to itself"),
    "part": (BALL.replace("_p_AP", "_p_AQ"), "unknown <drake:ball_constraint_p_AQ>; did you mean"),
    "point": (BALL.replace("3 1 0", "3 1"), "is '3 1', not 3 finite numbers"),
    "ends": (DETACHABLE.format("m").replace(">rocker<", ">pin<"), "joins link 'pin' to itself"),
}


@pytest.mark.parametrize(("tie", "message"), TIE_ERRORS.values(), ids=TIE_ERRORS)
def test_what_is_wrong_with_a_tie(write, tie, message):
    with pytest.raises(pj.ModelFileError, match=message):
        read_sdf(write(sdf(RHOMBUS + tie)))


# --- the world around a model ---------------------------------------------------------------------

GROUND = '<model name="ground_plane"><static>true</static><link name="link"/></model>'
ARM = f'<model name="arm">{link("base")}{link("tip")}{joint("j", "base", "tip")}</model>'


def world(*inside):
    return f'<sdf version="1.9"><world name="w">{"".join(inside)}</world></sdf>'


def include(place):
    return f"<include><uri>{place}</uri></include>"


def test_a_robot_on_the_ground_is_read(write):
    scenery = include("model://sun") + include(
        "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Ground%20Plane"
    )
    found = read_sdf(write(world(GROUND, ARM, scenery)))
    assert (found.name, found.unread) == ("arm", ())
    assert "model 'ground_plane' is static, and left out" in found.notes


def test_what_a_world_includes_is_told_or_refused(write):
    found = read_sdf(write(world(ARM, include("model://linkage"))))
    assert found.unread == ("not read: <include> of 'model://linkage'",)
    with pytest.raises(pj.ModelFileError, match="<include> of 'model://linkage' is not read; wri"):
        read_sdf(write(world(GROUND, include("model://linkage"))))


def test_a_joint_of_the_world_is_told(write):
    tie = '<joint name="k" type="fixed"><parent>world</parent><child>arm::tip</child></joint>'
    assert read_sdf(write(world(ARM, tie))).unread == ("not read: <joint> 'k' in world 'w'",)


def test_models_that_move_are_not_chosen_among(write):
    with pytest.raises(pj.ModelFileError, match="there are 3 models, 1 of them static; a file wi"):
        read_sdf(write(world(GROUND, ARM, ARM.replace('"arm"', '"leg"'))))


# --- limits and ratios ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("lower", "upper", "message"),
    [
        ("inf", "1", "<lower> is inf; no limit is -inf to inf"),
        ("-1", "-inf", "<upper> is -inf; no limit is"),
        ("inf", "-inf", "<lower> is inf; no"),
        ("1e16", "2e16", "<lower> is inf; no"),
    ],
)
def test_no_limits_the_wrong_way_round(write, lower, upper, message):
    limit = f"<limit><lower>{lower}</lower><upper>{upper}</upper></limit>"
    with pytest.raises(pj.ModelFileError, match=message):
        read_sdf(write(sdf(link("a") + link("b") + joint("j", "a", "b", limit))))


def test_a_gearbox_that_holds_a_joint(write):
    gears = "<gearbox_reference_body>a</gearbox_reference_body><gearbox_ratio>0</gearbox_ratio>"
    box = joint("g", "b", "c", kind="gearbox").replace(
        "</joint>", f"{gears}<axis2><xyz>0 0 1</xyz></axis2></joint>"
    )
    text = link("a") + link("b") + link("c") + joint("i", "a", "b") + joint("j", "a", "c") + box
    with pytest.raises(pj.ModelFileError, match="<gearbox_ratio> is 0, which holds a joint"):
        read_sdf(write(sdf(text)))


@pytest.mark.parametrize(
    "place",
    [
        "https://x/y/ground_plane",
        "model://mine/ground_plane",
        "ground_plane",
        "model://sun2",
        "https://fuel.gazebosim.org.evil.org/1.0/openrobotics/models/sun",
    ],
)
def test_what_is_only_called_like_the_ground_is_told(write, place):
    found = read_sdf(write(world(GROUND, ARM, include(place))))
    assert found.unread == (f"not read: <include> of {place!r}",)


def test_what_holds_something_to_the_ground_is_told(write):
    hold = '<plugin filename="gz-sim-detachable-joint-system" name="h"/></include>'
    held = include("model://ground_plane").replace("</include>", hold)
    told = "not read: <plugin> 'gz-sim-detachable-joint-system' in <include>"
    assert read_sdf(write(world(GROUND, ARM, held))).unread == (told,)


def wall(inside):
    return f'<model name="wall"><static>1</static><link name="w"/><link name="v"/>{inside}</model>'


@pytest.mark.parametrize("kind", ["fixed", "revolute"])
def test_a_static_model_that_holds_another_is_told(write, kind):
    """The joint ties a link of the machine to the world."""
    found = read_sdf(write(world(wall(joint("j", "w", "arm::a", kind=kind)), ARM)))
    assert found.unread == ("not read: joint 'j' in model 'wall', which joins 'arm::a'",)
    assert "model 'wall' is static, and left out" in found.notes
    assert read_sdf(write(world(wall(joint("j", "w", "v", kind=kind)), ARM))).unread == ()


@pytest.mark.parametrize(
    ("kind", "tag"), [("revolute", "axis2"), ("fixed", "axis"), ("ball", "axis"), ("ball", "axis2")]
)
def test_an_axis_that_a_joint_does_not_have_follows_nothing(write, kind, tag):
    ends = '<joint name="e" type="{}"><parent>rocker</parent><child>z</child>{}{}</joint>'
    axis = AXIS.format("") if kind == "revolute" else ""
    extra = f'<{tag}><xyz>0 0 1</xyz><mimic joint="a"/></{tag}>'
    with pytest.raises(pj.ModelFileError, match=f"<{tag}> holds a <mimic>, and a joint of type"):
        read_sdf(write(sdf(RHOMBUS + link("z") + ends.format(kind, axis, extra))))
