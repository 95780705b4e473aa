"""Certified following: what is proven holds, and what jumps is never proven."""

from math import acos, atan2, cos, pi, sin

import numpy as np
import pytest
from mechanisms import CATALOGUE, loaded, mostly_slow, over_actuated_four_bar, rocker_rocker, rssr
from test_follow import wavy
from test_follow_branches import alike, four_bar, rocker_angles

import pmjac_pin as pj
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.given_path import motor_path
from pmjac_pin.studies.follow.step import CoveredStep, hermite
from pmjac_pin.studies.follow.stretch import PathPose
from pmjac_pin.studies.follow.tubes import PathProof

SLOW = pytest.mark.slow
SIZES = (0.3, 1e-4, 1e-6, 1e-8)


@pytest.mark.parametrize("name", mostly_slow(CATALOGUE, quick=("bennett", "five_bar")))
def test_steps_are_proven_over_the_catalogue(name):
    mechanism = loaded(name)
    trajectory = pj.follow(mechanism, wavy(mechanism), times=(0.0, 3.0), certified=True)
    assert trajectory.reached, trajectory.reason
    assert trajectory.evidence.kind == "proof"
    assert len(trajectory.radii) == len(trajectory.steps) - 1
    assert (trajectory.radii > 0.0).all()


def test_the_closed_form_is_within_the_tubes():
    """The rocker by its triangle, against the cubics between the poses of the steps."""
    lengths = (4.0, 1.0, 3.0, 3.5)
    machine = loaded("four_bar")
    trajectory = pj.follow(machine, [[0.9], [6.0]], certified=True)
    assert trajectory.reached
    column = machine.problem.partition.passive[0]
    first = [alike(angle, trajectory.passive[0, 0]) for angle in rocker_angles(lengths, 0.9)]
    mode, near = int(np.argmin(first)), []
    for k, radius in enumerate(trajectory.radii):
        width = trajectory.t[k + 1] - trajectory.t[k]
        ends, slopes = trajectory.q[k : k + 2, column], trajectory.v[k : k + 2, column]
        for s in (0.1, 0.3, 0.5, 0.8):
            cubic = ends[0] + hermite(s, ends[1] - ends[0], *(width * slopes))
            theta = 0.9 + 5.1 * (trajectory.t[k] + s * width)
            exact = rocker_angles(lengths, theta)
            far = alike(exact[mode], cubic)
            assert far <= radius
            assert alike(exact[1 - mode], cubic) > radius
            near.append(far / radius)
    assert max(near) > 1e-3  # the tubes are no wider than they have to be


@pytest.mark.parametrize("size", [1e-4, *(pytest.param(x, marks=SLOW) for x in (1e-2, 1e-6))])
def test_what_is_almost_a_parallelogram_is_proven(size):
    on = pj.follow(four_bar(2.0, 1.0, 2.0, 1.0 + size), [[0.9], [4.0]], certified=True)
    assert (on.status, on.evidence.kind) == ("end", "proof")
    off = pj.follow(four_bar(2.0, 1.0, 2.0, 1.0 - size), [[0.9], [4.0]], certified=True)
    assert (off.status, off.evidence.kind) == ("fold", "proof")
    assert off.radii.min() < on.radii.min()


@pytest.mark.slow
def test_a_parallelogram_is_proven_up_to_where_it_is_flat():
    trajectory = pj.follow(four_bar(2.0, 1.0, 2.0, 1.0), [[0.9], [4.0]], certified=True)
    assert (trajectory.status, trajectory.evidence.kind) == ("branch point", "proof")
    assert trajectory.t[-1] == pytest.approx((pi - 0.9) / 3.1, abs=1e-11)
    proven = trajectory.steps[len(trajectory.radii)]
    assert f"up to t = {proven:.9g}" in trajectory.evidence.statement
    assert trajectory.t[-1] - 1e-5 < proven < trajectory.t[-1]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["three_rps", "planar_3rpr"])
