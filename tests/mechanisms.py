"""Mechanisms for tests: built from a list of joints, each for one property."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import pi

import numpy as np
import pinocchio as pin
import pytest

import pmjac_pin as pj

CRANK_ROCKER = (4.0, 1.0, 3.0, 3.5)  # l0, l1, l2, l3
CATALOGUE = (
    "agile_eye",
    "ankle",
    "bennett",
    "bricard",
    "delta",
    "delta_rods",
    "five_bar",
    "four_bar",
    "head_6rss",
    "humanoid_ankle",
    "planar_3rpr",
    "planar_3rrr",
    "sarrus",
    "serial_2r",
    "slider_crank",
    "stewart_gough",
    "stewart_gough_dietmaier",
    "three_rps",
    "three_rps_ss",
    "ur5",
    "watt_six_bar",
)
OPEN = ("serial_2r", "ur5")
CLOSED = tuple(name for name in CATALOGUE if name not in OPEN)
PARAMETRISED = tuple(name for name in CATALOGUE if name not in {"stewart_gough_dietmaier", "ur5"})


NON_GRASHOF = (4.0, 3.0, 2.5, 2.0)


# Of each kind of loop and of each freedom at least one: what long laws are tried on in the quick
# tests; the others are left to the slow ones.
SAMPLE = (
    "agile_eye",
    "ankle",
    "bennett",
    "five_bar",
    "serial_2r",
    "slider_crank",
    "stewart_gough",
    "three_rps_ss",
)


def mostly_slow(cases, quick=SAMPLE):
    """Cases for `parametrize`, of one value or a tuple, of which all but the quick are slow."""
    return [
        pytest.param(
            *(case if isinstance(case, tuple) else (case,)),
            marks=[] if case in quick else pytest.mark.slow,
        )
        for case in cases
    ]


@cache
def _once(name):
    return pj.load(name)


def loaded(name):
    """A catalogue machine, read and assembled once for all tests: nothing changes what it is.

    What it learns by being used, its programs and its closed poses, each test begins without.
    """
    return replace(_once(name), _poses={}, _made={})


@cache
def homotopy_of(name, seed=0):
    """All complex solutions, once for all tests: it takes seconds, and nothing changes it."""
    return pj.parameter_homotopy(loaded(name), rng=seed)


def rocker_rocker():
    """A four-bar whose crank cannot turn fully."""
    return pj.load("four_bar", dict(zip(("l0", "l1", "l2", "l3"), NON_GRASHOF, strict=True)))


def tree(*joints):
    """URDF of a tree; a joint is (name, type, parent, child, xyz, axis or None, rpy)."""
    links = dict.fromkeys(link for joint in joints for link in (joint[2], joint[3]))
    lines = ['<robot name="test">', *(f'<link name="{link}"/>' for link in links)]
    for name, kind, parent, child, xyz, *rest in joints:
        axis, rpy = (*rest, None, None)[:2]
        lines.append(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{" ".join(map(repr, xyz))}" '
            f'rpy="{" ".join(map(repr, rpy or (0, 0, 0)))}"/>'
        )
        if axis:
            lines.append(f'<axis xyz="{" ".join(map(repr, axis))}"/>')
        if kind in {"revolute", "prismatic"}:
            lines.append('<limit lower="-100" upper="100" effort="1" velocity="1"/>')
        lines.append("</joint>")
    return "\n".join([*lines, "</robot>"])


def build(joints, loops, actuated, tool, home, passive=None):
    model = pin.buildModelFromXML(tree(*joints))
    closures = [pj.PointLoop(frames=frames) for frames in loops]
    return pj.Mechanism.from_pinocchio(
        model, closures, actuated, tool, passive=passive, home=home, name="test"
    )


Z = (0, 0, 1)


def four_bar_cut_at(joint, theta1, phi, lengths=CRANK_ROCKER):
    """The four-bar cut at joint A (motor), B (crank-coupler), C (coupler-rocker) or D (rocker)."""
    l0, l1, l2, l3 = lengths
    phi1, phi2 = phi
    coupler, inner = theta1 + phi2, phi1 - theta1 - phi2  # coupler's angle; rocker from coupler
    middle = ("mid", "fixed", "coupler", "tool")
    match joint:
        case "C":
            joints = [
                ("theta1", "revolute", "ground", "crank", (0, 0, 0), Z),
                ("b", "revolute", "crank", "coupler", (l1, 0, 0), Z),
                ("d", "revolute", "ground", "rocker", (l0, 0, 0), Z),
                ("ce", "fixed", "coupler", "C1", (l2, 0, 0)),
                ("re", "fixed", "rocker", "C2", (l3, 0, 0)),
                (*middle, (l2 / 2, 0, 0)),
            ]
            home = {"theta1": theta1, "b": phi2, "d": phi1}
            loops = [("C1", "C2")]
        case "D":
            joints = [
                ("theta1", "revolute", "ground", "crank", (0, 0, 0), Z),
                ("b", "revolute", "crank", "coupler", (l1, 0, 0), Z),
                ("c", "revolute", "coupler", "rocker", (l2, 0, 0), Z),
                ("re", "fixed", "rocker", "D1", (-l3, 0, 0)),
                ("ge", "fixed", "ground", "D2", (l0, 0, 0)),
                (*middle, (l2 / 2, 0, 0)),
            ]
            home = {"theta1": theta1, "b": phi2, "c": inner}
            loops = [("D1", "D2")]
        case "B":
            joints = [
                ("theta1", "revolute", "ground", "crank", (0, 0, 0), Z),
                ("d", "revolute", "ground", "rocker", (l0, 0, 0), Z),
                ("c", "revolute", "rocker", "coupler", (l3, 0, 0), Z),
                ("ke", "fixed", "crank", "B1", (l1, 0, 0)),
                ("ce", "fixed", "coupler", "B2", (-l2, 0, 0)),
                (*middle, (-l2 / 2, 0, 0)),
            ]
            home = {"theta1": theta1, "d": phi1, "c": -inner}
            loops = [("B1", "B2")]
        case "A":
            # The motor keeps its hub; hub and crank are joined again at two points, which
            # makes three of six rows redundant.
            joints = [
                ("theta1", "revolute", "ground", "hub", (0, 0, 0), Z),
                ("d", "revolute", "ground", "rocker", (l0, 0, 0), Z),
                ("c", "revolute", "rocker", "coupler", (l3, 0, 0), Z),
                ("b", "revolute", "coupler", "crank", (-l2, 0, 0), Z),
                ("he", "fixed", "hub", "H1", (0, 0, 0)),
                ("hf", "fixed", "hub", "H2", (l1, 0, 0)),
                ("ke", "fixed", "crank", "K1", (-l1, 0, 0)),
                (*middle, (-l2 / 2, 0, 0)),
            ]
            home = {"theta1": theta1, "d": phi1, "c": coupler - phi1, "b": theta1 - coupler}
            loops = [("K1", "H1"), ("crank", "H2")]
    return build(joints, loops, ["theta1"], "tool", home)


def yawing_four_bar():
    """A vertical planar four-bar on a base that yaws: the redundant row turns with it."""
    l0, l1, l2, l3 = CRANK_ROCKER
    upright = (pi / 2, 0, 0)
    joints = [
        ("yaw", "revolute", "world", "ground", (0, 0, 0), Z),
        ("theta1", "revolute", "ground", "crank", (0, 0, 0), Z, upright),
        ("phi2", "revolute", "crank", "coupler", (l1, 0, 0), Z),
        ("phi1", "revolute", "ground", "rocker", (l0, 0, 0), Z, upright),
        ("ce", "fixed", "coupler", "C1", (l2, 0, 0)),
        ("re", "fixed", "rocker", "C2", (l3, 0, 0)),
        ("mid", "fixed", "coupler", "tool", (l2 / 2, 0, 0)),
    ]
    home = {"theta1": 0.9, "phi1": 2.0236, "phi2": 0.0075}
    passive = ["phi1", "phi2"]
    return build(joints, [("C1", "C2")], ["yaw", "theta1"], "tool", home, passive)


RSSR = {"crank": 0.6, "rod": 2.0, "rocker": 1.5}


def rssr(tool="rocker_tip", rod=True):
    """Crank and rocker about skew axes, joined by an S-S rod: as a body, or as a distance.

    The rod turns about itself, felt by "rod_side" (off its axis), not by the rocker.
    """
    joints = [
        ("theta", "revolute", "ground", "crank", (0, 0, 0), Z),
        ("psi", "revolute", "ground", "rocker", (1.5, 0.5, 0.2), (0, 1, 0)),
        ("ke", "fixed", "crank", "crank_tip", (RSSR["crank"], 0, 0)),
        ("re", "fixed", "rocker", "rocker_tip", (0, 0, RSSR["rocker"])),
    ]
    start = {"theta": 0.4, "psi": 0.2}
    if not rod:
        model = pin.buildModelFromXML(tree(*joints))
        loop = pj.DistanceLoop(frames=("crank_tip", "rocker_tip"), length=RSSR["rod"])
        return pj.Mechanism.from_pinocchio(model, [loop], ["theta"], tool, home=start)
    joints += [
        ("rx", "revolute", "crank_tip", "rod1", (0, 0, 0), (1, 0, 0)),
        ("ry", "revolute", "rod1", "rod2", (0, 0, 0), (0, 1, 0)),
        ("rz", "revolute", "rod2", "rod", (0, 0, 0), Z),
        ("rod_end", "fixed", "rod", "rod_tip", (RSSR["rod"], 0, 0)),
        ("rod_off", "fixed", "rod", "rod_side", (1.0, 0.1, 0)),
    ]
    return build(joints, [("rod_tip", "rocker_tip")], ["theta"], tool, start)


def three_crank_parallelogram():
    """Three equal parallel cranks carry one coupler: Grübler says 0, the mobility is 1."""
    joints = [
        ("theta1", "revolute", "ground", "crank1", (0, 0, 0), Z),
        ("theta2", "revolute", "ground", "crank2", (1, 0, 0), Z),
        ("theta3", "revolute", "ground", "crank3", (2.5, 0, 0), Z),
        ("beta", "revolute", "crank1", "coupler", (0.7, 0, 0), Z),
        ("c2", "fixed", "crank2", "tip2", (0.7, 0, 0)),
        ("c3", "fixed", "crank3", "tip3", (0.7, 0, 0)),
        ("p2", "fixed", "coupler", "point2", (1, 0, 0)),
        ("p3", "fixed", "coupler", "point3", (2.5, 0, 0)),
    ]
    home = {"theta1": 1.0, "theta2": 1.0, "theta3": 1.0, "beta": -1.0}
    return build(joints, [("point2", "tip2"), ("point3", "tip3")], ["theta1"], "point3", home)


def with_motors(mechanism, motors, **others):
    """The same machine at the same home, with other motors."""
    arguments = {"home": mechanism.home.q, **others}
    tool = mechanism.spec.tool.frame
    return pj.Mechanism.from_pinocchio(
        mechanism.model, mechanism.spec.loops, motors, tool, **arguments
    )


def over_actuated_four_bar():
    """Two motors on one degree of freedom."""
    return with_motors(loaded("four_bar"), ["theta1", "phi1"])


def random_closed(mechanism, rng, count, spread=0.3, start="home"):
    """Closed poses by a random walk of the motors; steps that cannot be closed are drawn anew."""
    configuration, found = mechanism.pose(start), []
    while len(found) < count:
        target = configuration.actuated + rng.uniform(-spread, spread, len(mechanism.actuated))
        try:
            configuration = mechanism.close(target, guess=configuration)
        except (pj.ClosureError, pj.LimitError):
            continue
        found.append(configuration)
    return found


def random_poses(name, seed, count):
    mechanism = loaded(name)
    rng = np.random.default_rng(seed)
    starts = mechanism.poses
    return [
        configuration
        for start in starts
        for configuration in random_closed(mechanism, rng, -(-count // len(starts)), start=start)
    ][:count]
