"""Names of frames: what is meant where several things have one name."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.model.frames import find_frame

Z = (0, 0, 1)


def arm():
    """A joint "hand" two thirds along, a link "hand" at the end."""
    return pin.buildModelFromXML(
        mechanisms.tree(
            ("shoulder", "revolute", "base", "upper", (0, 0, 0), Z),
            ("hand", "revolute", "upper", "lower", (1, 0, 0), Z),
            ("end", "fixed", "lower", "hand", (0.5, 0, 0)),
        )
    )


def add(model, name, joint, place, kind=pin.FrameType.OP_FRAME):
    model.addFrame(pin.Frame(name, model.getJointId(joint), place, kind))


def test_a_name_that_a_joint_and_a_link_share_is_the_links():
    model = arm()
    found = find_frame(model, "hand")
    assert model.frames[found.index].type == pin.FrameType.BODY
    np.testing.assert_array_equal(found.placement.translation, [0.5, 0, 0])
    assert model.names[find_frame(model, "shoulder").joint] == "shoulder"


def test_recutting_keeps_what_a_shared_name_means():
    mechanism = loaded("four_bar")
    model = mechanism.model
    add(model, "theta1", "phi1", pin.SE3.Random(), pin.FrameType.BODY)
    named = pj.Mechanism.from_pinocchio(
        model, mechanism.spec.loops, ["theta1"], "theta1", home=mechanism.home.q
    )
    np.testing.assert_allclose(
        pj.recut(named, "phi2").home.tool_pose().homogeneous,
        named.home.tool_pose().homogeneous,
        atol=1e-10,
    )


@pytest.mark.parametrize("place", [pin.SE3.Identity(), pin.SE3(np.eye(3), np.array([0.6, 0, 0]))])
def test_a_link_and_an_added_frame_in_two_places_are_told_apart_by_nobody(place):
    model = arm()
    add(model, "hand", "hand", place)
    with pytest.raises(pj.ArgumentError) as caught:
        pj.Mechanism.from_pinocchio(model, [], ["shoulder", "hand"], "hand")
    assert str(caught.value) == (
        "frame 'hand' is ambiguous: a link on 'hand' and a frame on 'hand' have this name; "
        "rename one"
    )
    loop = pj.PointLoop(frames=("upper", "hand"))
    with pytest.raises(pj.ArgumentError, match="frame 'hand' is ambiguous"):
        pj.Mechanism.from_pinocchio(model, [loop], ["shoulder"], "lower")


def test_names_that_nobody_uses_may_be_ambiguous():
    model = arm()
    add(model, "hand", "shoulder", pin.SE3.Identity())
    assert pj.Mechanism.from_pinocchio(model, [], ["shoulder", "hand"], "lower").nv == 2


def test_two_frames_of_one_name_in_one_place_are_one():
    model = arm()
    add(model, "hand", "hand", pin.SE3(np.eye(3), np.array([0.5, 0, 0])))
    assert find_frame(model, "hand").joint == 2


def test_unknown_names_come_with_what_is_near():
    with pytest.raises(pj.UnknownNameError, match="unknown frame 'hant'; did you mean 'hand'"):
        find_frame(arm(), "hant")
