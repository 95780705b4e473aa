"""Proofs that all assembly modes are known, against closed forms, the lecture and the search."""

from __future__ import annotations

import re

import hand_derived as hand
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.studies.modes.branch_and_prune import Budget


def proof_of(mechanism, motors, limits=False, budget=None):
    return pj.prove(mechanism, motors, limits=limits, budget=budget)


def middles(proof):
    return np.array([one.mode.middle for one in proof.enclosures]).reshape(-1, len(proof.names))


def unknowns(proof, configuration):
    return [configuration.joint_values[name] for name in proof.names]


def assert_one_to_one(proof, configurations):
    rows = [unknowns(proof, configuration) for configuration in configurations]
    found = proof.match(np.reshape(rows, (-1, len(proof.names))))
    assert None not in found
    assert sorted(found) == list(range(len(proof.enclosures)))


# --- Numbers -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["three_rps_ss", "three_rps"])
@pytest.mark.parametrize(
    ("lengths", "count"),
    [((2 / 3, 3 / 5, 3 / 4), 8), ((0.5, 1.0, 2.0), 4), ((3.0, 3.0, 3.0), 16), ((5.0, 1.0, 1.0), 0)],
)
def test_the_three_rps(name, lengths, count):
    proof = proof_of(loaded(name), lengths)
    assert proof
    assert len(proof.enclosures) == count
    assert proof.evidence.statement.startswith(f"exactly {count}, by interval arithmetic")


def test_the_lectures_modes():
    proof = proof_of(loaded("three_rps_ss"), hand.POSE_A_L)
    modes = np.array(hand.POSE_A_MODES)
    expected = np.vstack([modes, -modes])
    found = middles(proof)
    for row in expected:
        assert np.abs(found - row).max(axis=1).min() < 1e-8
    assert sorted(proof.match(expected)) == list(range(8))


NAMED = {
    "four_bar": ([0.9], 2),
    "five_bar": ([2.1874829, 0.95410976], 2),
    "slider_crank": ([0.9], 2),
    "planar_3rpr": ([0.34, 0.34, 0.34], 2),
    "planar_3rrr": ([1.0, 1.0, 1.0], 2),
    "watt_six_bar": ([0.9], 4),
    "bennett": ([1.0], 1),
    "agile_eye": ([0.0, 0.0, 0.0], 8),
    "ankle": ([0.0, 0.0], 4),
    "three_rps": ([0.9, 1.0, 1.1], 8),
    "three_rps_ss": ([0.9, 1.0, 1.1], 8),
}


@pytest.mark.parametrize("name", mechanisms.mostly_slow(NAMED, set(NAMED) - {"agile_eye"}))
def test_the_search_found_all_that_is_proven(name):
    motors, count = NAMED[name]
    mechanism = loaded(name)
    proof = proof_of(mechanism, motors, limits=True)
    assert proof
    assert len(proof.enclosures) == count
    assert_one_to_one(proof, pj.assembly_modes(mechanism, motors, rng=0))


@pytest.mark.parametrize("name", NAMED)
def test_proven_modes_are_configurations(name):
    motors, _ = NAMED[name]
    mechanism = loaded(name)
    proof = proof_of(mechanism, motors)
    for q, enclosure in zip(proof.q, proof.enclosures, strict=True):
        configuration = mechanism.configuration(q)
        np.testing.assert_array_equal(configuration.actuated, motors)
        assert enclosure.mode.width.max() < 1e-10
        assert enclosure.around.width.min() > 1e-4
        assert enclosure.mode.inside(enclosure.around).all()
        assert enclosure.left_out <= 1.0


# Innocenti and Parenti-Castelli (1992): base and platform that are not alike.
SIX = {"base": [(0, 0), (15.91, 0), (0, 10)], "sides": (17.04, 20.84, 16.54)}
SIX_LEGS = (14.98, 15.38, 12.0)


def three_rpr(base, sides):
    """Planar 3-RPR with these fixed joints, and platform sides 12, 13, 23."""
    s12, s13, s23 = sides
    x = (s12**2 + s13**2 - s23**2) / (2 * s12)
    points = [(0, 0), (s12, 0), (x, float(np.sqrt(s13**2 - x**2)))]
    joints = []
    for k, (at, point) in enumerate(zip(base, points, strict=True)):
        joints += [
            (f"theta{k}", "continuous", "ground", f"leg{k}", (*at, 0), (0, 0, 1)),
            (f"l{k}", "prismatic", f"leg{k}", f"rod{k}", (0, 0, 0), (1, 0, 0)),
        ]
        if k == 0:
            joints.append(("platform", "planar", "ground", "plate", (0, 0, 0), (0, 0, 1)))
        joints.append((f"plate{k}", "fixed", "plate", f"P{k}", (*point, 0)))
    home = {"l0": 15, "l1": 15, "l2": 15, "platform": (-4.0, 14.0, 0.1)}
    loops = [(f"P{k}", f"rod{k}") for k in range(3)]
    return mechanisms.build(joints, loops, ["l0", "l1", "l2"], "plate", home)


