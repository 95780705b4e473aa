"""A machine led by its tool is the same, however its own frames and joints are named."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import pmjac_pin as pj


def five_bar(frames=(), joint=None):
    """The five-bar with further frames, where its tool is at home, or with a joint of no loop."""
    given = pj.load("five_bar")
    model, home = given.model, given.home.q
    for name in frames:
        place = given.home.tool_pose()
        model.addFrame(pin.Frame(name, 0, place, pin.FrameType.OP_FRAME), False)
    if joint:
        model.addJoint(0, pin.JointModelSphericalZYX(), pin.SE3.Identity(), joint)
        home = np.append(home, np.zeros(3))
    motors = [*given.actuated, *([joint] if joint else [])]
    loops = list(given.spec.loops)
    machine = pj.Mechanism.from_pinocchio(model, loops, motors, "tip", home=home)
    return machine.with_tool("tip", rows=["vx", "vy"])


TARGET = (0.1, 0.05)  # further on of the motors


def test_frames_that_are_called_as_a_target_are_not_taken_for_it():
    plain, other = five_bar(), five_bar(["tip target", "where the tool is to be"])
    there = plain.close(plain.home.actuated + TARGET)
    found = pj.reach(other, there.tool_pose())
    np.testing.assert_allclose(found.configuration.actuated, there.actuated, atol=1e-9)
    assert len(pj.working_modes(other, there.tool_pose(), rng=0, proof=False)) == 2
    window = {"x": (-0.85, 1.15), "y": (-0.52, 1.48)}
    found = [
        pj.workspace(one, ["x", "y"], window=window, cells=9, trace=False).reached
        for one in (other, plain)
    ]
    assert 0 < found[1].sum() < found[1].size
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize(
    ("name", "asked"),
    [
        ("x", lambda machine: pj.workspace(machine, ["x", "y"], cells=21)),
        ("tip slide 1", lambda machine: pj.reach(machine, machine.home.tool_pose())),
    ],
)
def test_joints_that_are_called_as_those_that_lead_are_refused(name, asked):
    with pytest.raises(pj.ArgumentError, match=f"named '{name}' already"):
        asked(five_bar(joint=name))
