"""No word of a file is passed over in silence: misspelt ones are errors, unknown ones are told."""

from __future__ import annotations

import importlib.metadata
import re
from pathlib import Path
from xml.etree.ElementTree import SubElement, fromstring, tostring

import looped
import mjcf_models
import pytest
from misspellings import misspelt, places, slips
from peer_models import FOLDER

import pmjac_pin as pj
from pmjac_pin.files.mjcf.reader import read_mjcf
from pmjac_pin.files.sdf.reader import read_sdf
from pmjac_pin.files.source import read_source
from pmjac_pin.files.urdf.closure_yaml import read_closure_yaml
from pmjac_pin.files.urdf.extended_urdf import closure_yaml_beside, read_extended_urdf
from pmjac_pin.files.urdf.looped_urdf import read_looped_urdf
from pmjac_pin.files.vocabulary import Vocabulary, spelt

READERS = {".urdf": read_looped_urdf, ".sdf": read_sdf, ".xml": read_mjcf}

DRAKE = 'xmlns:drake="http://drake.mit.edu"'
GEARS = looped.robot(
    *(looped.link(name) for name in ("palm", "a", "b")),
    looped.joint("left", "revolute", "palm", "a"),
    looped.joint(
        "right", "revolute", "palm", "b", (1, 0, 0),
        inside='<mimic joint="left" multiplier="-2" offset="0.5"/>',
    ),
)  # fmt: skip
SDF = """
<sdf version="1.11" xmlns:drake="http://drake.mit.edu">
  <model name="m" placement_frame="a" canonical_link="a"><pose>0 0 1 0 0 0.5</pose>
    <link name="a"><pose>1 0 0 0.1 0.2 0.3</pose>
      <inertial><mass>2</mass><pose>0 0 1 0 0 0</pose>
        <inertia><ixx>2</ixx><ixy>0.1</ixy><ixz>0.2</ixz><iyy>3</iyy><iyz>0.3</iyz><izz>4</izz>
        </inertia></inertial></link>
    <link name="b"><pose relative_to="a" degrees="true">0 2 0 0 0 30</pose></link>
    <link name="c"><pose rotation_format="quat_xyzw">1 2 3 0 0 0.6 0.8</pose></link>
    <frame name="f" attached_to="b"><pose>0 0 0.5 0 0 0</pose></frame>
    <joint name="i" type="revolute"><parent>a</parent><child>b</child><pose>0.1 0 0 0 0 1</pose>
      <axis><xyz expressed_in="a">1 2 3</xyz>
        <limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
    <joint name="j" type="revolute"><parent>b</parent><child>c</child>
      <axis><xyz>0 0 1</xyz>
        <mimic joint="i" axis="axis"><multiplier>2</multiplier><offset>0.1</offset>
          <reference>0.3</reference></mimic></axis></joint>
    <drake:ball_constraint>
      <drake:ball_constraint_body_A>a</drake:ball_constraint_body_A>
      <drake:ball_constraint_body_B>c</drake:ball_constraint_body_B>
      <drake:ball_constraint_p_AP>3 1 0</drake:ball_constraint_p_AP>
      <drake:ball_constraint_p_BQ>-1 2 0</drake:ball_constraint_p_BQ>
    </drake:ball_constraint>
  </model>
</sdf>"""
OLD_SDF = """
<sdf version="1.6"><model name="m"><link name="a"/><link name="b"/><link name="c"/>
  <joint name="i" type="universal"><parent>a</parent><child>b</child>
    <axis><xyz>1 0 0</xyz><use_parent_model_frame>1</use_parent_model_frame></axis>
    <axis2><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis2></joint>
  <joint name="one" type="revolute"><parent>a</parent><child>c</child><axis><xyz>0 0 1</xyz></axis>
  </joint></model></sdf>"""
MJCF = mjcf_models.mjcf(
    '<body name="a" pos="1 0 0" quat="1 1 0 0" childclass="main">'
    '<inertial mass="2" pos="0 0 1" diaginertia="1 2 3" euler="0 0 20"/>'
    '<joint name="j" type="hinge" axis="0 1 0" pos="0 0 1" range="-10 10" ref="3" class="main"/>'
    '<frame pos="0 1 0" axisangle="0 0 1 20"><geom type="box" size=".1 .2 .3" mass="3"/></frame>'
    '<body name="b" zaxis="0 1 1"><freejoint name="no"/></body></body>'.replace(
        '<freejoint name="no"/>', '<geom type="capsule" fromto="0 0 0 1 0 0" size=".1"/>'
    )
    + '<body name="c"><joint name="k" limited="false"/><geom size=".2" density="200"/>'
    '<site name="s" xyaxes="1 0 0 0 1 0"/></body>',
    '<connect body1="b" body2="c" anchor="0 0 1"/>'
    '<weld body1="a" body2="c" relpose="0 0 0 1 0 0 0" torquescale="1"/>'
    '<joint joint1="j" joint2="k" polycoef="0 2"/>',
    '<compiler angle="radian" eulerseq="zyx" autolimits="true"/>'
    '<default><joint axis="1 0 0"/><geom density="500"/></default>',
    '<actuator><motor joint="k"/></actuator><keyframe><key name="home" qpos="0.1 0.2"/></keyframe>',
)
TEXTS = {
    "loop": (looped.with_element(looped.loop_element(), 'independent="true"'), ".urdf"),
    "constraint": (looped.with_element(looped.constraint_element()), ".urdf"),
    "gears": (GEARS, ".urdf"),
    "gazebo": (looped.with_element(looped.gazebo_joint()), ".urdf"),
    "loop_joint": (looped.with_element(looped.loop_joint()), ".urdf"),
    "Drake's ball": (looped.with_drake(looped.ball_constraint()), ".urdf"),
    "mimic plugin": (looped.with_element(looped.mimic_plugin()), ".urdf"),
    "sdf": (SDF, ".sdf"),
    "old sdf": (OLD_SDF, ".sdf"),
    "mjcf": (MJCF, ".xml"),
}