def test_folds_of_spatial_machines_are_proven_up_to(name):
    machine = loaded(name)
    home, rng = machine.home.actuated, np.random.default_rng(5)
    size = 0.2 * machine.characteristic_length
    first, second = rng.normal(size=(2, home.size)) * size

    def path(t):
        return home + first * np.sin(t) + second * (np.cos(2.0 * t) - 1.0)

    way = pj.follow(machine, path, times=(0.0, 6.28), enforce_limits=False, certified=True)
    assert (way.status, way.evidence.kind) == ("fold", "proof")
    assert way.t[-1] - way.steps[len(way.radii)] < 1e-6


def proof_of(steps):
    proof = PathProof(steps[0].course, steps[0].start)
    for step in steps:
        proof.takes(step)
    return proof


def at(course, theta, phi):
    """The closed pose of a four-bar with these angles of crank and rocker."""
    mechanism = course.mechanism
    base, crank, _, rocker = (mechanism.parameters[f"l{k}"] for k in range(4))
    x = base + rocker * cos(phi) - crank * cos(theta)
    y = rocker * sin(phi) - crank * sin(theta)
    values = {"theta1": theta, "phi1": phi, "phi2": atan2(y, x) - theta}
    q = mechanism.coordinates.q(values)
    point = course.pose_at(q)
    assert point.gap < 1e-12
    piece = course.path.pieces[0]
    return PathPose(theta, point, course.velocity(point, piece, theta))


@pytest.mark.parametrize("size", [1e-2, *(pytest.param(x, marks=SLOW) for x in SIZES)])
@pytest.mark.parametrize("width", [0.2, *(pytest.param(x, marks=SLOW) for x in (1e-2, 1e-3))])
def test_a_jump_is_never_proven(size, width):
    """From one mode to the other past their nearest place, as Newton's method alone goes."""
    lengths = (2.0, 1.0, 2.0, 1.0 + size)
    machine = four_bar(*lengths)
    start = machine.close([0.9])
    path = motor_path(machine, [[0.9], [4.0]], (0.9, 4.0))
    course = Course.beginning_at(start, path)
    thetas = pi - width / 3.0, pi + 2.0 * width / 3.0
    before, after = (rocker_angles(lengths, theta) for theta in thetas)
    piece = path.pieces[0]
    for k in (0, 1):
        for last in (0, 1):
            ends = at(course, thetas[0], before[k]), at(course, thetas[1], after[last])
            proof = proof_of([CoveredStep(course, piece, *ends)])
            if k == last:
                continue
            assert proof.failed
            assert not proof.radii


def test_the_same_without_a_jump_is_proven():
    lengths = (2.0, 1.0, 2.0, 1.3)
    machine = four_bar(*lengths)
    path = motor_path(machine, [[0.9], [4.0]], (0.9, 4.0))
    course = Course.beginning_at(machine.close([0.9]), path)
    angles = [rocker_angles(lengths, theta) for theta in (3.0, 3.05)]
    for k in (0, 1):
        ends = at(course, 3.0, angles[0][k]), at(course, 3.05, angles[1][k])
        assert not proof_of([CoveredStep(course, path.pieces[0], *ends)]).failed


def test_steps_that_do_not_hang_together_are_not_proven():
    """Two good steps, the second on the other mode."""
    lengths = (2.0, 1.0, 2.0, 1.3)
    machine = four_bar(*lengths)
    path = motor_path(machine, [[0.9], [4.0]], (0.9, 4.0))
    course = Course.beginning_at(machine.close([0.9]), path)
    angles = [rocker_angles(lengths, theta) for theta in (3.0, 3.05, 3.1)]
    thetas = (3.0, 3.05, 3.1)
    poses = [[at(course, t, a[k]) for t, a in zip(thetas, angles, strict=True)] for k in (0, 1)]
    steps = [
        CoveredStep(course, path.pieces[0], poses[0][0], poses[0][1]),
        CoveredStep(course, path.pieces[0], poses[1][1], poses[1][2]),
    ]
    proof = proof_of(steps)
    assert "do not meet at t = 3.05" in proof.failed
    assert len(proof.radii) == 1


