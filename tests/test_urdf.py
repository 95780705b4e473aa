"""A URDF is read, checked and moved; what is accepted builds in Pinocchio without a word."""

import copy
import importlib.metadata
import math
import pickle
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from pmjac_pin.errors import ModelFileError, UnknownNameError
from pmjac_pin.files.urdf.dialects import read_cut_tree
from pmjac_pin.files.urdf.robot import Urdf, UrdfJoint, parse_urdf
from pmjac_pin.model.parameter import Move

AXIS = '<axis xyz="0 0 1"/>'
LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
INERTIA = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
CUT = "; cut the loop: remove one of them and declare it as [[loop]] in the model file"
NUMBERS = ("nan 0 0", "0 inf 0", "0 0 -inf", "0 0 1e309", "0 0", "0 0 0 0", "0 0 x", "", "0,0,0")
NUMBERS += ("1_0 0 0", "٣ 0 0", "0x1 0 0")


def joint(name="j", kind="revolute", parent="a", child="b", inside=AXIS + LIMIT):
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


def robot(*parts, links="ab"):
    return (
        '<robot name="r">'
        + "".join(f'<link name="{x}"/>' for x in links)
        + "".join(parts)
        + "</robot>"
    )


def with_inertial(inside):
    return robot(f'<link name="b"><inertial>{inside}</inertial></link>', joint(), links="a")


def chain(count, kind="fixed"):
    links = [f"l{i}" for i in range(count + 1)]
    joints = [joint(f"j{i}", kind, f"l{i}", f"l{i + 1}") for i in range(count)]
    return robot(*joints, links=links)


def refusal(text):
    with pytest.raises(ModelFileError) as caught:
        parse_urdf(text, "r.urdf")
    assert caught.value.path == "r.urdf"
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith("r.urdf: ")
    return message.removeprefix("r.urdf: ")


# Every part of the language: used whole, moved, and mutated.
SAMPLE = """<?xml version="1.0" encoding="utf-8"?>
<!-- a comment -->
<robot name="sample" version="1.0" xmlns:xacro="http://ros.org/wiki/xacro">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base">
    <visual name="plate"><origin xyz="0 0 0.5"/><geometry><box size="1 2 3"/></geometry></visual>
    <visual><geometry><mesh filename="file:///does/not/exist.stl"/></geometry></visual>
    <inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
  </link>
  <link name="upper">
    <visual name="rod">
      <geometry><cylinder radius="0.1" length="2"/></geometry><material name="red"/>
    </visual>
    <collision name="rod"><geometry><sphere radius="1"/></geometry></collision>
    <inertial>
      <origin xyz="0.1 0.2 0.3" rpy="0.4 0.5 0.6"/><mass value="2.5"/>
      <inertia ixx="0.3" ixy="0.01" ixz="0.02" iyy="0.4" iyz="0.03" izz="0.5"/>
    </inertial>
  </link>
  <link name="lower"><visual name="ball"><geometry><sphere radius="0.3"/></geometry></visual></link>
  <link name="tip"/><link name="slide"/><link name="plane"/><link name="free"/>
  <link name="wheel">
    <inertial><mass value="0.5"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <origin xyz="0.1 0.2 0.3" rpy="0 0 1.5707963267948966"/>
    <parent link="base"/><child link="upper"/>
    <axis xyz="0 0.6 0.8"/>
    <limit lower="-1" upper="2" effort="3" velocity="4"/>
    <dynamics damping="0.5" friction="0.25"/>
    <safety_controller k_velocity="1"/>
  </joint>
  <joint name="elbow" type="continuous">
    <parent link="upper"/><child link="lower"/><axis xyz="0 0 2"/><limit effort="1" velocity="2"/>
  </joint>
  <joint name="end" type="fixed">
    <origin xyz="0 0 1"/><parent link="lower"/><child link="tip"/>
  </joint>
  <joint name="rail" type="prismatic">
    <parent link="base"/><child link="slide"/>
    <limit lower="0" upper="1e308" effort="1" velocity="1"/>
  </joint>
  <joint name="plane" type="planar">
    <parent link="slide"/><child link="plane"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="free" type="floating"><parent link="base"/><child link="free"/></joint>
  <joint name="spin" type="fixed"><parent link="free"/><child link="wheel"/></joint>
  <gazebo reference="tip"/><transmission name="t"/>
</robot>
"""


JOINTS = ["shoulder", "elbow", "end", "rail", "plane", "free", "spin"]


def example_robots():
    package = importlib.metadata.distribution("example-robot-data")
    return Path(str(package.locate_file("cmeel.prefix/share/example-robot-data/robots")))


# --- the value ----------------------------------------------------------------------------