@pytest.fixture
def read(tmp_path):
    def read(text, suffix):
        path = tmp_path / f"machine{suffix}"
        path.write_text(text)
        return READERS[suffix](path)

    return read


def machine(model):
    """What a reader made of a file: names, notes and pictures aside."""
    kinematics = model.urdf.kinematic_xml()
    return kinematics, model.loops, model.spherical, dict(model.home), model.actuated


def silent(text, read, suffix):
    """The misspellings that change the machine without an error; what was read else is the same."""
    before, found = machine(read(text, suffix)), []
    for what, wrong in misspelt(text):
        try:
            after = machine(read(wrong, suffix))
        except pj.PmjacError:
            continue
        if after != before:
            found.append(what)
    return found


@pytest.mark.parametrize(("text", "suffix"), TEXTS.values(), ids=TEXTS)
def test_no_misspelling_changes_the_machine_in_silence(read, text, suffix):
    assert silent(text, read, suffix) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", mjcf_models.MODELS)
def test_no_misspelling_in_mjcf_does(read, name):
    assert silent(mjcf_models.MODELS[name], read, ".xml") == []


def published():
    robots = "cmeel.prefix/share/example-robot-data/robots"
    folder = Path(str(importlib.metadata.distribution("example-robot-data").locate_file(robots)))
    return [*sorted(folder.rglob("*.urdf")), *sorted(folder.rglob("*.sdf"))]


# Larger ones have the same words.
PEERS = [
    path
    for path in (*sorted(FOLDER.rglob("*.urdf")), *sorted(FOLDER.rglob("*.xml")))
    if path.stat().st_size < 40_000
]