def test_up_to_a_fold():
    trajectory = pj.follow(rocker_rocker(), [[0.9], [2.0]], certified=True)
    assert (trajectory.status, trajectory.evidence.kind) == ("fold", "proof")
    fold = acos((4.0**2 + 3.0**2 - 4.5**2) / 24.0)
    assert trajectory.steps[-2] == pytest.approx((fold - 0.9) / 1.1, abs=1e-6)


def test_what_is_held_and_left_out_is_said():
    spinning = pj.follow(rssr(), wavy(rssr()), times=(0.0, 1.0), certified=True)
    assert spinning.reached
    assert "held" in spinning.evidence.statement
    planar = pj.follow(loaded("four_bar"), [[0.9], [1.0]], certified=True)
    assert "all rows but 1 dependent row" in planar.evidence.statement


def test_tied_motors_are_proven():
    machine = over_actuated_four_bar()
    home = machine.home.actuated
    still = pj.follow(machine, [home, home], certified=True)
    assert still.reached


def test_a_path_of_high_degree_is_proven_on_itself():
    """The five-bar's tip by circles, along a function that no cubic is."""
    machine = loaded("five_bar")
    first, second = machine.home.actuated

    def path(t):
        return [first + 0.3 * sin(t), second + 0.2 * cos(2.0 * t) - 0.2]

    trajectory = pj.follow(machine, path, times=(0.0, 3.0), certified=True)
    assert trajectory.reached
    for t, pose in zip(trajectory.t, trajectory.configurations, strict=True):
        ends = [
            np.array([x + 0.3 * cos(a), 0.3 * sin(a)])
            for x, a in zip((0.0, 0.3), path(t), strict=True)
        ]
        tip = pose.tool_pose().translation[:2]
        for end in ends:
            assert np.linalg.norm(tip - end) == pytest.approx(0.4, abs=1e-12)


@pytest.mark.parametrize("done", [1, 5])
def test_what_was_walked_before_an_interrupt_is_proven(done):
    five, told = loaded("five_bar"), []

    def progress(t, end):
        told.append(t)
        if len(told) == done:
            raise KeyboardInterrupt

    whole = pj.follow(five, wavy(five), times=(0.0, 3.0), certified=True)
    with pytest.raises(pj.Interrupted) as raised:
        pj.follow(five, wavy(five), times=(0.0, 3.0), certified=True, progress=progress)
    kept = raised.value.done
    assert (kept.status, kept.evidence.kind) == ("interrupted", "proof")
    assert kept.t[-1] == told[-1]
    assert f"up to t = {told[-1]:.9g} " in kept.evidence.statement
    np.testing.assert_array_equal(kept.radii, whole.radii[:done])
    np.testing.assert_array_equal(kept.steps, whole.steps[: done + 1])


def test_an_interrupt_within_a_proof_keeps_what_is_proven(monkeypatch):
    """Steps are walked, and their events found, before they are proven."""
    five, takes, seen = loaded("five_bar"), PathProof.takes, []

    def interrupted(proof, step):
        seen.append(step)
        if len(seen) == 4:
            raise KeyboardInterrupt
        return takes(proof, step)

    monkeypatch.setattr(PathProof, "takes", interrupted)
    with pytest.raises(pj.Interrupted) as raised:
        pj.follow(five, wavy(five), times=(0.0, 3.0), certified=True)
    kept = raised.value.done
    assert kept.t[-1] == seen[-1].start.t
    assert len(kept.radii) == len(kept.steps) - 1 == 3


def test_where_nothing_proves_on_the_walk_stops(monkeypatch):
    five, takes, seen = loaded("five_bar"), PathProof.takes, []

    def failing(proof, step):
        seen.append(step)
        if len(seen) == 4:
            proof.failed = "nothing proves where the path goes on"
        return takes(proof, step)

    monkeypatch.setattr(PathProof, "takes", failing)
    way = pj.follow(five, wavy(five), times=(0.0, 3.0), certified=True)
    assert (way.status, way.reason) == ("not proven", "nothing proves where the path goes on")
    assert way.t[-1] == seen[-1].start.t
    assert len(seen) == 4
    assert len(way.radii) == len(way.steps) - 1 == 3