def test_a_planar_three_rpr_has_six_modes():
    mechanism = three_rpr(SIX["base"], SIX["sides"])
    proof = proof_of(mechanism, SIX_LEGS)
    assert proof
    assert len(proof.enclosures) == 6
    assert_one_to_one(proof, pj.assembly_modes(mechanism, SIX_LEGS, rng=0))


@pytest.mark.parametrize(("name", "joint"), [("planar_3rpr", "platform"), ("slider_crank", "x")])
def test_the_number_does_not_depend_on_the_cut(name, joint):
    motors, count = NAMED[name]
    recut = pj.recut(loaded(name), joint)
    proof = proof_of(recut, motors)
    assert (bool(proof), len(proof.enclosures)) == (True, count)
    assert_one_to_one(proof, pj.assembly_modes(recut, motors, rng=0))


# --- Random ones ---------------------------------------------------------------------------------


def random_four_bars(count, rng):
    for _ in range(count):
        yield rng.uniform(0.3, 3.0, 4), rng.uniform(-np.pi, np.pi)


@pytest.mark.slow
def test_random_four_bars_against_the_closed_form(rng):
    counts = set()
    for lengths, theta1 in random_four_bars(40, rng):
        try:
            expected = [hand.four_bar_closure(theta1, lengths, branch) for branch in (1, -1)]
        except ValueError:
            expected = []
        names = ("l0", "l1", "l2", "l3")
        try:
            mechanism = pj.load("four_bar", dict(zip(names, lengths.tolist(), strict=True)))
        except pj.ClosureError:
            continue  # there is no pose near the model's home
        proof = proof_of(mechanism, [theta1])
        assert proof
        counts.add(len(expected))
        assert len(proof.enclosures) == len(expected)
        found = np.exp(1j * middles(proof))
        for row in expected:
            assert np.abs(found - np.exp(1j * np.array(row))).max(axis=1).min() < 1e-11
    assert counts == {0, 2}


@pytest.mark.parametrize("count", [2, pytest.param(12, marks=pytest.mark.slow)])
def test_random_three_rps_against_the_search(count, rng):
    mechanism = loaded("three_rps_ss")
    for _ in range(count):
        lengths = rng.uniform(0.3, 2.0, 3)
        proof = proof_of(mechanism, lengths)
        assert proof
        assert_one_to_one(proof, pj.assembly_modes(mechanism, lengths, rng=rng, proof=False))


# --- What is exact, and what holds to the tolerance ----------------------------------------------


def test_rows_that_are_left_out_are_named_by_those_that_are_kept():
    for enclosure in proof_of(loaded("four_bar"), [0.9]).enclosures:
        assert enclosure.kept == ("coupler_tip-rocker_tip x", "coupler_tip-rocker_tip y")
        assert enclosure.left_out < 1e-3


def test_the_rows_kept_are_seen_from_the_body_that_carries_the_loop():
    mechanism = mechanisms.yawing_four_bar()
    for yaw in (0.0, 0.7, np.pi / 2):
        proof = proof_of(mechanism, [yaw, 0.9])
        assert (bool(proof), len(proof.enclosures)) == (True, 2)
        assert_one_to_one(proof, pj.assembly_modes(mechanism, [yaw, 0.9], rng=0))
        kept = {enclosure.kept for enclosure in proof.enclosures}
        assert kept == {("C1-C2 x", "C1-C2 z")}


def test_three_of_six_rows_redundant():
    phi = hand.four_bar_closure(0.9, mechanisms.CRANK_ROCKER, 1)
    proof = proof_of(mechanisms.four_bar_cut_at("A", 0.9, phi), [0.9])
    assert (bool(proof), len(proof.enclosures)) == (True, 2)


def test_half_a_turn_from_closure_is_no_mode():
    """Bricard's hinge also has poses where its axis points the other way."""
    mechanism = loaded("bricard")
    for motor in (0.0, 0.3):
        proof = proof_of(mechanism, [motor])
        assert (bool(proof), len(proof.enclosures)) == (True, 2)
        assert all(mechanism.configuration(q).residual_norm < 1e-12 for q in proof.q)


# --- The edges of the domain ---------------------------------------------------------------------