def test_what_a_urdf_holds():
    urdf = parse_urdf(SAMPLE, "sample.urdf")
    assert urdf.path == "sample.urdf"
    assert urdf.links == ("base", "upper", "lower", "tip", "slide", "plane", "free", "wheel")
    assert urdf.joints[0] == UrdfJoint("shoulder", "revolute", "base", "upper")
    assert [j.name for j in urdf.joints] == JOINTS
    assert urdf.visuals == ("plate", "rod", "ball")
    assert "comment" not in urdf.text
    assert "does/not/exist.stl" in urdf.text


def test_a_urdf_is_a_value():
    urdf = parse_urdf(SAMPLE, "sample.urdf")
    assert parse_urdf(urdf.text, urdf.path) == urdf
    assert pickle.loads(pickle.dumps(urdf)) == copy.deepcopy(urdf) == urdf
    assert hash(urdf) == hash(parse_urdf(SAMPLE, "sample.urdf"))
    with pytest.raises(AttributeError):
        urdf.text = ""


def test_read_cut_tree(tmp_path):
    path = tmp_path / "sample.urdf"
    path.write_text(SAMPLE, encoding="utf-8-sig")
    assert read_cut_tree(path).urdf == parse_urdf(SAMPLE, str(path))


def test_read_cut_tree_names_the_file(tmp_path):
    with pytest.raises(ModelFileError, match=r"nothing\.urdf: No such file"):
        read_cut_tree(tmp_path / "nothing.urdf")
    path = tmp_path / "huge.urdf"
    with path.open("wb") as file:
        file.truncate(20_000_001)
    with pytest.raises(ModelFileError, match=r"huge\.urdf: 20000001 bytes are too many"):
        read_cut_tree(path)


# --- the model that Pinocchio makes of it --------------------------------------------------


def assert_same_model(kinematic, plain):
    assert kinematic == plain
    assert list(kinematic.names) == list(plain.names)
    assert (kinematic.name, kinematic.nq, kinematic.nv) == (plain.name, plain.nq, plain.nv)
    for ours, theirs in zip(kinematic.jointPlacements, plain.jointPlacements, strict=True):
        assert ours == theirs
    for ours, theirs in zip(kinematic.inertias, plain.inertias, strict=True):
        assert ours == theirs


def test_kinematic_xml_gives_the_model_of_the_whole_urdf():
    kinematic = pin.buildModelFromXML(parse_urdf(SAMPLE, "").kinematic_xml())
    assert_same_model(kinematic, pin.buildModelFromXML(SAMPLE))
    assert (kinematic.njoints, kinematic.nq, kinematic.nv) == (6, 15, 12)
    assert kinematic.damping[kinematic.joints[kinematic.getJointId("shoulder")].idx_v] == 0.5


@pytest.mark.parametrize(
    "path", ["ur_description/urdf/ur5_robot.urdf", "go2_description/urdf/go2.urdf"]
)
def test_kinematic_xml_of_an_example_robot(path):
    path = example_robots() / path
    kinematic = pin.buildModelFromXML(read_cut_tree(path).urdf.kinematic_xml())
    assert_same_model(kinematic, pin.buildModelFromUrdf(str(path)))


def test_kinematic_xml_holds_nothing_else():
    root = ElementTree.fromstring(parse_urdf(SAMPLE, "").kinematic_xml())
    tags = {element.tag for element in root.iter()}
    inertial = {"inertial", "mass", "inertia"}
    moving = {"origin", "parent", "child", "axis", "limit", "dynamics"}
    assert tags == {"robot", "link", "joint"} | inertial | moving


def test_a_joint_may_share_its_name_with_a_link():
    urdf = parse_urdf(robot(joint("b")), "")
    assert pin.buildModelFromXML(urdf.kinematic_xml()).existJointName("b")


@pytest.mark.parametrize("name", ["root_joint", "a b", " ü 関節 ", "x&lt;&quot;&amp;'", "n" * 200])
def test_names_that_pinocchio_keeps(name, capfd):
    urdf = parse_urdf(
        robot(joint(name), joint("k", parent="b", child=name), links=["a", "b", name]), ""
    )
    model = pin.buildModelFromXML(urdf.kinematic_xml())
    assert urdf.joints[0].name in list(model.names)
    assert model.existBodyName(urdf.joints[0].name)
    assert capfd.readouterr().err == ""


def test_the_defaults_of_the_standard():
    urdf = parse_urdf(robot(joint(inside='<limit effort="1" velocity="2"/>')), "")
    model = pin.buildModelFromXML(urdf.kinematic_xml())
    assert model.joints[1].shortname() == "JointModelRX"
    assert (model.lowerPositionLimit[0], model.upperPositionLimit[0]) == (0.0, 0.0)
    assert model.jointPlacements[1] == pin.SE3.Identity()


