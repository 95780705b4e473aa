"""Drake's own elements that tie bodies together: read, told or refused, never passed over.

From the "full list of custom elements" of Drake's documentation, "Parsing Models for Multibody
Dynamics": those that act on what moves. The others say how things look, collide and weigh, or
are parts of these. There is no weld among them; who writes one does not get a machine without it.
"""

from __future__ import annotations

import pytest
from test_sdf_ties import BALL, RHOMBUS, sdf
from test_urdf_ties import RHOMBUS as URDF

import pmjac_pin as pj

NAMESPACE = 'xmlns:drake="http://drake.mit.edu"'
#: Elements, where they stand, and by what they are answered: a note, or the words of a refusal.
URDF_TIES = {
    "drake:ball_constraint": ("robot", "has no <drake:ball_constraint_body_A>"),
    "drake:joint": ("robot", None),
    "drake:linear_bushing_rpy": ("robot", None),
    "drake:linear_spring_damper": ("robot", None),
    "drake:tendon_constraint": ("robot", None),
    "drake:weld_constraint": ("robot", "is not read"),
    "drake:mimic": ("joint", None),
    "drake:screw_thread_pitch": ("joint", None),
    "drake:deformable_properties": ("link", None),
}
SDF_TIES = URDF_TIES | {
    "drake:mimic": ("joint", "the joint '' does not exist"),
    "drake:screw_thread_pitch": ("joint", "did you mean 'screw_thread_pitch'"),
}


def put_into(text, host, element):
    text = text.replace('<link name="crank"/>', '<link name="crank"></link>')
    end = text.index(f"</{host}>")
    return text[:end] + element + text[end:]


def is_answered(path, text, tag, refusal):
    path.write_text(text)
    if refusal:
        with pytest.raises(pj.ModelFileError, match=refusal):
            pj.load(path, actuated=["a"], tool="rocker")
    else:
        machine = pj.load(path, actuated=["a"], tool="rocker")
        assert any(f"<{tag}>" in note for note in machine.unread)
        assert any(f"<{tag}>" in found.message for found in pj.check(machine).findings)


@pytest.mark.parametrize("tag", URDF_TIES)
def test_what_ties_in_a_urdf(tmp_path, tag):
    host, refusal = URDF_TIES[tag]
    text = put_into(URDF.format("").replace("<robot", f"<robot {NAMESPACE}"), host, f"<{tag}/>")
    is_answered(tmp_path / "robot.urdf", text, tag, refusal)


@pytest.mark.parametrize("tag", SDF_TIES)
def test_what_ties_in_sdformat(tmp_path, tag):
    host, refusal = SDF_TIES[tag]
    rest = "" if tag == "drake:ball_constraint" else BALL
    text = put_into(sdf(RHOMBUS + rest), "model" if host == "robot" else host, f"<{tag}/>")
    is_answered(tmp_path / "robot.sdf", text, tag, refusal)


def test_what_hangs_on_an_unread_joint_of_drake_alone_is_not_read_without_it(tmp_path):
    whole = URDF.format("").replace("<robot", f"<robot {NAMESPACE}")
    start = whole.index('<joint name="b"')
    ball = '<drake:joint name="b" type="ball">'
    text = whole[:start] + whole[start:].replace('<joint name="b" type="continuous">', ball, 1)
    text = text.replace("</joint>", "</drake:joint>", 2).replace("</drake:joint>", "</joint>", 1)
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    with pytest.raises(pj.ModelFileError, match=r"coupler"):
        pj.load(path, actuated=["a"], tool="rocker")
