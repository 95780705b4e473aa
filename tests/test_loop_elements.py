"""<loop>, <constraint>: kinds, axes, anchors, and what is wrong with them."""

from __future__ import annotations

import looped
import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.files.urdf.looped_urdf import read_looped_urdf


@pytest.fixture
def read(tmp_path):
    def read(element):
        path = tmp_path / "machine.urdf"
        path.write_text(looped.with_element(element))
        return read_looped_urdf(path)

    return read


@pytest.mark.parametrize("element", [looped.loop_element, looped.constraint_element])
@pytest.mark.parametrize(
    ("kind", "loop"),
    [
        ("revolute", pj.RevoluteLoop),
        ("continuous", pj.RevoluteLoop),
        ("prismatic", pj.PrismaticLoop),
        ("cylindrical", pj.CylindricalLoop),
        ("planar", pj.PlanarLoop),
        ("spherical", pj.SphericalLoop),
        ("ball", pj.SphericalLoop),
        ("fixed", pj.FrameLoop),
    ],
)
def test_kinds(read, element, kind, loop):
    (found,) = read(element(kind)).loops
    assert type(found) is loop
    assert found.frames == ("tip_on_coupler", "tip_on_rocker")
    assert getattr(found, "axis", (0, 0, 1)) == (0, 0, 1)


def test_a_universal_joint_has_an_axis_on_each_side(read):
    (loop,) = read(looped.constraint_element("universal", "0 0 2", "3 0 0")).loops
    assert loop.axes == ((0, 0, 1), (1, 0, 0))
    with pytest.raises(pj.ModelFileError, match="is universal: give <parent_axis> and <child_axis"):
        read(looped.loop_element("universal"))


def test_a_floating_loop_holds_nothing(read):
    model = read(looped.loop_element("floating"))
    assert model.loops == ()
    assert "loop 'tip' is floating and holds nothing: left out" in model.notes
    assert "tip_on_coupler" not in model.urdf.links


def test_the_axis_is_x_where_none_is_given(read):
    assert read(looped.loop_element(axis="")).loops[0].axis == (1, 0, 0)


def test_the_identity_needs_no_anchor(read):
    ends = '<predecessor link="coupler"/><successor link="rocker"><origin/></successor>'
    model = read(f'<loop type="fixed">{ends}</loop>')
    assert model.loops == (pj.FrameLoop(frames=("coupler", "rocker")),)


def test_anchors_have_names_of_their_own(read):
    taken = '<link name="tip_on_rocker"/><joint name="tip_on_coupler_fixed" type="fixed">'
    taken += '<parent link="ground"/><child link="tip_on_rocker"/></joint>'
    model = read(looped.loop_element() + looped.loop_element() + taken)
    assert [loop.frames for loop in model.loops] == [
        ("tip_on_coupler", "tip_on_rocker_2"),
        ("tip_on_coupler_2", "tip_on_rocker_3"),
    ]
    joints = {joint.child: joint for joint in model.urdf.joints}
    assert joints["tip_on_coupler"].name == "tip_on_coupler_fixed_2"
    assert joints["tip_on_coupler"].parent == "coupler"


def test_a_turned_child_axis_turns_its_anchor(tmp_path):
    """Whatever frame the child's axis is given in, the loop's axis has the same components."""
    path = tmp_path / "machine.urdf"
    for child_axis, rpy in (
        ("0 1 0", "1.5707963267948966 0 0"),
        ("0 0 -1", "3.141592653589793 0 0"),
    ):
        path.write_text(
            looped.with_element(looped.constraint_element("cylindrical", looped.Z, child_axis, rpy))
        )
        mechanism = pj.load(path, actuated=["theta1"], tool=looped.TOOL)
        residual, _ = mechanism.loop_equations(np.zeros(3))
        np.testing.assert_allclose(residual, 0.0, atol=1e-14)
        assert mechanism.mobility == 1


def test_a_loop_beside_a_joint_is_said(read):
    element = looped.loop_element().replace('"rocker"', '"crank"')
    assert read(element).notes == ("loop 'tip' joins the links that joint 'phi2' joins already",)


BAD = {
    "type": (looped.loop_element("revolut"), "has the unknown type 'revolut'; did you mean"),
    "no type": (looped.loop_element().replace(' type="revolute"', ""), "has the unknown type ''"),
    "no end": (
        '<loop name="tip" type="fixed"><predecessor link="crank"/></loop>',
        'has no successor; write <successor link="..."/>',
    ),
    "no such link": (
        looped.loop_element().replace('"rocker"', '"roker"'),
        "the successor link 'roker' does not exist; did you mean 'rocker'?",
    ),
    "itself": (looped.loop_element().replace('"rocker"', '"coupler"'), "joins link 'coupler' with"),
    "axis": (looped.loop_element(axis='<axis xyz="0 0 0"/>'), "<axis>: `xyz` is '0.0 0.0 0.0', of"),
    "axis of two": (looped.loop_element(axis='<axis xyz="0 1"/>'), "'0 1', not 3 finite numbers"),
    "nan": (
        looped.constraint_element(rpy="nan 0 0"),
        "<child_origin>: `rpy` is 'nan 0 0', not 3 finite numbers",
    ),
    "two axes of a slider": (
        looped.constraint_element("prismatic", "0 0 1", "0 1 0"),
        "is prismatic and has two different axes",
    ),
    "two origins": (
        looped.constraint_element(tail="<child_origin/>"),
        "has 2 <child_origin>; give one",
    ),
}


@pytest.mark.parametrize(("element", "message"), BAD.values(), ids=BAD)
def test_what_is_refused(read, element, message):
    with pytest.raises(pj.ModelFileError) as caught:
        read(element)
    assert message in str(caught.value)
    assert "'tip'" in str(caught.value)