def test_the_longest_chain_builds_on_a_small_stack():
    # Secondary threads have 512 kB on macOS; Pinocchio overflows them at 250 joints in a row.
    code = """if True:
        import sys, threading, pinocchio
        threading.stack_size(512 * 1024)
        def build():
            print(pinocchio.buildModelFromXML(sys.stdin.read()).nframes)
        thread = threading.Thread(target=build)
        thread.start()
        thread.join()"""
    done = subprocess.run(
        [sys.executable, "-c", code],
        input=parse_urdf(chain(150), "").kinematic_xml(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "302\n", "")


# --- XML ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<robot>\n  <link></robot>", "not well-formed XML: mismatched tag: line 2, column 10"),
        ("", "not well-formed XML: no element found: line 1, column 0"),
        ("robot", "not well-formed XML: syntax error: line 1, column 0"),
        ("<robot/><robot/>", "not well-formed XML: junk after document element: line 1, column 8"),
        (
            "<robot>\0</robot>",
            "not well-formed XML: not well-formed (invalid token): line 1, column 7",
        ),
        ("<robot>&x;</robot>", "not well-formed XML: undefined entity: line 1, column 7"),
    ],
)
def test_malformed_xml(text, message):
    assert refusal(text) == message


def test_a_lone_surrogate():
    assert refusal('<robot name="\ud800"/>').startswith("not well-formed XML: 'utf-8' codec can't")


@pytest.mark.parametrize(
    "declared",
    [
        "<!DOCTYPE robot>",
        '<!DOCTYPE robot SYSTEM "file:///etc/passwd">',
        '<!DOCTYPE robot [<!ENTITY x SYSTEM "file:///etc/passwd">]>',
        '<!DOCTYPE robot [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;">]>',
        '<!DOCTYPE robot [<!ENTITY % p SYSTEM "http://127.0.0.1/p">%p;]>',
    ],
)
def test_document_types_and_entities(declared):
    why = "it could open other files or grow without bound"
    assert refusal(declared + robot(joint())) == f"a <!DOCTYPE> is not read, since {why}; remove it"


def test_deep_nesting():
    text = robot("<gazebo>" * 100_000 + "</gazebo>" * 100_000)
    assert refusal(text) == "elements are nested more than 100 deep"


# --- the robot ------------------------------------------------------------------------------


@pytest.mark.parametrize("tag", ["loop", "constraint"])
def test_elements_that_pinocchio_would_ignore(tag):
    todo = "declare the loop as [[loop]] in the model file and remove it here"
    message = f"<{tag}> is not read, since Pinocchio would ignore it in silence; {todo}"
    assert refusal(robot(joint(), f"<{tag}/>")) == message


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<sdf/>", "the root element is <sdf>; a URDF's is <robot>"),
        ("<a>" + robot() + "</a>", "the root element is <a>; a URDF's is <robot>"),
        ('<robot xmlns="x"/>', "the root element is <{x}robot>; a URDF's is <robot>"),
        ("<robot/>", '<robot> has no name; write <robot name="...">'),
        ('<robot name="r" version="2.0"/>', "URDF version '2.0' is not read; 1.0, 1.1, 1.2 are"),
        (robot(links=""), "there is no <link>; a robot has at least one"),
        (robot(links=range(1001)), "1001 links are too many; at most 1000 are read"),
        (chain(151), "a chain of more than 150 joints is too long to be read"),
        (
            chain(34, "floating"),
            "the joints have 204 degrees of freedom; at most 200 are computed with"
            " (the memory needed grows with their cube)",
        ),
    ],
)
def test_the_robot(text, message):
    assert refusal(text) == message


def test_many_joints_are_refused_in_time():
    joints = [joint(f"j{i}", "fixed") for i in range(50_000)]
    few = "".join(joints[:10_000])
    assert refusal(robot(few)) == "10000 joints are too many; at most 2000 are read"
    many = "more than 100000 elements are too many to be read"
    assert refusal(robot("".join(joints))) == many


# --- names ----------------------------------------------------------------------------------


@pytest.mark.parametrize("tag", ["link", "joint"])
def test_missing_names(tag):
    text = robot(joint()).replace(f'<{tag} name="{"b" if tag == "link" else "j"}"', f"<{tag}")
    assert refusal(text) == f"<{tag}> number {2 if tag == 'link' else 1} has no name"
    for blank in ("", "  "):
        named = text.replace(f"<{tag}/>", f'<{tag} name="{blank}"/>')
        named = named.replace(f"<{tag} type", f'<{tag} name="{blank}" type')
        assert refusal(named).endswith("has no name")


def test_names_that_exist_twice():
    assert refusal(robot(joint(), links="abb")) == "two links are named 'b'; names must differ"
    joints = joint("j"), joint("j", parent="b", child="c")
    assert refusal(robot(*joints, links="abc")) == "two joints are named 'j'; names must differ"