def test_limits_beyond_a_full_turn_count_no_mode_twice():
    """The test trees' joints have limits of ±100 rad."""
    mechanism = mechanisms.yawing_four_bar()
    assert mechanism.limits("phi1") == (-100.0, 100.0)
    assert len(proof_of(mechanism, [0.0, 0.9], limits=True).enclosures) == 2


@pytest.mark.parametrize("column", [0, 1])
@pytest.mark.parametrize("offset", [0.0, 1e-16, -1e-9, 1e-6])
def test_a_mode_where_the_full_turn_is_cut_is_neither_lost_nor_counted_twice(column, offset):
    """The cut is at −3 rad: a four-bar is made whose rocker or coupler is there, or very nearly."""
    l0, l1, theta1, wanted = 4.0, 1.7, 0.9, -3.0 + offset
    crank_tip, link = l1 * np.exp(1j * theta1), 2.5
    if column == 0:
        rocker_tip = l0 + link * np.exp(1j * wanted)
        lengths = (l0, l1, abs(rocker_tip - crank_tip), link)
    else:
        coupler_tip = crank_tip + link * np.exp(1j * (theta1 + wanted))
        lengths = (l0, l1, link, abs(coupler_tip - l0))
    mechanism = pj.load("four_bar", dict(zip(("l0", "l1", "l2", "l3"), lengths, strict=True)))
    proof = proof_of(mechanism, [theta1])
    assert (bool(proof), len(proof.enclosures)) == (True, 2)
    expected = [hand.four_bar_closure(theta1, lengths, branch) for branch in (1, -1)]
    assert min(abs(row[column] - wanted) for row in expected) < 1e-12
    assert sorted(proof.match(expected)) == [0, 1]


def limited_three_rps(lower, upper):
    mechanism = loaded("three_rps_ss")
    model = mechanism.model
    for name in ("theta1", "theta2", "theta3"):
        entry = model.joints[model.getJointId(name)].idx_q
        model.lowerPositionLimit[entry], model.upperPositionLimit[entry] = lower, upper
    loops = [
        pj.DistanceLoop(frames=pair, length=np.sqrt(0.75))
        for pair in (("S1", "S2"), ("S2", "S3"), ("S3", "S1"))
    ]
    home = dict.fromkeys(("l1", "l2", "l3"), 1.0) | dict.fromkeys(
        ("theta1", "theta2", "theta3"), np.pi / 3
    )
    return pj.Mechanism.from_pinocchio(
        model, loops, ["l1", "l2", "l3"], ["S1", "S2", "S3"], home=home
    )


def test_limits_leave_modes_out():
    mechanism = limited_three_rps(0.0, 2.0)
    assert len(proof_of(mechanism, hand.POSE_A_L, limits=True).enclosures) == 2
    assert len(proof_of(mechanism, hand.POSE_A_L, limits=False).enclosures) == 8


def test_a_mode_on_a_limit_counts():
    exact = proof_of(loaded("three_rps_ss"), hand.POSE_A_L)
    top = max(row.max() for row in middles(exact))
    inside = proof_of(limited_three_rps(-2.0, top), hand.POSE_A_L, limits=True)
    assert (bool(inside), len(inside.enclosures)) == (True, 8)
    outside = proof_of(limited_three_rps(-2.0, top - 1e-6), hand.POSE_A_L, limits=True)
    assert (bool(outside), len(outside.enclosures)) == (True, 7)


@pytest.mark.parametrize("half", [0.0, 5e-13])
def test_a_mode_that_may_be_beyond_a_limit_is_not_settled(half):
    """Poses count as within a limit up to 1e-9 beyond it; this one is right there."""
    exact = proof_of(loaded("three_rps_ss"), hand.POSE_A_L)
    top = max(row.max() for row in middles(exact)) - 1e-9 + half
    proof = proof_of(limited_three_rps(-2.0, top), hand.POSE_A_L, limits=True)
    assert not proof or len(proof.enclosures) == 8
    assert len(proof.enclosures) + len(proof.unsettled.lower) == 8


def test_slides_without_limits_are_bounded_by_their_loop():
    slider = loaded("slider_crank")
    model = slider.model
    entry = model.joints[model.getJointId("x")].idx_q
    model.lowerPositionLimit[entry], model.upperPositionLimit[entry] = -np.inf, np.inf
    free = pj.Mechanism.from_pinocchio(
        model, slider.spec.loops, ["theta"], "piston", home={"theta": 0.9, "beta": -1.2, "x": 1.0}
    )
    for limits in (True, False):
        proof = proof_of(free, [0.9], limits)
        assert (bool(proof), len(proof.enclosures)) == (True, 2)


# --- What cannot be settled ----------------------------------------------------------------------


