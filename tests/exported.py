"""Machines to be exported, each for one thing that a format may lose; and what must not change."""

from __future__ import annotations

import contextlib
import re

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
import random_machines
import test_base_inputs
import test_helical
import test_recut
import transformed
from mechanisms import Z, loaded, tree

import pmjac_pin as pj

FORMATS = ("mjcf", "sdf", "extended-urdf", "urdf-plus", "toml")
SUFFIXES = {"mjcf": ".xml", "sdf": ".sdf", "toml": ".toml"}
TELLING = ("mjcf", "extended-urdf", "urdf-plus", "toml")  # which joints are motors
ELSEWHERE = pin.SE3(pin.exp3(np.array([0.3, -0.5, 0.7])), np.array([120.0, -45.0, 8.0]))


def hinged(kind, order):
    """A chain of hinges about skew axes that a loop of some kind closes, from either side."""
    given = {"length": 0.5} if kind is pj.DistanceLoop else {}
    loop = kind(frames=order, **given)
    if kind is pj.UniversalLoop and order[0] == "wall":
        loop = pj.UniversalLoop(frames=order, axes=((0, 1, 0), (1, 0, 0)))
    return test_recut.hinges(loop, test_recut.KINDS[kind])


def screwed(*names):
    """A hinge and a slide of every kind about axes of any sign, with names of any kind."""
    first, second, tool = names
    joints = [
        (first, "revolute", "ground", "link one", (0.1, 0.2, 0.3), (0, 0, -1), (0.3, 0.1, -0.2)),
        (second, "prismatic", "link one", "Glied zwei", (0.5, 0, 0), (-0.6, 0, 0.8)),
        ("end", "fixed", "Glied zwei", tool, (0.2, 0.1, 0.4), None, (0.5, 0.6, 0.7)),
    ]
    model = pin.buildModelFromXML(tree(*joints))
    home = {first: 0.7, second: -0.2}
    return pj.Mechanism.from_pinocchio(model, [], [first, second], tool, home=home, name="named")


def within():
    """A four-bar whose motor's name is in those of the other joints."""
    joints = [
        ("q", "revolute", "ground", "crank", (0, 0, 0), Z),
        ("q1", "revolute", "crank", "coupler", (1, 0, 0), Z),
        ("q_motor", "revolute", "ground", "rocker", (4, 0, 0), Z),
        ("ce", "fixed", "coupler", "C1", (3, 0, 0)),
        ("re", "fixed", "rocker", "C2", (3.5, 0, 0)),
    ]
    home = {"q": 0.9, "q1": -0.9, "q_motor": 2.0}
    return mechanisms.build(joints, [("C1", "C2")], ["q"], "C1", home)


def like_sites():
    """A four-bar whose loop is between bodies, beside frames that are called like their sites."""
    joints = [
        ("q", "revolute", "ground", "crank", (0, 0, 0), Z),
        ("p", "revolute", "crank", "coupler", (1, 0, 0), Z),
        ("c", "revolute", "coupler", "pin", (3, 0, 0), Z),
        ("r", "revolute", "ground", "rocker", (4, 0, 0), Z),
        ("e", "fixed", "rocker", "end", (3.5, 0, 0)),
        ("other", "fixed", "ground", "pin_site", (7, 8, 9)),
        ("another", "fixed", "crank", "world", (0.1, 0.2, 0.3)),
    ]
    home = {"q": 0.9, "p": -0.9, "r": 2.0}
    return mechanisms.build(joints, [("pin", "end")], ["q"], "rocker", home)


def geared(*loops, motors=("a",)):
    """Four hinges side by side, tied by gears."""
    names = "abcd"
    joints = [
        (name, "revolute", "ground", f"arm_{name}", (k, 0, 0), Z) for k, name in enumerate(names)
    ]
    model = pin.buildModelFromXML(tree(*joints))
    ties = [pj.JointLoop(joints=pair, ratio=ratio, offset=offset) for pair, ratio, offset in loops]
    return pj.Mechanism.from_pinocchio(model, ties, motors, "arm_d", name="gears")


def limited():
    """Limits of one side, of both, of none; home at one of them."""
    joints = [(f"q{k}", "revolute", f"l{k}", f"l{k + 1}", (1, 0, 0), Z) for k in range(4)]
    model = pin.buildModelFromXML(tree(*joints))
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    lower[:], upper[:] = [-np.inf, 0.2, -1.0, -1e300], [2.0, np.inf, 0.3, 1e300]
    model.lowerPositionLimit, model.upperPositionLimit = lower, upper
    home = {"q0": 0.4, "q1": 0.2, "q2": -0.5, "q3": 3.0}
    return pj.Mechanism.from_pinocchio(
        model, [], ["q0", "q1", "q2"], "l4", home=home, name="limits"
    )


def heavy():
    """A five-bar with a mass and an inertia of its own on each body, and rotors."""
    mechanism, rng = loaded("five_bar"), np.random.default_rng(5)
    model = mechanism.model
    for joint in range(1, model.njoints):
        model.inertias[joint] = pin.Inertia.Random()
        axes = pin.exp3(rng.normal(size=3))
        moments = axes @ np.diag([0.3, 0.4, 0.5]) @ axes.T
        model.inertias[joint] = pin.Inertia(rng.uniform(1, 2), rng.normal(size=3), moments)
    model.armature = rng.uniform(0.1, 0.2, model.nv)
    return transformed.rebuilt(mechanism, model)