def test_the_name_of_the_world():
    taken = "the name 'universe' is taken (Pinocchio calls the world so, and would mix them up)"
    for kind in ("revolute", "fixed"):
        text = robot(joint("universe", kind))
        assert refusal(text) == f"<joint> number 1: {taken}; choose another"
    text = robot(joint(parent="universe"), links=["universe", "b"])
    assert refusal(text) == f"<link> number 1: {taken}; choose another"


def test_odd_names():
    invisible = refusal(robot(joint("j&#10;k")))
    assert invisible == "<joint> number 1: the name 'j\\nk' holds an invisible character"
    assert refusal(robot(joint("j" * 201))) == (
        "<joint> number 1 has a name of 201 characters; at most 200 are read"
    )


# --- the tree -------------------------------------------------------------------------------


def test_a_link_with_two_parents():
    joints = joint("j"), joint("k", child="c"), joint("l", parent="b", child="c")
    assert (
        refusal(robot(*joints, links="abc"))
        == f"link 'c' is the child of two joints, 'k' and 'l'{CUT}"
    )
    assert (
        refusal(robot(joint("j"), joint("k")))
        == f"link 'b' is the child of two joints, 'j' and 'k'{CUT}"
    )


def test_cycles():
    assert refusal(robot(joint(child="a"), links="a")) == f"a cycle of joints: 'j'{CUT}"
    ring = joint("j"), joint("k", parent="b", child="c"), joint("l", parent="c", child="a")
    assert refusal(robot(*ring, links="abc")) == f"a cycle of joints: 'j', 'k', 'l'{CUT}"
    aside = joint("j"), joint("k", parent="c", child="d"), joint("l", parent="d", child="c")
    assert refusal(robot(*aside, links="abcd")) == f"a cycle of joints: 'l', 'k'{CUT}"


def test_several_roots():
    todo = "join them by joints, fixed ones if need be"
    assert refusal(robot(joint(), links="abc")) == f"2 links are no joint's child: 'a', 'c'; {todo}"
    assert refusal(robot(links="abcdefg")) == (
        f"7 links are no joint's child: 'a', 'b', 'c', 'd', 'e', ...; {todo}"
    )


# --- joints ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (joint(kind="revolut"), "has the unknown type 'revolut'; did you mean 'revolute'?"),
        (joint(kind="sphericl"), "has the unknown type 'sphericl'; did you mean 'spherical'?"),
        (
            joint(kind="ball"),
            "has the unknown type 'ball'; there are:"
            " revolute, continuous, prismatic, fixed, floating, planar, spherical",
        ),
        (
            joint().replace(' type="revolute"', ""),
            "has the unknown type ''; there are:"
            " revolute, continuous, prismatic, fixed, floating, planar, spherical, ball",
        ),
        (joint().replace('<parent link="a"/>', ""), 'has no parent; write <parent link="..."/>'),
        (
            joint().replace('<child link="b"/>', "<child/>"),
            'has no child; write <child link="..."/>',
        ),
        (joint(inside='<parent link="b"/>'), "has 2 <parent>; give one"),
        (joint(inside="<origin/><origin/>"), "has 2 <origin>; give one"),
        (joint(inside=AXIS + AXIS), "has 2 <axis>; give one"),
        (joint(inside=LIMIT + LIMIT), "has 2 <limit>; give one"),
        (
            joint(inside='<mimic joint="k"/>'),
            ": <mimic> is not supported"
            " (Pinocchio would ignore it and let the joint move freely); remove it",
        ),
        (
            joint(inside='<origin quat_xyzw="0 0 0 1"/>'),
            ", <origin>: `quat_xyzw` is not read; give `rpy`",
        ),
        (
            joint(inside='<origin xyz="1e10 0 0"/>'),
            ", <origin>: `xyz` is '1e10 0 0'; numbers of magnitude 1e+09 or less are read",
        ),
        (joint(inside="<axis/>" + LIMIT), ", <axis> has no `xyz`"),
        (
            joint(inside='<axis xyz="0 0 0"/>' + LIMIT),
            ", <axis>: `xyz` is '0.0 0.0 0.0', of length zero;"
            " a joint that moves needs a direction",
        ),
        (
            joint(inside='<axis xyz="1e-200 0 0"/>' + LIMIT),
            ", <axis>: `xyz` is '1e-200 0.0 0.0', of length zero;"
            " a joint that moves needs a direction",
        ),
        (
            joint(kind="planar", inside=""),
            ", <axis>: `xyz` is '1.0 0.0 0.0', but Pinocchio moves a planar joint in x and y"
            ' whatever its axis; write <axis xyz="0 0 1"/> and turn the origin',
        ),
    ],
)
def test_joints(text, message):
    where = "joint 'j'" + ("" if message[0] in ",:" else " ")
    assert refusal(robot(text)) == where + message


