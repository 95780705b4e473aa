"""Following beside and through poses where branches meet, and on machines with close modes."""

from math import acos, atan2, cos, pi, sin, sqrt, tan

import cuspidal
import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj

FLAT = (2.0, 1.0, 2.0, 1.0)  # base, crank, coupler, rocker


def four_bar(base, crank, coupler, rocker):
    names = ("l0", "l1", "l2", "l3")
    return pj.load("four_bar", dict(zip(names, (base, crank, coupler, rocker), strict=True)))


def rocker_angles(lengths, theta):
    """The rocker's angle in both modes, by the triangle of its diagonal; none beyond reach."""
    base, crank, coupler, rocker = lengths
    x, y = base - crank * cos(theta), -crank * sin(theta)
    diagonal = sqrt(x * x + y * y)
    cosine = (coupler**2 - diagonal**2 - rocker**2) / (2.0 * diagonal * rocker)
    if abs(cosine) > 1.0:
        return None
    return [atan2(y, x) + side * acos(cosine) for side in (1.0, -1.0)]


def alike(angle, other):
    return abs(np.remainder(angle - other + pi, 2.0 * pi) - pi)


def test_a_parallelogram_stops_where_it_is_flat_and_tells_both_branches():
    trajectory = pj.follow(four_bar(*FLAT), [[0.9], [4.0]])
    assert trajectory.status == "branch point"
    [event] = trajectory.events
    assert event.t == pytest.approx((pi - 0.9) / 3.1, abs=1e-11)
    assert event.configuration.singularity().kind == "configuration space"
    on, off = event.branches
    assert (on.goes_on, off.goes_on) == (True, False)
    assert not any(branch.turns_back for branch in event.branches)
    # φ = θ, and tan(φ/2) tan(θ/2) constant: φ' = −(l0 − l1) / (l0 + l1) at the flat pose.
    columns = event.configuration.mechanism.problem.partition.columns
    both = [columns["theta1"], columns["phi1"]]
    assert on.velocity[both] / 3.1 == pytest.approx([1.0, 1.0], abs=1e-9)
    assert off.velocity[both] / 3.1 == pytest.approx([1.0, -1.0 / 3.0], abs=1e-9)


def test_poses_ahead_are_of_a_parallelogram_and_of_an_anti_parallelogram():
    [event] = pj.follow(four_bar(*FLAT), [[0.9], [4.0]]).events
    theta, phi = (event.branches[0].ahead.joint_values[name] for name in ("theta1", "phi1"))
    assert alike(theta, phi) < 1e-12
    theta, phi = (event.branches[1].ahead.joint_values[name] for name in ("theta1", "phi1"))
    assert alike(theta, phi) > 1e-4
    assert tan(phi / 2.0) == pytest.approx(-3.0 * tan(theta / 2.0), rel=1e-8)


@pytest.mark.parametrize("waypoints", [[0.9, 4.0], [0.9, pi, 4.0], [0.9, pi, 1.2]])
def test_passing_stays_a_parallelogram(waypoints):
    path = [[theta] for theta in waypoints]
    trajectory = pj.follow(four_bar(*FLAT), path, singularity="pass", samples=50)
    assert trajectory.reached
    assert [event.kind for event in trajectory.events] == ["branch point"]
    theta, phi = trajectory.actuated[:, 0], trajectory.passive[:, 0]
    assert phi == pytest.approx(theta, abs=1e-9)
    assert "passed along the tangent" in trajectory.evidence.statement


def test_the_other_branch_is_followed_from_its_pose_ahead():
    machine = four_bar(*FLAT)
    [event] = pj.follow(machine, [[0.9], [4.0]]).events
    ahead = event.branches[1].ahead
    trajectory = pj.follow(machine, [[float(ahead.actuated[0])], [5.0]], start=ahead)
    assert trajectory.reached
    for theta, phi in zip(trajectory.actuated[:, 0], trajectory.passive[:, 0], strict=True):
        assert tan(phi / 2.0) == pytest.approx(-3.0 * tan(theta / 2.0), rel=1e-6)