def test_a_double_root_is_not_settled():
    lengths = mechanisms.NON_GRASHOF
    theta1, phi = hand.four_bar_crank_limit(lengths)
    proof = proof_of(mechanisms.rocker_rocker(), [theta1])
    assert not proof
    assert proof.enclosures == ()
    assert len(proof.unsettled.lower) <= 2
    assert proof.unsettled.widened(1e-6).holds(phi).all(axis=1).any()
    assert re.match("(one box|2 boxes) may hold modes or none", proof.failed)


@pytest.mark.parametrize("beyond", [1e-3, 1e-6])
def test_next_to_a_double_root_there_are_two_or_none(beyond):
    theta1, _ = hand.four_bar_crank_limit(mechanisms.NON_GRASHOF)
    mechanism = mechanisms.rocker_rocker()
    for motor, count in ((theta1 - beyond, 2), (theta1 + beyond, 0)):
        proof = proof_of(mechanism, [motor])
        assert (bool(proof), len(proof.enclosures)) == (True, count)


@pytest.mark.slow
def test_a_double_root_of_the_three_rps_is_not_settled(rng):
    mechanism = loaded("three_rps_ss")
    for lengths, theta in hand.rps_singular_poses(rng, 2):
        proof = proof_of(mechanism, lengths)
        assert not proof
        assert any(box for box in proof.unsettled.widened(1e-5).holds(theta).all(axis=1))
        modes = pj.assembly_modes(mechanism, lengths, rng=0, limits=False)
        assert len(proof.enclosures) < len(modes) + 2


def test_a_flat_parallelogram_is_not_settled():
    mechanism = pj.load("four_bar", {"l0": 2.0, "l1": 1.0, "l2": 2.0, "l3": 1.0})
    proof = proof_of(mechanism, [0.0])
    assert not proof
    assert proof.unsettled.widened(1e-5).holds([0.0, 0.0]).all(axis=1).any()


def test_a_pose_that_moves_with_locked_motors_is_not_settled():
    """A rhombus whose crank lies on the ground: rocker and coupler turn together about one end."""
    mechanism = pj.load("four_bar", dict.fromkeys(("l0", "l1", "l2", "l3"), 1.0))
    proof = proof_of(mechanism, [0.0], budget=Budget(boxes=5000))
    assert not proof
    for angle in (-2.0, 0.5, 1.0):
        assert proof.unsettled.widened(1e-9).holds([angle, angle]).all(axis=1).any()


@pytest.mark.parametrize("budget", [Budget(boxes=20), Budget(seconds=0.0)])
def test_a_spent_budget_is_said(budget):
    proof = proof_of(loaded("three_rps_ss"), hand.POSE_A_L, budget=budget)
    assert not proof
    assert "not looked at within the budget" in proof.failed
    for row in hand.POSE_A_MODES:
        assert proof.unsettled.holds(row).all(axis=1).any()


def geared():
    joints = [
        ("one", "revolute", "ground", "a", (0, 0, 0), (0, 0, 1)),
        ("two", "revolute", "ground", "b", (1, 0, 0), (0, 0, 1)),
    ]
    model = pin.buildModelFromXML(mechanisms.tree(*joints))
    loop = pj.JointLoop(joints=("one", "two"), ratio=2.0)
    return pj.Mechanism.from_pinocchio(model, [loop], ["one"], "b")


@pytest.mark.parametrize(
    ("mechanism", "motors", "why"),
    [
        (geared, [0.3], "joints 'one' and 'two' are geared"),
        (mechanisms.rssr, [0.4], "passive joints can move with all motors locked"),
        (
            lambda: pj.recut(loaded("five_bar"), "phi1"),
            [2.1874829, 0.95410976],
            "passive joint 'tip-tip2' is spherical",
        ),
    ],
)
def test_where_intervals_do_not_apply_this_is_said(mechanism, motors, why):
    proof = proof_of(mechanism(), motors)
    assert (bool(proof), proof.enclosures, proof.q.shape[0]) == (False, (), 0)
    assert str(proof.evidence).startswith(f"nothing: {why}")


def test_an_open_chain_has_one_mode():
    mechanism = loaded("serial_2r")
    proof = proof_of(mechanism, [0.3, 0.4])
    assert (bool(proof), len(proof.enclosures)) == (True, 1)
    np.testing.assert_array_equal(mechanism.configuration(proof.q[0]).actuated, [0.3, 0.4])


def test_match_finds_nothing_between_modes():
    proof = proof_of(loaded("four_bar"), [0.9])
    first = middles(proof)[0]
    assert proof.match([first, first + 1.0, first + 2.0 * np.pi]) == (0, None, 0)