def test_links_that_do_not_exist():
    links = ["base", "tip"]
    assert refusal(robot(joint(parent="bse", child="tip"), links=links)) == (
        "joint 'j': the parent link 'bse' does not exist; did you mean 'base'?"
    )
    message = refusal(robot(joint(parent="base", child="x" * 9999), links=links))
    assert message.startswith("joint 'j': the child link 'xxx")
    assert message.endswith("xxx' does not exist; there are: base, tip")
    assert len(message) < 300


@pytest.mark.parametrize("numbers", NUMBERS)
@pytest.mark.parametrize("attribute", ["xyz", "rpy"])
def test_origins_are_finite_numbers(attribute, numbers):
    origin = f'<origin {attribute}="{numbers}"/>'
    message = f"<origin>: `{attribute}` is {numbers!r}, not 3 finite numbers"
    assert refusal(robot(joint(inside=origin + AXIS + LIMIT))) == f"joint 'j', {message}"
    inertial = with_inertial(origin + '<mass value="1"/>' + INERTIA)
    assert refusal(inertial) == f"link 'b', <inertial>, {message}"
    visual = f'<link name="c"><visual>{origin}</visual></link>'
    assert refusal(robot(visual, joint())) == f"link 'c', <visual>, {message}"


@pytest.mark.parametrize("numbers", NUMBERS)
def test_axes_are_finite_numbers(numbers):
    message = f"joint 'j', <axis>: `xyz` is {numbers!r}, not 3 finite numbers"
    assert refusal(robot(joint(inside=f'<axis xyz="{numbers}"/>{LIMIT}'))) == message


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_limits_are_required(kind):
    message = f"joint 'j' is {kind} and has no <limit>; write {LIMIT}"
    assert refusal(robot(joint(kind=kind, inside=AXIS))) == message
    parse_urdf(robot(joint(kind="continuous", inside=AXIS)), "")


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "continuous"])
@pytest.mark.parametrize(
    ("limit", "message"),
    [
        ('effort="1"', " has no `velocity`"),
        ('velocity="1"', " has no `effort`"),
        ('effort="-1" velocity="1"', ": `effort` is -1; it must not be negative"),
        ('effort="1" velocity="-1"', ": `velocity` is -1; it must not be negative"),
        ('effort="inf" velocity="1"', ": `effort` is 'inf', not a finite number"),
        ('effort="1" velocity="1 2"', ": `velocity` is '1 2', not a finite number"),
    ],
)
def test_limits(kind, limit, message):
    text = robot(joint(kind=kind, inside=f"{AXIS}<limit {limit}/>"))
    assert refusal(text) == "joint 'j', <limit>" + message


@pytest.mark.parametrize(
    ("limit", "message"),
    [
        ('lower="2" upper="1"', "`lower` is 2 and `upper` is 1"),
        ('lower="2"', "`lower` is 2 and `upper` is 0"),
        ('upper="-2"', "`lower` is 0 and `upper` is -2"),
    ],
)
def test_limits_in_order(limit, message):
    text = robot(joint(inside=f'{AXIS}<limit {limit} effort="1" velocity="1"/>'))
    end = " (0 when left out); lower must not exceed upper"
    assert refusal(text) == f"joint 'j', <limit>: {message}{end}"


@pytest.mark.parametrize("attribute", ["lower", "upper"])
def test_limits_are_finite_numbers(attribute):
    text = robot(joint(inside=f'{AXIS}<limit effort="1" velocity="1" {attribute}="nan"/>'))
    assert refusal(text) == f"joint 'j', <limit>: `{attribute}` is 'nan', not a finite number"


@pytest.mark.parametrize("attribute", ["damping", "friction"])
def test_dynamics(attribute):
    text = robot(joint(inside=f'{AXIS}{LIMIT}<dynamics {attribute}="-1"/>'))
    assert refusal(text) == f"joint 'j', <dynamics>: `{attribute}` is -1; it must not be negative"
    text = robot(joint(inside=f'{AXIS}{LIMIT}<dynamics {attribute}="x"/>'))
    assert refusal(text) == f"joint 'j', <dynamics>: `{attribute}` is 'x', not a finite number"


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        (INERTIA, " has no <mass>; give both <mass> and <inertia>"),
        ('<mass value="1"/>', " has no <inertia>; give both <mass> and <inertia>"),
        ("<mass/>" + INERTIA, ", <mass> has no `value`"),
        ('<mass value="-1"/>' + INERTIA, ", <mass>: `value` is -1; it must not be negative"),
        ('<mass value="nan"/>' + INERTIA, ", <mass>: `value` is 'nan', not a finite number"),
        (
            '<mass value="1e10"/>' + INERTIA,
            ", <mass>: `value` is '1e10'; numbers of magnitude 1e+09 or less are read",
        ),
        ('<mass value="1"/><inertia ixx="1"/>', ", <inertia> has no `ixy`"),
        (
            '<mass value="1"/>' + INERTIA.replace('"1"', '"inf"'),
            ", <inertia>: `ixx` is 'inf', not a finite number",
        ),
    ],
)
def test_inertials(inside, message):
    assert refusal(with_inertial(inside)) == "link 'b', <inertial>" + message