MACHINES = {
    **{
        f"{kind.__name__} from {order[0]}": lambda kind=kind, order=order: hinged(kind, order)
        for kind in test_recut.KINDS
        for order in (("hand", "wall"), ("wall", "hand"))
    },
    **{
        f"{kind} base that is {use}": (
            lambda kind=kind, motors=motors: test_base_inputs.walker(kind, motors)
        )
        for kind in test_base_inputs.KINDS
        for use, motors in (("driven", None), ("passive", ["a"]))
    },
    **{
        f"random {kind}": lambda seed=seed: random_machines.random_machine(seed)
        for seed, kind in enumerate(random_machines.KINDS)
    },
    "screws": lambda: test_helical.from_pinocchio(None),
    "screws along x": lambda: test_helical.from_pinocchio("X"),
    "yawing base": mechanisms.yawing_four_bar,
    "spinning rod": mechanisms.rssr,
    "rod": lambda: mechanisms.rssr(rod=False),
    "two motors for one freedom": mechanisms.over_actuated_four_bar,
    "redundant": mechanisms.three_crank_parallelogram,
    "off the origin": lambda: transformed.moved(loaded("three_rps_ss"), ELSEWHERE),
    "planar off the origin": lambda: transformed.moved(loaded("planar_3rpr"), ELSEWHERE),
    "recut": lambda: pj.recut(loaded("three_rps"), "theta1"),
    "with parameters": lambda: pj.load("four_bar", {"l1": 1.2}),
    "with a joint locked": lambda: pj.load("planar_3rpr", locked=["l1"]),
    "without frames": lambda: transformed.with_needed_frames_only(loaded("slider_crank")),
    "names with spaces": lambda: screwed("first joint", "gélenk ∠2", "the tool ✓"),
    "names of SDFormat's": lambda: screwed("world", "a::b", "__tool__"),
    "names of joints and links alike": lambda: screwed("ground", "link one", "tool"),
    "names within names": within,
    "names like sites": like_sites,
    "gears in a chain": lambda: geared(
        (("a", "b"), 2.0, 0.1), (("b", "c"), -0.5, 0.0), (("c", "d"), 3.0, -0.2)
    ),
    "gears from the other side": lambda: geared(
        (("b", "a"), 2.0, 0.1), (("c", "b"), -0.5, 0.3), (("d", "c"), 3.0, -0.2)
    ),
    "limits": limited,
    "masses": heavy,
}

# Published models by path, and what `load` needs to know of each.
PEERS = {
    "urdf_plus/four_bar.urdf": {"tool": "link3"},
    "urdf_plus/six_bar.urdf": {},
    "extended_urdf/5bar_linkage/robot.urdf": {"tool": "effector"},
    "extended_urdf/5bar_linkage_iso3d/robot.urdf": {"tool": "effector"},
    "extended_urdf/robot_delta/robot.urdf": {"tool": "eff"},
    "extended_urdf/cassie_like/robot.urdf": {"tool": "foot"},
    "extended_urdf/digit_like_2legs/robot.urdf": {"tool": "foot"},
    "mjcf/cassie_closed_chain.xml": {
        "actuated": [
            f"{side}-{joint}"
            for side in ("left", "right")
            for joint in ("hip-roll", "hip-yaw", "hip-pitch", "knee", "foot")
        ],
        "tool": "left-foot",
        "locked": [
            "cassie-pelvis_free",
            *(
                f"{side}-{spring}"
                for side in ("left", "right")
                for spring in ("shin", "heel-spring")
            ),
        ],
    },
}


def path_of(folder, to):
    return folder / f"machine{SUFFIXES.get(to, '.urdf')}"


def round_trip(mechanism, to, folder):
    """Export, and what our readers make of it, told of motors and tool what the file does not."""
    exported = pj.export(mechanism, to=to, file=path_of(folder, to))
    again = pj.load(
        exported.paths[0],
        actuated=None if to in TELLING else exported.actuated,
        tolerance=mechanism.spec.tolerance,
        enforce_limits=mechanism.spec.enforce_limits,
    )
    if exported.tool and to != "toml":
        again = again.with_tool(exported.tool if len(exported.tool) > 1 else exported.tool[0])
    return exported, again


def renames(exported, what):
    """What frames, or joints, are called in the file, where they are called otherwise."""
    found = (re.fullmatch(f"{what} '(.*)' is called '(.*)' in the file", n) for n in exported.notes)
    return {match[1]: match[2] for match in found if match}


def places(mechanism, names=None):
    """Where links are at home."""
    model = mechanism.model
    data = model.createData()
    pin.framesForwardKinematics(model, data, mechanism.home.q)
    return {
        (names or {}).get(frame.name, frame.name): data.oMf[k].homogeneous.copy()
        for k, frame in enumerate(model.frames)
        if frame.type in (pin.FrameType.BODY, pin.FrameType.OP_FRAME)
    }


def same(mechanism, again, exported, tolerance=1e-12):
    """One machine: mobility, motors, where links are, J_eq or why there is none."""
    assert again.mobility == mechanism.mobility
    joints = renames(exported, "joint")
    motors = [joints.get(name, name) for name in mechanism.actuated]
    assert sorted(again.actuated) == sorted(motors)
    found = places(again)
    for name, place in places(mechanism, renames(exported, "frame")).items():
        size = 1.0 + np.abs(place).max()
        np.testing.assert_allclose(found[name], place, rtol=0, atol=tolerance * size)
    order = [again.actuated.index(name) for name in motors]
    with contextlib.suppress(pj.NoJacobianError):
        expected = mechanism.home.jacobian().J_eq
        J_eq = again.home.jacobian().J_eq[:, order]
        size = 1.0 + np.abs(expected).max()
        np.testing.assert_allclose(J_eq, expected, rtol=0, atol=tolerance * size)
        return
    with pytest.raises(pj.NoJacobianError):
        again.home.jacobian()
