"""What could tie bodies together is read, told or refused, wherever in a file it stands."""

from __future__ import annotations

import re
from xml.etree.ElementTree import SubElement, fromstring, tostring

import looped
import mjcf_models
import pytest
from misspellings import places

import pmjac_pin as pj
from pmjac_pin.files.mjcf.reader import read_mjcf
from pmjac_pin.files.mjcf.vocabulary import MJCF_WORDS
from pmjac_pin.files.sdf.reader import read_sdf
from pmjac_pin.files.sdf.vocabulary import SDF_WORDS
from pmjac_pin.files.urdf.looped_urdf import read_looped_urdf
from pmjac_pin.files.urdf.vocabulary import URDF_WORDS

DRAKE = 'xmlns:drake="http://drake.mit.edu"'
BALL = "".join(
    f'<drake:ball_constraint_{part} {key}="{value}">{value}</drake:ball_constraint_{part}>'
    for part, key, value in (
        ("body_A", "name", "{0}"), ("p_AP", "value", "3 1 0"),
        ("body_B", "name", "{1}"), ("p_BQ", "value", "-1 2 0"),
    )
)  # fmt: skip
ENDS = '<parent link="{0}">{0}</parent><child link="{1}">{1}</child>'
HOLD = "<parent_link>{0}</parent_link><child_model>m</child_model><child_link>{1}</child_link>"
TIES = {
    "joint": f'<joint name="tie" type="fixed">{ENDS}</joint>',
    "mimic": '<mimic joint="{2}" multiplier="2"><multiplier>2</multiplier></mimic>',
    "loop": f'<loop name="tie" type="fixed">{ENDS}</loop>',
    "constraint": f'<constraint name="tie" type="fixed">{ENDS}</constraint>',
    "loop_joint": '<loop_joint name="tie" type="fixed"><link1 link="{0}"/><link2 link="{1}"/>'
    "</loop_joint>",
    "ball": f"<drake:ball_constraint>{BALL}</drake:ball_constraint>",
    "weld constraint": "<drake:weld_constraint/>",
    "distance": "<drake:distance_constraint/>",
    "coupler": "<drake:coupler_constraint/>",
    "Drake's mimic": '<drake:mimic joint="{2}" multiplier="2"/>',
    "Drake's joint": '<drake:joint name="tie" type="ball"/>',
    "bushing": "<drake:linear_bushing_rpy/>",
    "coupling": '<coupling name="tie"/>',
    "detachable": f'<plugin name="tie" filename="gz-sim-detachable-joint-system">{HOLD}</plugin>',
    "disguised": f'<plugin name="tie" filename="libgazebo_ros_force.so">{HOLD}</plugin>',
    "mimic plugin": '<plugin name="tie" filename="libmimic.so"><joint>{2}</joint>'
    "<mimicJoint>{3}</mimicJoint></plugin>",
    "disguised mimic": '<plugin name="tie" filename="libgazebo_ros_force.so"><joint>{2}</joint>'
    "<mimic_joint>{3}</mimic_joint></plugin>",
    "gripper": '<gripper name="tie"><palm_link>{0}</palm_link></gripper>',
    "model": f'<model name="tie"><joint name="tie" type="fixed">{ENDS}</joint></model>',
    "include": "<include><uri>model://linkage</uri></include>",
    "connect": '<connect body1="{0}" body2="{1}" anchor="0 0 0"/>',
    "weld": '<weld body1="{0}" body2="{1}"/>',
    "equality": '<equality><weld body1="{0}" body2="{1}"/></equality>',
    "tendon": '<tendon><fixed name="tie" range="0 1"/></tendon>',
}
URDF = looped.robot(
    *(looped.link(name) for name in ("m", "a", "b")),
    looped.joint("i", "continuous", "m", "a"),
    looped.joint("j", "continuous", "a", "b", (1, 0, 0)),
    '<material name="red"><color rgba="1 0 0 1"/></material>'
    '<transmission name="t"><actuator name="x"/><joint name="i"/></transmission>'
    '<ros2_control name="c" type="system"><joint name="i"><param name="id">1</param></joint>'
    "</ros2_control><mujoco/><group/><gazebo/><gazebo reference='a'>"
    "<sensor name='s'><camera/></sensor></gazebo><link name='z'><visual><geometry>"
    '<box size="1 1 1"/></geometry></visual><inertial><mass value="1"/><inertia ixx="1" ixy="0" '
    'ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link><joint name="k" type="fixed">'
    '<parent link="b"/><child link="z"/><origin xyz="0 0 1"/></joint>',
).replace("<robot ", f"<robot {DRAKE} ", 1)
SDF = f"""
<sdf version="1.11" {DRAKE}><world name="w">
  <include><uri>model://ground_plane</uri></include><light name="sun"/><physics name="p"/>
  <state><model name="m"><joint name="i"><angle>0</angle></joint></model></state><gui/>
  <model name="wall"><static>true</static><link name="w"><pose>0 0 1 0 0 0</pose></link></model>
  <model name="m"><pose>0 0 1 0 0 0</pose>
    <link name="a"><visual name="v"><geometry><box><size>1 1 1</size></box></geometry></visual>
      <inertial><mass>1</mass></inertial><sensor name="s"><camera/></sensor></link>
    <link name="b"><pose>1 0 0 0 0 0</pose></link><link name="c"/><frame name="f"/>
    <joint name="i" type="revolute"><parent>world</parent><child>a</child>
      <axis><xyz>0 0 1</xyz><limit><lower>-1</lower></limit></axis>
      <axis2><xyz>0 0 1</xyz></axis2></joint>
    <joint name="j" type="revolute"><parent>a</parent><child>b</child>
      <axis><xyz>0 0 1</xyz></axis></joint>
    <joint name="k" type="fixed"><parent>b</parent><child>c</child><axis/></joint>
  </model></world></sdf>"""
