"""Poses that differ only in bodies turned over unseen are one mode, with the ways counted."""

from __future__ import annotations

import itertools
import json

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.files.urdf.robot import parse_urdf
from pmjac_pin.studies.modes import find
from pmjac_pin.studies.modes.recognition import Recognition
from pmjac_pin.studies.modes.same_machine import _Looks, same_machines
from pmjac_pin.words.modes_report import make_modes_report
from pmjac_pin.words.modes_tables import count, modes_blocks
from pmjac_pin.words.plain import to_json

LONG = ("agile_eye", "delta", "sarrus", "stewart_gough", "stewart_gough_dietmaier", "three_rps")
QUICK = [name for name in mechanisms.CATALOGUE if name not in LONG]
SLOWER = [pytest.param(name, marks=pytest.mark.slow) for name in LONG if name != "delta"]
THETA = [0.4]
QUICKLY = {"proof": False, "unseen": 0.02}


def rusr(tool):
    """The RSSR whose rod hangs on the crank by a cross; its ball is three hinges.

    The cross fits turned over, and so do the hinges of the ball: four ways to each mode. Half of
    them turn the rod over about its own line, felt by "rod_side" only.
    """
    rocker, rod, crank = (mechanisms.RSSR[key] for key in ("rocker", "rod", "crank"))
    joints = [
        ("theta", "revolute", "ground", "crank", (0, 0, 0), (0, 0, 1)),
        ("psi", "revolute", "ground", "rocker", (1.5, 0.5, 0.2), (0, 1, 0)),
        ("ke", "fixed", "crank", "crank_tip", (crank, 0, 0)),
        ("re", "fixed", "rocker", "rocker_tip", (0, 0, rocker)),
        ("rx", "revolute", "rocker_tip", "rod1", (0, 0, 0), (1, 0, 0)),
        ("ry", "revolute", "rod1", "rod2", (0, 0, 0), (0, 1, 0)),
        ("rz", "revolute", "rod2", "rod", (0, 0, 0), (0, 0, 1)),
        ("sway", "revolute", "rod", "cross", (-rod, 0, 0), (0, 0, 1)),
        ("rod_off", "fixed", "rod", "rod_side", (-0.5, 0.1, 0)),
    ]
    model = pin.buildModelFromXML(mechanisms.tree(*joints))
    loop = pj.RevoluteLoop(frames=("cross", "crank_tip"), axis=(0, 1, 0))
    home = {"theta": THETA[0], "psi": 0.2}
    return pj.Mechanism.from_pinocchio(model, [loop], ["theta"], tool, home=home)


def found_of(mechanism, theta, monkeypatch):
    """The modes, and the poses that they were made of."""
    poses = []

    def kept(mechanism, found):
        poses.extend(found)
        return same_machines(mechanism, found)

    monkeypatch.setattr(find, "same_machines", kept)
    return pj.assembly_modes(mechanism, theta, rng=0, **QUICKLY), poses


def same_place(one, other):
    return np.abs(one.tool_pose().homogeneous - other.tool_pose().homogeneous).max() <= 1e-9


def turned_over(pose, legs):
    """The delta with the axles and rods of these legs turned over."""
    q, model = pose.q.copy(), pose.mechanism.model
    for leg in legs:
        for name in (f"elbow{leg}", f"sway{leg}a", f"sway{leg}b", f"level{leg}"):
            entry = model.joints[model.getJointId(name)].idx_q
            q[entry] = q[entry] - np.pi if name.startswith("elbow") else np.pi - q[entry]
    return pose.mechanism.configuration(q)


def deltas(motors=(0.3, 0.45, 0.2)):
    """The delta in the eight ways of one pose."""
    pose = loaded("delta").close(motors)
    subsets = itertools.chain(*(itertools.combinations((1, 2, 3), k) for k in range(4)))
    return [turned_over(pose, legs) for legs in subsets]


def with_axle(delta, visual):
    """The delta with another drawing of the first leg's axle."""
    before, rest = delta.urdf.text.split('<visual name="axle1_bar">')
    drawn = f'{before}<visual name="axle1_bar">{visual}</visual>{rest.split("</visual>", 1)[1]}'
    urdf = parse_urdf(drawn, delta.urdf.path)
    return pj.Mechanism(build_parts(delta.model, delta.spec, dict(delta.parameters), urdf))


@pytest.mark.parametrize(
    ("tool", "count", "ways"), [("rocker_tip", 2, 4), ("rod_side", 4, 2), ("rod", 4, 2)]
)
def test_a_turned_cross_makes_no_mode_unless_the_tool_feels_it(tool, count, ways, monkeypatch):
    modes, poses = found_of(rusr(tool), THETA, monkeypatch)
    assert modes.ways == (ways,) * count
    assert sum(modes.ways) == len(poses) == 8
    assert str(modes.evidence).endswith(
        f"; 8 poses are {count} modes, with bodies turned over unseen"
    )
    for mode, ways_of in zip(modes, modes.poses, strict=True):
        assert ways_of[0] is mode
        for pose in ways_of:
            assert same_place(mode, pose)
            np.testing.assert_allclose(pose.jacobian().J_eq, mode.jacobian().J_eq, atol=1e-9)
    for one, other in itertools.combinations(modes, 2):
        assert not same_place(one, other)


def test_they_are_the_modes_of_the_machine_with_a_distance_in_place_of_the_rod():
    modes = pj.assembly_modes(rusr("rocker_tip"), THETA, rng=0, **QUICKLY)
    expected = pj.assembly_modes(mechanisms.rssr(rod=False), THETA, rng=0)
    assert len(modes) == len(expected) == 2
    for one, other in zip(modes, expected, strict=True):
        assert same_place(one, other)
        np.testing.assert_allclose(one.jacobian().J_eq, other.jacobian().J_eq, atol=1e-9)


