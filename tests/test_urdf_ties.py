"""What other programs write into a URDF to tie bodies together."""

from __future__ import annotations

import looped
import numpy as np
import pinocchio as pin
import pytest
from looped import TOOL

import pmjac_pin as pj
from pmjac_pin.files.urdf.looped_urdf import read_looped_urdf

RHOMBUS = """
<robot name="rhombus">
  <link name="ground"/><link name="crank"/><link name="coupler"/><link name="rocker"/>
  <joint name="a" type="continuous"><parent link="ground"/><child link="crank"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="b" type="continuous"><parent link="crank"/><child link="coupler"/>
    <origin xyz="0 1 0"/><axis xyz="0 0 1"/></joint>
  <joint name="d" type="continuous"><parent link="ground"/><child link="rocker"/>
    <origin xyz="4 0 0"/><axis xyz="0 0 1"/></joint>
  {}
</robot>"""
PIN = '<gazebo><joint name="c" type="revolute"><parent>coupler</parent><child>rocker</child>'
PIN += "<pose>-1 2 0 0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint></gazebo>"


@pytest.fixture
def write(tmp_path):
    def write(text, name="machine.urdf"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return write


@pytest.fixture
def refusal(write):
    def refusal(text):
        with pytest.raises(pj.ModelFileError) as caught:
            read_looped_urdf(write(text))
        return str(caught.value).partition(": ")[2]

    return refusal


def test_a_joint_of_gazebo_closes_the_rhombus(write):
    """By hand: the tip C moves with the coupler and the rocker, (−1 − ω, 3ω) = (−2δ, −δ)."""
    mechanism = pj.load(write(RHOMBUS.format(PIN)), actuated=["a"], tool="coupler")
    assert (mechanism.mobility, mechanism.passive) == (1, ("b", "d"))
    expected = [-1, 0, 0, 0, 0, -1 / 7]
    np.testing.assert_allclose(mechanism.home.jacobian().J_eq[:, 0], expected, atol=1e-12)
    assert "joint 'c' of <gazebo> is closed as revolute, without its limits" in mechanism.notes


def test_a_looped_urdf_does_not_make_motors_of_its_passive_joints(write):
    path = write(RHOMBUS.format(PIN))
    with pytest.raises(pj.ModelFileError, match="which joints are motors; give `actuated`, of: a"):
        pj.load(path, tool="coupler")


DETACHABLE = (
    '<link name="pin"/><joint name="c" type="continuous"><parent link="coupler"/>'
    '<child link="pin"/><origin xyz="3 1 0"/><axis xyz="0 0 1"/></joint>'
    '<gazebo><plugin name="hold" filename="gz-sim-detachable-joint-system">'
    "<parent_link>rocker</parent_link><child_model>{}</child_model><child_link>pin</child_link>"
    "</plugin></gazebo>"
)


@pytest.mark.parametrize("model", ["rhombus", "__model__"])
def test_a_detachable_joint_closes_it_too(write, tmp_path, model):
    """As SDFormat's does: a joint of the same two bodies that is cut."""
    path = write(RHOMBUS.format(DETACHABLE.format(model)))
    mechanism = pj.load(path, actuated=["a"], tool="coupler")
    expected = [-1, 0, 0, 0, 0, -1 / 7]
    np.testing.assert_allclose(mechanism.home.jacobian().J_eq[:, 0], expected, atol=1e-12)
    assert mechanism.unread == ()
    ends = "between links 'rocker' and 'pin'"
    assert f"plugin 'hold' of <gazebo> is closed as fixed, {ends}" in mechanism.notes
    target, _ = pj.convert(path, tmp_path / "out.toml", actuated=["a"], tool="coupler")
    after = pj.load(target)
    assert (after.unread, after.spec.loops) == ((), mechanism.spec.loops)


def test_what_is_tied_to_another_robot_is_told(write):
    found = read_looped_urdf(write(RHOMBUS.format(DETACHABLE.format("other"))))
    assert found.unread == ("not read: <plugin> 'gz-sim-detachable-joint-system' in <gazebo>",)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", ["revolute", "prismatic", "universal", "fixed", "ball"])
def test_a_joint_of_gazebo_is_where_both_links_see_it_at_zero(write, kind, seed):
    """Origins turned at random; the pose may be seen from any link."""
    rng = np.random.default_rng(seed)
    seen = ("ground", "crank", "coupler", "rocker")[seed % 4]

    def place():
        return " ".join(map(repr, rng.uniform(-1, 1, 3).tolist()))

    joints = [
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{place()}" rpy="{place()}"/><axis xyz="{place()}"/></joint>'
        for name, parent, child in (
            ("a", "ground", "crank"), ("b", "crank", "coupler"), ("d", "ground", "rocker")
        )
    ]  # fmt: skip
    axes = {"revolute": 1, "prismatic": 1, "universal": 2}.get(kind, 0)
    given = ("<xyz>1 2 2</xyz>", "<xyz>2 1 -2</xyz>")[:axes]
    tags = ("axis", "axis2")[:axes]
    inside = "".join(f"<{tag}>{xyz}</{tag}>" for tag, xyz in zip(tags, given, strict=True))
    pose = f"{place()} {place()}"
    tie = (
        f'<gazebo><joint name="c" type="{kind}"><parent>coupler</parent><child>rocker</child>'
        f'<pose relative_to="{seen}">{pose}</pose>{inside}</joint></gazebo>'
    )
    links = "".join(f'<link name="{name}"/>' for name in ("ground", "crank", "coupler", "rocker"))
    found = read_looped_urdf(write(f'<robot name="r">{links}{"".join(joints)}{tie}</robot>'))
    model = pin.buildModelFromXML(found.urdf.kinematic_xml())
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    first, second = (data.oMf[model.getFrameId(name)] for name in found.loops[0].ends)
    np.testing.assert_allclose(first.homogeneous, second.homogeneous, atol=1e-12)
    numbers = np.array(pose.split(), dtype=float)
    placed = pin.SE3(pin.rpy.rpyToMatrix(numbers[3:]), numbers[:3])
    wanted = data.oMf[model.getFrameId(seen)] * placed
    np.testing.assert_allclose(first.homogeneous, wanted.homogeneous, atol=1e-12)


def test_a_base_that_gazebo_holds_is_held(write):
    hold = '<gazebo><joint name="hold" type="fixed"><parent>world</parent><child>ground</child>'
    path = write(RHOMBUS.format(f"{PIN}{hold}</joint></gazebo>"))
    mechanism = pj.load(path, actuated=["a"], tool="coupler")
    assert len(mechanism.spec.loops) == 1
    assert "joint 'hold' of <gazebo> holds the base: it is held anyway" in mechanism.notes


def test_closing_frames_that_others_join_are_left_to_them(write):
    p = looped.points()
    frames = looped.closing_frames()
    loop = '<loop name="l" type="revolute"><predecessor link="closing_tip_1"/>'
    loop += '<successor link="closing_tip_2"/><axis xyz="0 0 1"/></loop>'
    found = read_looped_urdf(write(looped.with_element(frames + loop)))
    assert [type(loop) for loop in found.loops] == [pj.RevoluteLoop]
    path = write(looped.with_element(frames), "robot.urdf")
    path.with_name("robot.yaml").write_text(
        "closed_loop: [[closing_tip_1, closing_tip_2]]\ntype: [3d]\nname_mot: [theta1]\n"
    )
    mechanism = pj.load(path, tool=TOOL)
    assert mechanism.spec.loops == (pj.PointLoop(frames=("closing_tip_1", "closing_tip_2")),)
    assert p["C"].any()


def test_a_closing_frame_alone_is_told(write):
    links, joints = looped.chain()
    one = looped.link("closing_tip_1", "") + looped.joint("j", "fixed", "coupler", "closing_tip_1")
    found = read_looped_urdf(write(looped.robot(*links, *joints.values(), one)))
    assert "link 'closing_tip_1' has no 'closing_tip_2' to close a loop with" in found.notes


def follower(tie):
    links, joints = looped.chain()
    return looped.robot(*links, *joints.values(), tie)


CONTROL = (
    '<ros2_control name="c" type="system"><joint name="phi1"><command_interface name="position"/>'
    '<param name="mimic">theta1</param><param name="multiplier">-2</param>'
    '<param name="offset">0.5</param></joint></ros2_control>'
)


@pytest.mark.parametrize("tie", [looped.mimic_plugin(), CONTROL], ids=["plugin", "ros2_control"])
def test_joints_follow_others(write, tie):
    mechanism = pj.load(write(follower(tie)), tool="rocker")
    gear = pj.JointLoop(joints=("theta1", "phi1"), ratio=-2, offset=0.5)
    assert mechanism.spec.loops == (gear,)
    assert mechanism.actuated == ("theta1", "phi2")
    assert mechanism.unread == ()


def test_a_plugin_and_a_mimic_that_agree_are_one(write, refusal):
    links, joints = looped.chain()
    own = '<mimic joint="theta1" multiplier="-2.0" offset="0.5"/>'
    joints["phi1"] = joints["phi1"].replace("</joint>", f"{own}</joint>")
    text = looped.robot(*links, *joints.values(), looped.mimic_plugin())
    assert len(read_looped_urdf(write(text)).loops) == 1
    assert refusal(text.replace('multiplier="-2.0"', 'multiplier="2"')) == (
        "joint 'phi1' follows otherwise by <mimic> than by plugin 'follow'"
    )
    assert "the joint 'phi3' does not exist; did you mean 'phi2' or 'phi1'?" in refusal(
        follower(looped.mimic_plugin(follower="phi3"))
    )


def test_a_fixed_joint_follows_nothing(write):
    links, joints = looped.chain()
    joints["tool"] = joints["tool"].replace("</joint>", '<mimic joint="theta1"/></joint>')
    mechanism = pj.load(write(looped.robot(*links, *joints.values())), tool=TOOL)
    assert mechanism.spec.loops == ()
    assert mechanism.notes[0] == "fixed, and follow no other joint: 'tool'"


TIES = {
    "gazebo": looped.with_element(looped.gazebo_joint()),
    "drake": looped.with_drake(looped.ball_constraint()),
    "loop_joint": looped.with_element(looped.loop_joint()),
    "closing": looped.with_element(looped.closing_frames()),
    "plugin": follower(looped.mimic_plugin()),
    "control": follower(CONTROL),
}


@pytest.mark.parametrize("text", TIES.values(), ids=TIES)
def test_what_is_converted_is_the_same_machine(write, tmp_path, text):
    path = write(text)
    motors = None if text in (TIES["plugin"], TIES["control"]) else ["theta1"]
    before = pj.load(path, actuated=motors, tool=TOOL)
    target, _ = pj.convert(path, tmp_path / "out.toml", actuated=motors, tool=TOOL)
    after = pj.load(target)
    assert after.unread == ()
    expected = before.home.jacobian().J_eq
    np.testing.assert_allclose(after.home.jacobian().J_eq, expected, atol=1e-12)


def control(params, attributes=""):
    joint = f'<joint name="phi1" {attributes}>{params}</joint>'
    return f'<ros2_control name="c" type="system">{joint}</ros2_control>'


BAD = {
    "weld": ("<drake:weld_constraint/>", "<drake:weld_constraint> is not read, and left out it"),
    "coupler": (
        "<drake:coupler_constraint/>",
        "<drake:coupler_constraint> is not read, and left out it would free a motion; gear the",
    ),
    "half a ball": (
        '<drake:ball_constraint><drake:ball_constraint_body_A name="crank"/>'
        "</drake:ball_constraint>",
        "<drake:ball_constraint> has no <drake:ball_constraint_p_AP>",
    ),
    "half a loop_joint": ('<loop_joint name="l" type="fixed"/>', "loop_joint 'l' has no <link1>"),
    "gearbox": (
        '<gazebo><joint name="g" type="gearbox"><parent>crank</parent><child>rocker</child>'
        "<axis/><axis2/></joint></gazebo>",
        "joint 'g' of <gazebo> is of type gearbox, which is not read there",
    ),
    "no link": (
        PIN.replace(">coupler<", ">copler<"),
        "joint 'c', <parent>: the frame 'copler' does not exist; did you",
    ),
    "base against the world": (
        '<gazebo><joint name="g" type="ball"><parent>world</parent><child>ground</child></joint>'
        "</gazebo>",
        "joint 'g' of <gazebo> joins link 'ground' to itself",
    ),
    "a leader misspelt": (
        control('<param name="mimc">theta1</param>'),
        "joint 'phi1' of <ros2_control> has the unknown param 'mimc'; did you mean 'mimic'?",
    ),
    "a factor misspelt": (
        control('<param name="mimic">theta1</param><param name="multplier">2</param>'),
        "joint 'phi1' of <ros2_control> has the unknown param 'multplier'; did you mean 'mul",
    ),
    "an offset misspelt": (
        control('<param name="Offset">1</param>', 'mimic="true"'),
        "joint 'phi1' of <ros2_control> has the unknown param 'Offset'; did you mean 'offset'?",
    ),
    "two leaders": (
        control('<param name="mimic">a</param><param name="mimic">b</param>'),
        "joint 'phi1' of <ros2_control> has 2 params 'mimic'",
    ),
    "neither true nor false": (
        control("", 'mimic="yes"'),
        "joint 'phi1' of <ros2_control>: `mimic` is 'yes'; it is true or false",
    ),
}


@pytest.mark.parametrize(("tie", "message"), BAD.values(), ids=BAD)
def test_what_is_refused(refusal, tie, message):
    text = RHOMBUS.format(tie).replace("<robot", '<robot xmlns:drake="http://drake.mit.edu"')
    assert refusal(text).startswith(message)


def test_a_follower_without_a_leader_is_told(write):
    """What a hardware has of its own is not."""
    own = '<param name="id">7</param><param name="ofset">1</param>'
    assert read_looped_urdf(write(follower(control(own)))).unread == ()
    said = "joint 'phi1' of <ros2_control> has mimic="
    alone = read_looped_urdf(write(follower(control("", 'mimic="true"'))))
    assert alone.unread == (f'{said}"true", and nothing says which joint it follows',)
    leader = '<param name="mimic">theta1</param>'
    assert read_looped_urdf(write(follower(control(leader, 'mimic="true"')))).unread == ()
    other = read_looped_urdf(write(follower(control(leader, 'mimic="false"'))))
    assert other.unread == (f'{said}"false", and follows another all the same',)
    near = read_looped_urdf(write(follower(control('<param name="mimic_joint">theta1</param>'))))
    assert near.unread == ("not read: <param> 'mimic_joint' in joint 'phi1' of <ros2_control>",)


@pytest.mark.parametrize("tie", ['<mimic joint="a"/></axis>', '</axis><drake:mimic joint="a"/>'])
def test_a_joint_of_gazebo_that_follows_another_is_refused(refusal, tie):
    text = RHOMBUS.format(PIN.replace("</axis>", tie))
    message = refusal(text.replace("<robot ", '<robot xmlns:drake="http://drake.mit.edu" ', 1))
    assert message.startswith("joint 'c' of <gazebo> closes a loop, and its <mimic> is not read")


@pytest.mark.parametrize(("number", "other"), [(1, 2), (2, 1)])
def test_a_closing_frame_without_its_other_is_told(write, number, other):
    lone = f'<link name="closing_x_{number}"/><joint name="f" type="fixed">'
    lone += f'<parent link="coupler"/><child link="closing_x_{number}"/></joint>'
    path = write(RHOMBUS.format(lone))
    told = f"link 'closing_x_{number}' has no 'closing_x_{other}' to close a loop with"
    assert told in read_looped_urdf(path).notes
    ours = path.with_suffix(".toml")
    ours.write_text(
        'urdf = "machine.urdf"\nactuated = ["a"]\ntool.frame = "coupler"\nposes.home.a = 0.0\n'
    )
    assert pj.load(ours).unread == (f"not read: {told}",)


def test_a_third_closing_frame_is_told(write):
    frames = "".join(
        f'<link name="closing_x_{k}"/><joint name="f{k}" type="fixed"><parent link="{link}"/>'
        f'<child link="closing_x_{k}"/><origin xyz="{xyz}"/></joint>'
        for k, link, xyz in (
            (1, "coupler", "3 1 0"),
            (2, "rocker", "-1 2 0"),
            (3, "crank", "0 0 0"),
        )
    )
    found = read_looped_urdf(write(RHOMBUS.format(frames)))
    told = "link 'closing_x_3' closes no loop: those of 'closing_x_1' and 'closing_x_2' do"
    assert (len(found.loops), told in found.notes) == (1, True)


def test_a_harmless_name_hides_no_tie(write):
    hold = DETACHABLE.format("box").replace(
        "gz-sim-detachable-joint-system", "libgazebo_ros_p3d.so"
    )
    found = read_looped_urdf(write(RHOMBUS.format(hold)))
    assert found.unread == ("not read: <plugin> 'libgazebo_ros_p3d.so' in <gazebo>",)
    names = '<gazebo><plugin filename="libgazebo_ros_p3d.so"><joint>a</joint></plugin></gazebo>'
    assert read_looped_urdf(write(RHOMBUS.format(names))).unread == ()


def test_of_motors_that_are_given_nothing_is_assumed(write):
    path = write(RHOMBUS.format(""))
    assert any("counts as a motor" in note for note in pj.load(path, tool="coupler").notes)
    given = pj.load(path, actuated=["a", "b", "d"], tool="coupler")
    assert not any("counts as a motor" in note for note in given.notes)


def test_only_joints_of_one_degree_of_freedom_are_offered_as_motors(write):
    floats = '<link name="z"/><joint name="float" type="floating"><parent link="coupler"/>'
    text = RHOMBUS.format(f'{PIN}{floats}<child link="z"/></joint>')
    with pytest.raises(pj.ModelFileError, match=r"of: a, b, d$"):
        pj.load(write(text), tool="coupler")
