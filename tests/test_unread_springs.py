"""Springs that files give to joints are not read, and told."""

from __future__ import annotations

import pytest

import pmjac_pin as pj

LINKS = '<link name="ground"/><link name="arm"/><link name="hand"/>'
JOINT = '<joint name="{}" type="revolute"><parent link="{}"/><child link="{}"/><axis xyz="0 0 1"/>'
LIMIT = '<limit effort="1" velocity="1" lower="-1" upper="1"/>'


def urdf(springs="", gazebo=""):
    one, other = JOINT.format("a", "ground", "arm"), JOINT.format("b", "arm", "hand")
    joints = f"{one}{LIMIT}{springs}</joint>{other}{LIMIT}<dynamics damping='1'/></joint>"
    return f'<robot name="r">{LINKS}{joints}{gazebo}</robot>'


def sdf(stiffness):
    dynamics = f"<dynamics><spring_stiffness>{stiffness}</spring_stiffness></dynamics>"
    axis = f"<axis><xyz>0 0 1</xyz>{dynamics}</axis>"
    joint = f"<parent>world</parent><child>arm</child>{axis}"
    joint = f'<joint name="a" type="revolute">{joint}</joint>'
    return f'<sdf version="1.9"><model name="m"><link name="arm"/>{joint}</model></sdf>'


def mjcf(joint="", default=""):
    inside = f'<joint name="a" axis="0 0 1" {joint}/><geom size=".1"/>'
    world = f'<worldbody><body name="arm">{inside}</body></worldbody>'
    motor = '<actuator><motor joint="a"/></actuator>'
    return f"<mujoco><default><joint {default}/></default>{world}{motor}</mujoco>"


SPRUNG = {
    "robot.urdf": [
        urdf('<dynamics stiffness="3"/>'),
        urdf('<dynamics spring_stiffness="3" damping="1"/>'),
        urdf(gazebo='<gazebo reference="a"><springStiffness>3</springStiffness></gazebo>'),
    ],
    "robot.sdf": [sdf(3)],
    "robot.xml": [mjcf('stiffness="3"'), mjcf(default='stiffness="3"'), mjcf('springdamper="1 1"')],
}
SLACK = {
    "robot.urdf": [urdf(), urdf('<dynamics stiffness="0"/>')],
    "robot.sdf": [sdf(0)],
    "robot.xml": [mjcf(), mjcf('stiffness="0"', default='stiffness="3"')],
}
TOLD = "springs of joints are not read (a): give those that are to act to statics or dynamics"


def cases(texts):
    return [(name, text) for name, several in texts.items() for text in several]


def notes(folder, name, text):
    if name.endswith("xml"):
        pytest.importorskip("mujoco")
    (folder / name).write_text(text)
    return pj.load(folder / name, tool="arm").notes


@pytest.mark.parametrize(("name", "text"), cases(SPRUNG))
def test_springs_of_joints_are_told(name, text, tmp_path):
    assert TOLD in notes(tmp_path, name, text)


@pytest.mark.parametrize(("name", "text"), cases(SLACK))
def test_of_none_nothing_is_told(name, text, tmp_path):
    assert not [note for note in notes(tmp_path, name, text) if "spring" in note]


def test_beside_a_model_file_they_are_told_too(tmp_path):
    (tmp_path / "robot.urdf").write_text(urdf('<dynamics stiffness="3"/>'))
    model = 'urdf = "robot.urdf"\nactuated = ["a", "b"]\ntool.frame = "hand"\n'
    model += "[poses.home]\na = 0.0\nb = 0.0\n"
    (tmp_path / "robot.toml").write_text(model)
    assert TOLD in pj.load(tmp_path / "robot.toml").notes
