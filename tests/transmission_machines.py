"""Machines with a rectangle of joint values each, for tests of tables and headers."""

from __future__ import annotations

from functools import cache

import mechanisms
import numpy as np
import pinocchio as pin

import pmjac_pin as pj

LEVEL = {"pitch": (-0.4, 0.25), "roll": (-0.15, 0.15)}
SMALL = {"pitch": (-0.1, 0.15), "roll": (-0.1, 0.1)}
CRANK = {"theta1": (1.2, 1.9)}


def around(name, joints, share):
    """Joint values around home."""
    values = mechanisms.loaded(name).home.joint_values
    return {joint: (values[joint] - share, values[joint] + share) for joint in joints}


def rocker_drives(coupler):
    """A four-bar whose rocker is the motor; its coupler on a joint without end, or on a ball."""
    _, l1, l2, l3 = mechanisms.CRANK_ROCKER
    model, l0 = pin.Model(), mechanisms.CRANK_ROCKER[0]

    def add(parent, joint, x, name):
        index = model.addJoint(parent, joint, pin.SE3(np.eye(3), np.array([x, 0.0, 0.0])), name)
        model.addJointFrame(index)
        return index

    def mark(name, joint, x):
        place = pin.SE3(np.eye(3), np.array([x, 0.0, 0.0]))
        model.addFrame(pin.Frame(name, joint, 0, place, pin.FrameType.OP_FRAME))

    crank = add(0, pin.JointModelRUBZ(), 0.0, "theta1")
    mark("coupler_tip", add(crank, coupler, l1, "coupler"), l2)
    mark("rocker_tip", add(0, pin.JointModelRUBZ(), l0, "phi1"), l3)
    loop = pj.RevoluteLoop(frames=("coupler_tip", "rocker_tip"))
    ball = coupler.nv > 1
    home = {"theta1": 1.5, "coupler": (0.0, 0.0, 0.2) if ball else 0.2, "phi1": 2.3}
    return pj.Mechanism.from_pinocchio(
        model, [loop], ["phi1"], "rocker_tip", home=home, name="rocker_drives"
    )


def geared():
    """Two joints and a gear between them."""
    joints = [
        ("a", "revolute", "ground", "one", (0, 0, 0), (0, 0, 1)),
        ("b", "revolute", "ground", "other", (1, 0, 0), (0, 0, 1)),
        ("end", "fixed", "other", "tip", (1, 0, 0)),
    ]
    model = pin.buildModelFromXML(mechanisms.tree(*joints))
    gear = pj.JointLoop(joints=("a", "b"), ratio=-2.5, offset=0.1)
    return pj.Mechanism.from_pinocchio(
        model, [gear], ["a"], "tip", home={"a": 0.0, "b": 0.1}, name="geared"
    )


#: Revolute loops, rods on universal joints, slides, redundant rows, cosines and quaternions in q,
#: a gear, and an over-constrained linkage.
CASES = {
    "humanoid_ankle": (lambda: mechanisms.loaded("humanoid_ankle"), LEVEL, 17),
    "ankle": (lambda: mechanisms.loaded("ankle"), SMALL, 9),
    "four_bar": (lambda: mechanisms.loaded("four_bar"), {"phi1": (2.1, 2.5)}, 17),
    "five_bar": (
        lambda: mechanisms.loaded("five_bar"),
        around("five_bar", ("phi1", "phi2"), 0.15),
        9,
    ),
    "slider_crank": (
        lambda: mechanisms.loaded("slider_crank"),
        around("slider_crank", mechanisms.loaded("slider_crank").passive[-1:], 0.05),
        9,
    ),
    "geared": (geared, {"b": (-0.5, 0.7)}, 5),
    "bennett": (
        lambda: mechanisms.loaded("bennett"),
        around("bennett", mechanisms.loaded("bennett").passive[:1], 0.05),
        9,
    ),
    "without end": (lambda: rocker_drives(pin.JointModelRUBZ()), CRANK, 17),
    "ball": (lambda: rocker_drives(pin.JointModelSpherical()), CRANK, 17),
}


@cache
def table_of(name):
    """Made once for all tests: nothing changes it."""
    make, over, points = CASES[name]
    return pj.transmission_table(make(), over, points)


def drawn(table, rng, count):
    """Joint values inside a table's rectangle."""
    box = table.rectangle
    return rng.uniform(box.lower, box.upper, (count, box.lower.size))