MJCF = mjcf_models.mjcf(
    '<body name="m"><joint name="i"/><geom size=".1"/><site name="s"/><body name="b" pos="1 0 0">'
    '<joint name="j"/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><camera/></body></body>'
    '<body name="a"><frame><geom size=".1"/></frame><joint name="k"/></body>',
    '<connect active="false" body1="b" body2="a" anchor="0 0 0"/>',
    "<compiler/><option><flag/></option><default><joint/></default><sensor/><custom/>",
    '<actuator><motor joint="i"/></actuator><keyframe><key name="home"/></keyframe>',
).replace("<mujoco", f"<mujoco {DRAKE}", 1)
FORMATS = {
    "urdf": (URDF, URDF_WORDS, read_looped_urdf, ("m", "b", "i", "j")),
    "sdf": (SDF, SDF_WORDS, read_sdf, ("a", "c", "i", "j")),
    "xml": (MJCF, MJCF_WORDS, read_mjcf, ("b", "a", "i", "j")),
}
# Where an element of that name names something, or what stands by itself, and ties nothing.
NAMED_ONLY = {
    "urdf": ("transmission/joint", "transmission/plugin", "group/joint", "hardware/plugin"),
    "sdf": ("state/model", "state/model/joint", "gui/plugin"),
    "xml": ("geom/plugin", "sensor/plugin", "default/tendon"),
}
CONSTRAINTS = {"flex", "flexstrain", "flexvert", "distance"}  # which are refused by themselves
CASES = [(suffix, tie) for suffix in FORMATS for tie in TIES]


def children(words, place):
    """Return the words that a vocabulary has for the children of an element."""
    lines = re.sub(r"\n +", " ", words.text.strip()).splitlines()
    found = {line.split()[0]: line.partition(" : ")[2].split() for line in lines}
    return found.get(place, found.get(place.rpartition("/")[2], []))


def full(suffix):
    """Return a file whose elements hold all that is known to have no bearing on the machine."""
    text, words, *_ = FORMATS[suffix]
    root = fromstring(text)
    for element, place in list(places(root)):
        inside = {child.tag for child in element} | CONSTRAINTS
        for word in children(words, place):
            if word.endswith("*") and ":" not in word and word[:-1] not in inside:
                SubElement(element, word[:-1])
    return root


@pytest.fixture
def outcome(tmp_path):
    def outcome(suffix, root):
        path = tmp_path / f"machine.{suffix}"
        path.write_text(tostring(root, encoding="unicode"))
        try:
            model = FORMATS[suffix][2](path)
        except pj.ModelFileError as error:
            return str(error)
        return model.urdf.kinematic_xml(), model.loops, model.notes, model.unread

    return outcome


def unseen(suffix, tie, outcome, step):
    """Return where a tie changes nothing: neither the machine, nor what is told of it."""
    root, (*_, names) = full(suffix), FORMATS[suffix]
    element = fromstring(f"<all {DRAKE}>{TIES[tie].format(*names)}</all>")[0]
    before = outcome(suffix, root)
    assert not isinstance(before, str), before
    found, number = [], CASES.index((suffix, tie))
    for parent, place in list(places(root))[number % step :: step]:
        parent.append(element)
        if outcome(suffix, root) == before:
            found.append(f"{place}/{element.tag}")
        parent.remove(element)
    return [place for place in found if not place.endswith(NAMED_ONLY[suffix])]


@pytest.mark.parametrize(("suffix", "tie"), CASES)
def test_no_tie_is_passed_over_at_some_places(suffix, tie, outcome):
    assert unseen(suffix, tie, outcome, step=40) == []


@pytest.mark.slow
@pytest.mark.parametrize(("suffix", "tie"), CASES)
def test_no_tie_is_passed_over_anywhere(suffix, tie, outcome):
    assert unseen(suffix, tie, outcome, step=1) == []