def test_two_inertials():
    text = robot('<link name="b"><inertial/><inertial/></link>', joint(), links="a")
    assert refusal(text) == "link 'b' has 2 <inertial>; give one"


# --- moves ----------------------------------------------------------------------------------


def attributes(urdf, path):
    return ElementTree.fromstring(urdf.text).find(path).attrib


def moved(*moves, text=SAMPLE):
    return parse_urdf(text, "r.urdf").moved(moves)


def test_a_joint_is_moved():
    urdf = moved((Move(joint="shoulder", xyz=(1.0, 0.0, -2.0), rpy=(0.0, 3.0, 0.0)), 0.1))
    origin = attributes(urdf, "joint[@name='shoulder']/origin")
    assert origin["xyz"] == f"{0.1 + 0.1!r} 0.2 {0.3 - 2 * 0.1!r}"
    assert origin["rpy"] == f"0.0 {3 * 0.1!r} {math.pi / 2!r}"
    model = pin.buildModelFromXML(urdf.kinematic_xml())
    placement = model.jointPlacements[model.getJointId("shoulder")]
    np.testing.assert_array_equal(placement.translation, [0.1 + 0.1, 0.2, 0.3 - 2 * 0.1])


def test_an_origin_is_made_where_there_is_none():
    urdf = moved((Move(joint="elbow", rpy=(0.0, 0.0, 1.0)), 0.5))
    assert attributes(urdf, "joint[@name='elbow']/origin") == {"rpy": "0.0 0.0 0.5"}
    urdf = moved((Move(joint="end", rpy=(0.0, 0.0, 1.0)), 0.5))
    assert attributes(urdf, "joint[@name='end']/origin") == {"xyz": "0 0 1", "rpy": "0.0 0.0 0.5"}


def test_a_visual_is_moved():
    urdf = moved((Move(visual="plate", xyz=(0.0, 0.0, 0.5)), 0.5))
    assert attributes(urdf, "link/visual[@name='plate']/origin") == {"xyz": "0.0 0.0 0.75"}
    urdf = moved((Move(visual="rod", xyz=(0.0, 0.0, 0.5)), 0.5))
    assert attributes(urdf, "link/visual[@name='rod']/origin") == {"xyz": "0.0 0.0 0.25"}
    assert urdf.kinematic_xml() == parse_urdf(SAMPLE, "").kinematic_xml()


def test_shapes_are_moved():
    urdf = moved(
        (Move(visual="plate", size=(0.0, 1.0, -2.0)), 0.5),
        (Move(visual="rod", length=1.0, radius=0.5), 0.5),
        (Move(visual="ball", radius=-0.5), 0.5),
    )
    assert attributes(urdf, ".//box") == {"size": "1.0 2.5 2.0"}
    assert attributes(urdf, ".//cylinder") == {"radius": repr(0.1 + 0.25), "length": "2.5"}
    assert attributes(urdf, ".//visual[@name='ball']//sphere") == {"radius": repr(0.3 - 0.25)}
    assert attributes(urdf, ".//collision//sphere") == {"radius": "1"}


def test_moves_add_up():
    urdf = moved(
        (Move(joint="end", xyz=(0.0, 0.0, 1.0)), 0.25),
        (Move(joint="end", xyz=(1.0, 0.0, -3.0)), 0.5),
        (Move(visual="rod", length=-1.0), 2.5),
        (Move(visual="rod", length=1.0), 1.0),
    )
    assert attributes(urdf, "joint[@name='end']/origin") == {"xyz": "0.5 0.0 -0.25"}
    assert attributes(urdf, ".//cylinder")["length"] == "0.5"


@pytest.mark.parametrize("delta", [0.0, -0.0])
def test_at_the_defaults_nothing_changes(delta):
    urdf = parse_urdf(SAMPLE, "r.urdf")
    moves = Move(joint="elbow", rpy=(1.0, 0.0, 0.0)), Move(visual="rod", length=1.0)
    assert urdf.moved((move, delta) for move in moves) == urdf
    assert urdf.moved([]) == urdf