@pytest.mark.parametrize("singularity", ["stop", pytest.param("pass", marks=pytest.mark.slow)])
@pytest.mark.parametrize("size", [1e-2, 1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_what_is_almost_a_parallelogram_never_jumps(side, size, singularity):
    """With a longer rocker both modes go on, close to each other; with a shorter one they end."""
    lengths = (2.0, 1.0, 2.0, 1.0 + side * size)
    trajectory = pj.follow(four_bar(*lengths), [[0.9], [4.0]], singularity=singularity)
    if side < 0.0:
        assert trajectory.status == "fold"
        diagonal = 2.0 + (1.0 - size)  # coupler and rocker in line
        ends = acos((5.0 - diagonal**2) / 4.0)
        assert trajectory.events[-1].t == pytest.approx((ends - 0.9) / 3.1, abs=1e-10)
    else:
        assert trajectory.reached
    mode = min(
        (0, 1), key=lambda k: alike(rocker_angles(lengths, 0.9)[k], trajectory.passive[0, 0])
    )
    for theta, phi in np.hstack([trajectory.actuated, trajectory.passive])[:-1, :2]:
        expected = rocker_angles(lengths, theta)
        gaps = [alike(angle, phi) for angle in expected]
        assert gaps[mode] < gaps[1 - mode]
        assert gaps[mode] < 1e-6


def test_newtons_method_alone_jumps_there():
    """What the follower must not do: along the tangent by a tenth of a radian, without a guard."""
    lengths, stride = (2.0, 1.0, 2.0, 1.0 + 1e-6), 0.1
    phi = before = min(rocker_angles(lengths, 0.9), key=lambda angle: alike(angle, 0.9))
    mode = rocker_angles(lengths, 0.9).index(phi)
    for theta in np.arange(0.9, 4.0, stride):
        phi, before = 2.0 * phi - before if theta > 0.9 else phi, phi
        for _ in range(30):
            tip = lengths[3] * np.array([cos(phi), sin(phi)]) - [cos(theta) - 2.0, sin(theta)]
            slope = 2.0 * lengths[3] * tip @ [-sin(phi), cos(phi)]
            phi -= (tip @ tip - 4.0) / slope
    assert alike(rocker_angles(lengths, theta)[1 - mode], phi) < 1e-6


def loop(radius, way, begin=5.1):
    second, third = cuspidal.CUSP
    return lambda t: [
        17.0,
        second + radius * cos(begin + way * t),
        third + radius * sin(begin + way * t),
    ]


def by_hand(path, angles):
    """The same loop by Newton's method on the circles, in steps of 2 π / 800."""
    for t in np.linspace(0.0, 2.0 * pi, 801):
        moved = cuspidal.newton(angles, path(t))
        if moved is None or cuspidal.apart(moved, angles) > 0.05:
            return None
        angles = moved
    return angles


def test_six_modes_three_of_each_sign():
    lengths = (14.98, 15.38, 12.0)
    found = cuspidal.solutions(lengths)
    assert sorted(cuspidal.sign(angles, lengths) for angles in found) == 3 * [-1.0] + 3 * [1.0]
    machine = cuspidal.mechanism(found[0], lengths)
    modes = pj.assembly_modes(machine, lengths)
    assert len(modes) == 6
    for mode in modes:
        angles = cuspidal.angles_of(mode)
        assert min(cuspidal.apart(angles, one) for one in found) < 1e-9


def test_a_loop_about_a_cusp_changes_the_mode():
    outcomes = []
    for way in (1.0, -1.0):
        path = loop(0.3, way)
        lengths = tuple(path(0.0))
        for angles in cuspidal.solutions(lengths):
            machine = cuspidal.mechanism(angles, lengths)
            trajectory = pj.follow(machine, path, times=(0.0, 2.0 * pi))
            expected = by_hand(path, angles)
            if expected is None:
                assert trajectory.status == "fold"
                outcomes.append("fold")
                continue
            assert trajectory.reached
            assert trajectory.events == ()
            end = cuspidal.angles_of(trajectory.end)
            assert cuspidal.apart(end, expected) < 1e-8
            assert cuspidal.sign(end, lengths) == cuspidal.sign(angles, lengths)
            home = trajectory.homecoming
            same = cuspidal.apart(end, angles) < 1e-6
            assert home.same_mode == same
            assert home.cuspidal == (not same)
            outcomes.append(str(home))
    told = "closed in motor values, ends on another assembly mode, met no singular pose"
    assert outcomes.count(f"{told}: a cuspidal machine") == 2
    assert outcomes.count("fold") == 4


def test_a_loop_beside_the_cusp_does_not():
    path = loop(0.3, 1.0)
    lengths = tuple(path(pi))
    for angles in cuspidal.solutions(lengths):
        machine = cuspidal.mechanism(angles, lengths)

        def small(t):
            first, second, third = path(pi)
            return [first, second + 0.05 * sin(t), third + 0.05 * (1.0 - cos(t))]

        trajectory = pj.follow(machine, small, times=(0.0, 2.0 * pi))
        assert trajectory.homecoming.same_mode
        assert "ends on the same assembly mode" in str(trajectory.homecoming)


def test_a_path_that_stays_open_has_no_homecoming():
    assert pj.follow(loaded("four_bar"), [[0.9], [2.0]]).homecoming is None


def test_a_full_turn_comes_home():
    turn = pj.follow(loaded("four_bar"), [[-3.0], [2.0 * pi - 3.0]])
    assert turn.homecoming.same_mode


@pytest.mark.parametrize("off", [3e-11, -5e-10])
def test_a_path_that_is_closed_but_for_rounding_has_come_home(off):
    five = loaded("five_bar")
    home = five.home.actuated
    way = pj.follow(five, [home, home + 0.1, home + off])
    assert way.reached
    assert str(way.homecoming).startswith("closed in motor values, ends on the same assembly mode")
