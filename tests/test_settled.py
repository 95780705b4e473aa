"""What docs/settled.md says of derivations that disagree: the numbers, each by another formula."""

from __future__ import annotations

import re
from pathlib import Path

import hand_derived as hand
import hand_planar as planar
import numpy as np
import pytest
import settled_ankle
import settled_four_bar
import settled_lecture
import settled_six_bar
from test_transmission import motors_by_hand

import pmjac_pin as pj

PAGE = Path(__file__).parent.parent / "docs" / "settled.md"
SHOWN = dict(re.findall(r"^\$ python docs/(\w+)\.py\n(.*?)^```", PAGE.read_text(), re.M | re.S))
SCRIPTS = (settled_ankle, settled_four_bar, settled_lecture, settled_six_bar)


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda script: script.__name__)
def test_the_page_shows_what_the_command_prints(script, capsys):
    script.main()
    assert capsys.readouterr().out == SHOWN[script.__name__]


def test_the_page_shows_no_other_command():
    assert {*SHOWN} == {script.__name__ for script in SCRIPTS}


def test_the_lectures_pose_a_by_its_own_formula():
    mode = np.array(hand.POSE_A_THETA_EXACT)
    (row, column), printed = hand.POSE_A_JW_STAR_MISPRINT
    assert printed == settled_lecture.PRINTED_ENTRY
    entry = hand.rps_Jw_star(hand.POSE_A_L, mode)[row, column]
    assert settled_lecture.entry_by_hand(np.array(hand.POSE_A_L), mode) == pytest.approx(entry)
    assert round(entry, 4) == 0.6686


def test_the_lectures_pose_b_by_its_own_formula():
    assert settled_lecture.PRINTED_VELOCITIES == hand.POSE_B_PRINTED_VELOCITIES
    lengths = np.array(hand.POSE_B_L)
    theta = hand.rps_newton(lengths, hand.POSE_B_THETA, hand.RPS_A)
    expected = np.linalg.svd(hand.rps_equivalent(lengths, theta, hand.RPS_A)[0])[1]
    np.testing.assert_allclose(settled_lecture.velocities_by_hand(lengths, theta), expected)
    pose = pj.load("three_rps_ss").pose("lecture_b")
    np.testing.assert_allclose(pose.jacobian().velocity_ellipsoid().radii, expected, atol=1e-7)


def test_a_four_bars_travel_is_the_law_of_cosines():
    ground, crank, coupler, rocker = lengths = settled_four_bar.lengths_of(settled_four_bar.JOINTS)
    assert coupler + ground > crank + rocker  # s + l, p + q
    assert (coupler + ground) / (crank + rocker) - 1 == pytest.approx(0.0028, abs=5e-5)
    start = settled_four_bar.drawn(settled_four_bar.JOINTS)
    limit, _ = hand.four_bar_crank_limit(lengths)
    assert settled_four_bar.travel(start) == pytest.approx((-limit, limit), abs=1e-8)


def test_it_is_the_four_bar_that_is_drawn():
    """All four joints, and their distances, in the crank's frame."""
    A, B, C, D = (np.array(settled_four_bar.JOINTS[name]) for name in "ABCD")
    start = settled_four_bar.drawn(settled_four_bar.JOINTS)
    x = (D - A) / np.linalg.norm(D - A)
    axes = np.array([x, planar.quarter(x)])
    place = start.with_tool("rocker_tip").tool_pose().translation[:2]
    np.testing.assert_allclose(place, axes @ (C - A), atol=1e-12)
    middle = start.tool_pose().translation[:2]
    np.testing.assert_allclose(middle, axes @ ((B + C) / 2 - A), atol=1e-12)


def test_its_rocker_swings_where_the_crank_passes_the_ground_line():
    lengths = settled_four_bar.lengths_of(settled_four_bar.JOINTS)
    start = settled_four_bar.drawn(settled_four_bar.JOINTS)
    ends = [hand.four_bar_closure(way * np.radians(2.0), lengths, +1)[0] for way in (1.0, -1.0)]
    assert settled_four_bar.swing(start, np.radians(2.0)) == pytest.approx(ends[1] - ends[0])


def test_a_rounded_four_bars_crank_stops_before_the_ground_line():
    joints = {name: tuple(np.round(xy, 1)) for name, xy in settled_four_bar.JOINTS.items()}
    ground, crank, coupler, rocker = settled_four_bar.lengths_of(joints)
    assert coupler + ground < crank + rocker
    stops = [
        np.arccos((ground**2 + crank**2 - across**2) / (2 * ground * crank))
        for across in (rocker - coupler, rocker + coupler)
    ]
    found = settled_four_bar.travel(settled_four_bar.drawn(joints))
    assert found == pytest.approx(stops, abs=1e-8)


@pytest.mark.parametrize(("step", "changes"), [(10.0, 1), (5.0, 1), (2.0, 0), (0.5, 0)])
def test_coarse_steps_change_over_to_the_mirror_image(step, changes):
    found = settled_four_bar.changes_of_side(settled_four_bar.JOINTS, np.radians(step))
    assert len(found) == changes


@pytest.mark.parametrize(("point", "frame"), settled_six_bar.FRAMES.items())
def test_a_six_bars_accelerations_by_differences_of_its_velocities(point, frame):
    """Of the formulas by hand, on circles about A and G that meet anew at each angle."""
    points = {name: np.array([p.real, p.imag]) for name, p in settled_six_bar.POINTS.items()}

    def turned(angle):
        found = dict(points)
        arm = points["B"] - points["A"]
        found["B"] = points["A"] + np.cos(angle) * arm + np.sin(angle) * planar.quarter(arm)
        for new, first, second in (
            ("C", "B", "G"),
            ("D", "B", "C"),
            ("F", "G", "C"),
            ("E", "D", "F"),
        ):
            p, q, r = points[first], points[second], points[new]
            side = np.sign(planar.quarter(q - p) @ (r - p))
            distances = np.linalg.norm(r - p), np.linalg.norm(r - q)
            found[new] = planar.meet(found[first], found[second], *distances, side)
        return planar.watt_six_bar(found)[0][point]

    h, crank = 1e-5, settled_six_bar.CRANK
    expected = crank**2 * (turned(h) - turned(-h)) / (2 * h)
    pose = settled_six_bar.six_bar()
    velocity, _, acceleration, _ = settled_six_bar.twist_and_rate(pose, frame)
    np.testing.assert_allclose([acceleration.real, acceleration.imag], expected, rtol=1e-7)
    by_hand = crank * planar.watt_six_bar(points)[0][point]
    np.testing.assert_allclose([velocity.real, velocity.imag], by_hand, rtol=1e-10)


@pytest.mark.parametrize("joints", [(0.0, 0.0), (0.1, 0.05), (-0.3, 0.1)])
def test_an_ankles_torque_map_by_differences_of_its_motors(joints):
    h = 1e-5
    ratio = [
        (motors_by_hand(*(joints + step)) - motors_by_hand(*(joints - step))) / (2 * h)
        for step in h * np.eye(2)
    ]
    motors = motors_by_hand(*joints)
    np.testing.assert_allclose(settled_ankle.by_virtual_work(joints, motors), ratio, atol=1e-9)
    assert np.abs(settled_ankle.with_short_arms(joints, motors) - ratio).max() > 0.01