def test_a_move_that_is_zero_leaves_its_numbers():
    urdf = moved(
        (Move(joint="shoulder", xyz=(1.0, 0.0, 0.0)), 0.0), (Move(visual="rod", length=1.0), 1.0)
    )
    origin = attributes(urdf, "joint[@name='shoulder']/origin")
    assert origin == {"xyz": "0.1 0.2 0.3", "rpy": "0 0 1.5707963267948966"}


@given(st.floats(-1e6, 1e6), st.floats(-1e3, 1e3), st.floats(-1e3, 1e3))
@settings(deadline=None, derandomize=True, max_examples=50)
def test_moves_lose_nothing(before, coefficient, delta):
    text = robot(joint(inside=f'<origin xyz="{before!r} 0 0"/>{AXIS}{LIMIT}'))
    move = Move(joint="j", xyz=(coefficient, 1.0, 0.0))
    after = attributes(moved((move, delta), text=text), "joint/origin")["xyz"].split()
    assert [float(number) for number in after] == [before + coefficient * delta, delta, 0.0]


@pytest.mark.parametrize("delta", [0.0, 1.0])
def test_moves_name_what_exists(delta):
    with pytest.raises(UnknownNameError, match=r"^unknown joint 'elbo'; did you mean 'elbow'\?$"):
        moved((Move(joint="elbo", xyz=(1.0, 0.0, 0.0)), delta))
    with pytest.raises(UnknownNameError, match=r"^unknown visual 'rd'; did you mean 'rod'\?$"):
        moved((Move(visual="rd", length=1.0), delta))


@pytest.mark.parametrize("delta", [0.0, 1.0])
@pytest.mark.parametrize(
    ("move", "message"),
    [
        (
            Move(visual="plate", radius=1.0),
            "visual 'plate' is a <box> and has no `radius` to move; it has: size",
        ),
        (
            Move(visual="ball", length=1.0),
            "visual 'ball' is a <sphere> and has no `length` to move; it has: radius",
        ),
        (
            Move(visual="rod", size=(1.0, 0.0, 0.0)),
            "visual 'rod' is a <cylinder> and has no `size` to move; it has: radius, length",
        ),
        (
            Move(visual="mesh", length=1.0),
            "visual 'mesh' is a <mesh> and has no `length` to move",
        ),
        (Move(visual="bare", length=1.0), "visual 'bare' needs a <geometry> with one shape"),
        (
            Move(visual="twin", xyz=(1.0, 0.0, 0.0)),
            "2 visuals are named 'twin'; one that a parameter moves needs its own name",
        ),
    ],
)
def test_moves_that_do_not_fit(move, message, delta):
    more = '<visual name="mesh"><geometry><mesh filename="m.stl"/></geometry></visual>'
    more += '<visual name="bare"/><visual name="twin"/><visual name="twin"/>'
    text = SAMPLE.replace('<link name="tip"/>', f'<link name="tip">{more}</link>')
    with pytest.raises(ModelFileError) as caught:
        moved((move, delta), text=text)
    assert str(caught.value) == f"r.urdf: {message}"


@pytest.mark.parametrize(
    ("move", "delta", "message"),
    [
        (
            Move(visual="rod", length=-1.0),
            2.0,
            "visual 'rod', <cylinder>: `length` would become 0.0",
        ),
        (
            Move(visual="ball", radius=1.0),
            -1.3,
            "visual 'ball', <sphere>: `radius` would become -1.0",
        ),
        (
            Move(visual="plate", size=(-1.0, 0.0, 0.0)),
            4.0,
            "visual 'plate', <box>: `size` would become -3.0 2.0 3.0",
        ),
    ],
)
def test_sizes_stay_positive(move, delta, message):
    with pytest.raises(ModelFileError) as caught:
        moved((move, delta))
    assert str(caught.value) == f"r.urdf: {message}; it must be positive"


@pytest.mark.parametrize(
    ("delta", "message"),
    [
        (math.nan, "`xyz` is 'nan nan nan', not 3 finite numbers"),
        (1e300, "`xyz` is '0.0 0.0 1e+300'; numbers of magnitude 1e+09 or less are read"),
    ],
)
def test_moves_stay_readable(delta, message):
    with pytest.raises(ModelFileError) as caught:
        moved((Move(joint="end", xyz=(0.0, 0.0, 1.0)), delta))
    assert str(caught.value) == f"r.urdf: joint 'end', <origin>: {message}"


# --- whatever is accepted builds ------------------------------------------------------------

FUZZ = settings(
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)