def test_neither_seed_nor_rounding_chooses_the_pose_that_stands_for_a_mode():
    mechanism = rusr("rocker_tip")
    one, other = (pj.assembly_modes(mechanism, THETA, rng=seed, **QUICKLY) for seed in (1, 2))
    for mode, again in zip(one, other, strict=True):
        turns = [np.exp(1j * pose.passive) for pose in (mode, again)]
        np.testing.assert_allclose(*turns, atol=1e-9)


def test_every_way_is_known_as_its_mode():
    modes = pj.assembly_modes(rusr("rocker_tip"), THETA, rng=0, **QUICKLY)
    recognition = Recognition(modes)
    for index, poses in enumerate(modes.poses):
        assert {recognition.index(pose) for pose in poses} == {index}


def test_ways_are_shown_where_there_are_several():
    mechanism = rusr("rocker_tip")
    modes = pj.assembly_modes(mechanism, THETA, rng=0, **QUICKLY)
    report = make_modes_report(mechanism, THETA, modes)
    assert [mode["ways"] for mode in json.loads(to_json(report.told()))["modes"]] == [4, 4]
    assert count(report).startswith("2 assembly modes within")
    assert count(report).endswith("; 8 poses, bodies turned over or not.")
    table = next(block for block in modes_blocks(report) if hasattr(block, "rows"))
    assert [row[table.header.index("ways")] for row in table.rows] == ["4", "4"]


def test_the_deltas_legs_turn_over_one_by_one():
    poses = deltas()
    for pose in poses:
        assert pose.residual_norm <= 1e-11
        assert same_place(pose, poses[0])
        np.testing.assert_allclose(pose.jacobian().J_eq, poses[0].jacobian().J_eq, atol=1e-9)
    mechanism = poses[0].mechanism
    [group] = same_machines(mechanism, poses)
    assert (sorted(group), group[0]) == ([*range(8)], 0)
    other = deltas((0.3, 0.45, 0.25))
    assert list(map(len, same_machines(mechanism, [*other, *poses]))) == [8, 8]


@pytest.mark.parametrize(
    ("visual", "groups"),
    [
        ('<geometry><box size="0.01 0.15 0.02"/></geometry>', 1),
        ('<origin xyz="0 0.02 0"/><geometry><box size="0.01 0.15 0.02"/></geometry>', 1),
        ('<origin xyz="0.02 0 0"/><geometry><sphere radius="0.02"/></geometry>', 2),
        ('<origin rpy="0.3 0 0.3"/><geometry><box size="0.01 0.15 0.02"/></geometry>', 2),
        ('<geometry><mesh filename="axle.stl"/></geometry>', 2),
        (
            '<origin rpy="1.5707963 0 0"/><geometry><capsule radius=".01" length=".1"/></geometry>',
            1,
        ),
    ],
)
def test_what_is_drawn_tells_turned_bodies_apart(visual, groups):
    poses = deltas()
    redrawn = with_axle(poses[0].mechanism, visual)
    assert len(same_machines(redrawn, poses)) == groups


@pytest.mark.parametrize("geared", [False, True])
def test_the_axis_of_a_motor_or_a_geared_joint_has_a_sense(geared):
    poses = deltas()
    delta = poses[0].mechanism
    home, spec = delta.home, delta.spec
    sensed = mechanisms.with_motors(delta, (*spec.actuated, "level1"))
    if geared:
        apart = home.joint_values["level1"] - home.joint_values["theta1"]
        gear = pj.JointLoop(joints=("theta1", "level1"), offset=apart)
        sensed = pj.Mechanism.from_pinocchio(
            delta.model, [*spec.loops, gear], spec.actuated, spec.tool.frame, home=home.q
        )
    assert sorted(map(len, same_machines(sensed, poses))) == [4, 4]


@pytest.mark.parametrize(("angle", "same"), [(0.0, True), (np.pi, True), (5e-5, False)])
def test_a_small_turn_is_not_half_a_turn(angle, same):
    """Modes that are about to meet stay two, though a short body moves its points by less."""
    turns = np.array([[pin.exp3(np.array([0.0, 0.0, turn]))] for turn in (0.3, 0.3 + angle)])
    nothing, undrawn = np.zeros((2, 1)), np.zeros((2, 0, 1))
    looks = _Looks(places=nothing, turns=turns, home=turns[0], drawn=undrawn, within=1e-5)
    assert looks.same(0, 1) is same


@pytest.mark.parametrize("name", [*QUICK, *SLOWER])
def test_where_nothing_turns_over_poses_are_modes(name, monkeypatch):
    mechanism = loaded(name)
    modes, poses = found_of(mechanism, mechanism.home.actuated, monkeypatch)
    assert sum(modes.ways) == len(poses) == len(modes)
    assert "turned over unseen" not in str(modes.evidence)


@pytest.mark.slow
def test_the_deltas_four_modes():
    mechanism = loaded("delta")
    modes = pj.assembly_modes(mechanism, mechanism.home.actuated, rng=0)
    assert modes.ways == (8, 8, 8, 8)
    assert str(modes.evidence).endswith("; 32 poses are 4 modes, with bodies turned over unseen")
    assert Recognition(modes).index(mechanism.home) == 3


@pytest.mark.slow
def test_a_proof_counts_the_poses():
    modes = pj.assembly_modes(rusr("rocker_tip"), THETA, rng=0)
    assert modes.evidence.kind == "proof"
    assert "exactly 8, by" in str(modes.evidence)
    assert "; 8 poses are 2 modes" in str(modes.evidence)