@pytest.mark.slow
@pytest.mark.parametrize("name", PEERS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_no_misspelling_in_a_published_robot_does(tmp_path, name):
    beside = closure_yaml_beside(name)
    if beside is not None:
        (tmp_path / "robot.yaml").write_text(beside.read_text())
    readers = READERS if beside is None else {".urdf": read_extended_urdf}

    def read(text, suffix):
        path = tmp_path / f"robot{suffix}"
        path.write_text(text)
        return readers[suffix](path)

    assert silent(name.read_text(), read, name.suffix) == []


@pytest.mark.parametrize("path", published(), ids=lambda path: path.stem)
def test_the_words_of_published_robots_are_known(path):
    """But for what may tie bodies together, and one <origin> that URDF does not have."""
    told = {
        "libgazebo_underactuated_finger.so", "libcassie_plugin.so", "slider:", "gap_joint",
        "passive_joint", "more kinds", "<origin> in link 'gripper_frame_link'",
    }  # fmt: skip
    try:
        found = READERS[path.suffix](path)
    except pj.ModelFileError as error:
        assert re.search("there is no <link>|'(index_q1|Z_propeller)' does not exist", str(error))
    else:
        assert all(any(word in note for word in told) for note in found.unread)


@pytest.mark.parametrize(("text", "suffix"), TEXTS.values(), ids=TEXTS)
def test_what_is_not_known_is_told_wherever_it_stands(read, text, suffix):
    """An element or an attribute that no format has, in every kind of place."""
    root = fromstring(text)
    for number, (_, place) in enumerate(places(root)):
        wrong = fromstring(text)
        element = next(found for k, (found, _) in enumerate(places(wrong)) if k == number)
        SubElement(element, "quux", zork="1")
        element.set("blurb", "1")
        try:
            unread = read(tostring(wrong, encoding="unicode"), suffix).unread
        except pj.ModelFileError as error:
            assert re.search("quux|blurb", str(error)), place
            continue
        assert any("<quux> in " in note for note in unread), place
        assert any("'blurb' of " in note for note in unread), place


TIES = ("spring", "tendon", "{http://drake.mit.edu}linear_bushing_rpy", "plugin")


@pytest.mark.parametrize("tie", TIES)
@pytest.mark.parametrize("suffix", [".urdf", ".sdf"])
def test_check_warns_of_what_might_tie_bodies(tmp_path, suffix, tie):
    root = fromstring(looped.two_parents() if suffix == ".urdf" else SDF)
    SubElement(root if suffix == ".urdf" else root[0], tie)
    path = tmp_path / f"machine{suffix}"
    path.write_text(tostring(root, encoding="unicode"))
    motor, tool = ("theta1", looped.TOOL) if suffix == ".urdf" else ("i", "b")
    source = read_source(path, [motor], tool)
    assert source.all_notes[0].startswith(f"not read: <{spelt(tie)}> in ")
    found = [f for f in pj.check(path, actuated=[motor], tool=tool).findings if f.code == "unread"]
    assert [finding.severity for finding in found] == ["warning"]
    assert spelt(tie) in found[0].message
    assert "another" in found[0].advice


def test_check_warns_where_the_home_pose_does_not_assemble(tmp_path):
    far = looped.loop_element().replace('xyz="', 'xyz="9', 1)
    path = tmp_path / "machine.urdf"
    path.write_text(looped.with_element(f"{far}<spring/>"))
    diagnosis = pj.check(path, actuated=["theta1"], tool=looped.TOOL)
    assert diagnosis.failure is not None
    assert "unread" in [finding.code for finding in diagnosis.findings]


def test_a_model_files_urdf_is_held_against_the_words_too(tmp_path):
    links, joints = looped.chain()
    model = 'urdf = "m.urdf"\nactuated = ["theta1", "phi1", "phi2"]\ntool.frame = "middle"\n'
    (tmp_path / "m.toml").write_text(f"{model}[poses.home]\n")
    path = tmp_path / "m.urdf"
    path.write_text(looped.robot(*links, *joints.values(), "<spring/>"))
    assert pj.load(tmp_path / "m.toml").notes == ("not read: <spring> in robot 'four_bar'",)
    path.write_text(looped.robot(*links, *joints.values()).replace("<axis", "<axs"))
    with pytest.raises(pj.ModelFileError, match="unknown <axs>; did you mean 'axis'"):
        pj.load(tmp_path / "m.toml")
    for tie in (looped.gazebo_joint(), looped.loop_joint(), looped.ball_constraint()):
        path.write_text(looped.with_drake(tie))
        with pytest.raises(pj.ModelFileError, match="declare the loop as"):
            pj.load(tmp_path / "m.toml")


def test_frames_that_close_nothing_in_a_model_file_are_told(tmp_path):
    (tmp_path / "m.urdf").write_text(looped.with_element(looped.closing_frames()))
    path = tmp_path / "m.toml"
    model = 'urdf = "m.urdf"\nactuated = ["theta1"]\ntool.frame = "middle"\n[poses.home]\n'
    path.write_text(model.replace('["theta1"]', '["theta1", "phi1", "phi2"]'))
    pair = "'closing_tip_1' and 'closing_tip_2'"
    assert pj.load(path).unread == (f"not read: the frames {pair} are in no [[loop]]",)
    loop = '[[loop]]\nkind = "point"\nframes = ["closing_tip_1", "closing_tip_2"]\n'
    path.write_text(f"{model}{loop}")
    assert pj.load(path).unread == ()


def test_xacro_is_to_be_expanded(read):
    text = looped.two_parents().replace("<robot", '<robot xmlns:xacro="http://ros.org/wiki/xacro"')
    with pytest.raises(pj.ModelFileError, match="<xacro:leg> is xacro, which is not read; expand"):
        read(text.replace("</robot>", "<xacro:leg/></robot>"), ".urdf")


def test_what_is_told_is_bounded():
    words = Vocabulary("robot : link")
    strange = "".join(f"<zork{k}/>" for k in range(1000))
    found = words.unread(fromstring(f"<robot>{strange}</robot>"))
    assert (len(found), found[-1]) == (11, "not read: 990 more kinds of things")
    long = words.unread(fromstring(f"<robot><{'z' * 5000}/></robot>"))
    assert len(long[0]) < 300


YAML = "closed_loop: [[a, b]]\ntype: [3d]\nname_mot: [c]\njoint_name: [d]\njoint_type: [FIXED]\n"


@pytest.mark.parametrize(
    "key", ["closed_loop", "type", "name_mot", "joint_name", "joint_type", "free_flyer"]
)
def test_misspelt_keys_of_yaml_are_errors(tmp_path, key):
    path = tmp_path / "robot.yaml"
    for slip in slips(key):
        path.write_text(re.sub(f"(?m)^{key}:", f"{slip}:", f"{YAML}free_flyer: true\n"))
        with pytest.raises(pj.ModelFileError):
            read_closure_yaml(path)


def test_a_key_of_yaml_given_twice(tmp_path):
    path = tmp_path / "robot.yaml"
    path.write_text(f"{YAML}closed_loop: []\n")
    with pytest.raises(pj.ModelFileError, match=r"'closed_loop' is given twice \(line 6\)"):
        read_closure_yaml(path)