WEIRD = ["", " ", "0", "-0", "1", "-1", "2.5", "1e308", "-1e308", "1e309", "1e-320", "nan", "inf"]
WEIRD += ["1e9", "-1e9", "1e200", "1e-200", "0 0 0", "0 0 1", "1e-7 0 0", "1e9 1e9 1e9", "1 2", "x"]
WEIRD += ["5e-324", "1e-320 0 0", "1 0 0 0", " 1  2 3 ", "1&#9;2&#10;3", "1_0", "٣", "0x1", "-.5"]
WEIRD += ["universe", "base", "tip", "shoulder", "revolute", "continuous", "fixed", "floating"]
WEIRD += ["planar", "prismatic", "\u202e", "\n", "n" * 300, "</link>", "&amp;", "'\"<>&", "1.2"]

TAGS = [
    "link",
    "joint",
    "origin",
    "axis",
    "limit",
    "mass",
    "inertia",
    "inertial",
    "parent",
    "mimic",
]
ACTIONS = ["drop", "weird", "swap", "double", "remove", "rename", "adopt", "add"]


def assert_refused_or_builds(text, capfd):
    try:
        urdf = parse_urdf(text, "r.urdf")
    except ModelFileError as error:
        assert str(error).startswith("r.urdf: ")
        assert "\n" not in str(error)
        return
    assert isinstance(urdf, Urdf)
    model = pin.buildModelFromXML(urdf.kinematic_xml())
    moving = {joint.name for joint in urdf.joints if joint.type != "fixed"}
    assert len(moving) == model.njoints - 1
    assert moving == set(model.names) - {"universe"}
    assert all(model.existBodyName(link) for link in urdf.links)
    assert all(np.isfinite(inertia.toDynamicParameters()).all() for inertia in model.inertias)
    assert_each_joint_moves(model)
    assert capfd.readouterr() == ("", "")


def assert_each_joint_moves(model):
    data = model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    assert np.isfinite(data.J).all()
    # The column is a unit axis and its moment, which is large where an origin is far off.
    for index in range(1, model.njoints):
        columns = pin.getJointJacobian(model, data, index, pin.LOCAL)
        start = model.joints[index].idx_v
        own = np.reshape(columns, (6, model.nv))[:, start : start + model.joints[index].nv]
        np.testing.assert_allclose(np.linalg.norm(own, axis=0), 1.0, rtol=1e-12)


@st.composite
def mutated_sample(draw):
    root = ElementTree.fromstring(SAMPLE)
    for _ in range(draw(st.integers(1, 4))):
        mutate(draw, root)
    text = ElementTree.tostring(root, encoding="unicode")
    if draw(st.integers(0, 9)) == 0:
        text = text[: draw(st.integers(0, len(text)))]
    return text


def mutate(draw, root):
    elements = [element for element in root.iter() if element.tag not in ("gazebo", "transmission")]
    element, other = draw(st.sampled_from(elements)), draw(st.sampled_from(elements))
    action = draw(st.sampled_from(ACTIONS))
    names = sorted(element.attrib)
    if action == "rename":
        element.tag = draw(st.sampled_from(TAGS))
    elif action == "add":
        ElementTree.SubElement(element, draw(st.sampled_from(TAGS)), other.attrib)
    elif action == "double" and len(element):
        child = draw(st.sampled_from(list(element)))
        element.append(copy.deepcopy(child))
    elif action == "remove" and len(element):
        element.remove(draw(st.sampled_from(list(element))))
    elif action == "adopt":
        element.append(copy.deepcopy(other))
    elif names and (name := draw(st.sampled_from(names))):
        if action == "drop":
            del element.attrib[name]
        elif action == "weird":
            element.set(name, draw(st.sampled_from(WEIRD)))
        elif action == "swap" and name in other.attrib:
            element.attrib[name], other.attrib[name] = other.attrib[name], element.attrib[name]


@pytest.mark.slow
@given(mutated_sample())
@settings(FUZZ, max_examples=1000)
def test_a_mutated_urdf_is_refused_or_builds(capfd, text):
    assert_refused_or_builds(text, capfd)


PIECES = [
    *robot(joint()).replace("><", ">\0<").split("\0"),
    SAMPLE,
    "<link name='c'/>",
    "<!--",
    "-->",
]
PIECES += [
    "<![CDATA[",
    "]]>",
    "<?x?>",
    "<!DOCTYPE x>",
    "&lt;",
    "&#0;",
    "\ufeff",
    "\0",
    "<",
    ">",
    "\ud800",
]


@given(st.one_of(st.text(), st.lists(st.sampled_from(PIECES)).map("".join)))
@settings(FUZZ, max_examples=200)
@example(SAMPLE)
@example(robot(joint()))
def test_any_text_is_refused_or_builds(capfd, text):
    assert_refused_or_builds(text, capfd)


@given(st.binary())
@settings(FUZZ, max_examples=100)
def test_any_bytes_are_refused(tmp_path, content):
    path = tmp_path / "r.urdf"
    path.write_bytes(content)
    with pytest.raises(ModelFileError):
        read_cut_tree(path)
