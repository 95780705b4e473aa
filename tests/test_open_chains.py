"""Open chains of other formats: all joints of one degree of freedom are motors, as a note says."""

from __future__ import annotations

import mjcf_models
import numpy as np
import pytest
from looped import joint, link, robot

import pmjac_pin as pj

NOTE = "no loop closes: every joint of one degree of freedom counts as a motor"


def sdf_joint(name, kind, parent, child, inside="<axis><xyz>0 0 1</xyz></axis>"):
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f'<joint name="{name}" type="{kind}">{ends}{inside}</joint>'


def sdf_model(*inside, name="arm"):
    links = "".join(
        f'<link name="{one}"><pose>{k} 0 0 0 0 0</pose></link>' for k, one in enumerate("abcd")
    )
    return f'<model name="{name}">{links}{"".join(inside)}</model>'


def in_sdf(text):
    return f'<sdf version="1.9">{text}</sdf>'


ARM = (
    sdf_joint("i", "revolute", "a", "b"),
    sdf_joint("j", "prismatic", "b", "c", "<axis><xyz>1 0 0</xyz></axis>"),
    sdf_joint("k", "continuous", "c", "d"),
)
URDF = robot(
    *(link(name) for name in "abcd"),
    joint("i", "revolute", "a", "b", (1, 0, 0)),
    joint("j", "prismatic", "b", "c", (1, 0, 0), axis="1 0 0"),
    joint("k", "continuous", "c", "d", (1, 0, 0)),
)
MJCF = mjcf_models.mjcf(
    '<body name="a"><geom size=".1"/><body name="b" pos="1 0 0"><joint name="i"/><geom size=".1"/>'
    '<body name="c" pos="1 0 0"><joint name="j" type="slide" axis="1 0 0"/><geom size=".1"/>'
    '<body name="d" pos="1 0 0"><joint name="k"/><geom size=".1"/></body></body></body></body>'
)
FORMATS = {"urdf": URDF, "sdf": in_sdf(sdf_model(*ARM)), "xml": MJCF}


@pytest.fixture
def write(tmp_path):
    def write(text, suffix="sdf"):
        path = tmp_path / f"arm.{suffix}"
        path.write_text(text)
        return path

    return write


@pytest.mark.parametrize("suffix", FORMATS)
def test_all_joints_are_motors(write, suffix):
    mechanism = pj.load(write(FORMATS[suffix], suffix), tool="d")
    assert (mechanism.actuated, mechanism.passive) == (("i", "j", "k"), ())
    assert NOTE in mechanism.notes
    J = mechanism.close([0.0, 0.5, 0.2]).jacobian().J_eq
    np.testing.assert_allclose(J[0:2], [[0, 1, 0], [2.5, 0, 0]], atol=1e-12)
    np.testing.assert_allclose(J[5], [1, 0, 1], atol=1e-12)


@pytest.mark.parametrize("suffix", FORMATS)
def test_motors_that_are_given_are_the_motors_and_no_note_says_otherwise(write, suffix):
    mechanism = pj.load(write(FORMATS[suffix], suffix), actuated=["k", "i", "j"], tool="d")
    assert mechanism.actuated == ("k", "i", "j")
    assert not any("counts as a motor" in note for note in mechanism.notes)


def test_followers_are_none(write):
    mimic = '<mimic joint="i" axis="axis"><multiplier>2</multiplier></mimic>'
    follower = sdf_joint("k", "continuous", "c", "d", f"<axis><xyz>0 0 1</xyz>{mimic}</axis>")
    text = in_sdf(sdf_model(*ARM[:2], follower)).replace('"1.9"', '"1.11"')
    mechanism = pj.load(write(text), tool="d")
    assert (mechanism.actuated, mechanism.passive) == (("i", "j"), ("k",))
    assert any("but those that follow another, counts as a motor" in n for n in mechanism.notes)


def test_where_a_loop_closes_motors_are_asked_for(write):
    text = in_sdf(sdf_model(*ARM, sdf_joint("l", "ball", "a", "d", "")))
    with pytest.raises(pj.ModelFileError, match="which joints are motors; give `actuated`, of: i"):
        pj.load(write(text), tool="d")


GROUNDS = {
    "included": "<include><uri>model://ground_plane</uri></include>",
    "written out": '<model name="ground_plane"><static>true</static><link name="link">'
    '<collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>'
    "</link></model>",
}


@pytest.mark.parametrize("ground", GROUNDS.values(), ids=GROUNDS)
@pytest.mark.parametrize("suffix", ["sdf", "world"])
def test_a_world_with_a_ground_and_one_robot(write, ground, suffix):
    world = (
        f'<world name="w">{ground}<light name="sun" type="directional"/>{sdf_model(*ARM)}</world>'
    )
    mechanism = pj.load(write(in_sdf(world), suffix), tool="d")
    assert mechanism.actuated == ("i", "j", "k")
    assert not mechanism.unread


SCREW = "<axis><xyz>1 0 0</xyz></axis><screw_thread_pitch>0.01</screw_thread_pitch>"


def test_a_screw_in_an_open_chain(write):
    text = in_sdf(sdf_model(sdf_joint("s", "screw", "a", "b", SCREW)))
    mechanism = pj.load(write(text), tool="b")
    assert mechanism.actuated == ("s",)
    assert mechanism.spec.helical == {"s": pytest.approx(0.01 / (2 * np.pi))}


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
@pytest.mark.parametrize(("given", "left"), [("axis", "axis2"), ("axis2", "axis")])
def test_an_axis_that_is_left_out_is_the_formats_default(write, kind, given, left):
    """The cross of two axes, one of them given: as with 0 0 1 written out."""
    one = f"<{given}><xyz>1 0 0</xyz></{given}>"
    both = one + f"<{left}><xyz>0 0 1</xyz></{left}>"
    found, wanted = (
        pj.load(write(in_sdf(sdf_model(sdf_joint("u", kind, "a", "b", inside)))), tool="b")
        for inside in (one, both)
    )
    assert found.actuated == wanted.actuated == ("u_axis", "u_axis2")
    for theta in ([0.3, 0.4], [-0.2, 1.0]):
        J, expected = (one.close(theta).jacobian().J_eq for one in (found, wanted))
        np.testing.assert_array_equal(J, expected)
    assert [note for note in found.notes if f"has no <{left}>: SDFormat's default" in note]
    assert not [note for note in wanted.notes if "has no <axis" in note]


def test_a_default_that_is_the_other_axis_is_refused(write):
    text = in_sdf(sdf_model(sdf_joint("u", "universal", "a", "b")))
    with pytest.raises(pj.ModelFileError, match="'u' has no <axis2>, and SDFormat's default 0 0 1"):
        pj.load(write(text), tool="b")


def test_without_any_axis_it_is_refused(write):
    text = in_sdf(sdf_model(sdf_joint("u", "universal", "a", "b", "")))
    with pytest.raises(pj.ModelFileError, match="joint 'u' has no <axis>; a universal joint needs"):
        pj.load(write(text), tool="b")
