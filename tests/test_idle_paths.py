"""Where idle motions are at the ends of paths: the same however one walks, and where it is said."""

from __future__ import annotations

import shutil
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from idling_machines import flap_on_a_leg, leg_with_a_four_bar, on_a_turntable, tripod
from idling_rods import gough_on_balls, puck, rod_of_an_rssr, rod_on_a_ball
from mechanisms import CATALOGUE, loaded, rssr
from random_machines import random_machine
from recording import recorded, unrecorded
from scipy.spatial.transform import Rotation
from test_batch import targets

import pmjac_pin as pj
from pmjac_pin.closing import straight_path
from pmjac_pin.closing.path_kernel import many_paths_kernel

SAME = 1e-11  # of the length, or rad


def fewer_motors(name, count):
    """A machine some of whose motors are left out: what they moved idles, and is felt."""
    return pj.load(name, actuated=loaded(name).actuated[:count])


def four_bar_in_a_leg():
    hinge, end = np.array([4.0, 0.5, -1.0]), np.array([0.6, 0.3, 1.6])
    return leg_with_a_four_bar(hinge, end, 0.9, pin.SE3.Identity())[0]


def turning_five_bar():
    bar = loaded("five_bar")
    tool = bar.spec.tool.frame
    alone = pj.Mechanism.from_pinocchio(
        bar.model, bar.spec.loops, bar.actuated, tool, home=bar.home.q
    )
    return on_a_turntable(alone, np.array([0.6, 0.0, 0.8]))


IDLING = {
    "rssr": rssr,
    "rod": rod_on_a_ball,
    "rod and disc": lambda: rod_on_a_ball(disc=True),
    "puck": puck,
    "tripod": lambda: tripod()[0],
    "six legs": gough_on_balls,
    "four-bar in a leg": four_bar_in_a_leg,
    "flap": lambda: flap_on_a_leg()[0],
    "turntable": turning_five_bar,
    "five-bar, one motor": lambda: fewer_motors("five_bar", 1),
    "3-RRR, two motors": lambda: fewer_motors("planar_3rrr", 2),
    "3-RPR, two motors": lambda: fewer_motors("planar_3rpr", 2),
    "delta, two motors": lambda: fewer_motors("delta_rods", 2),
    "platform, five motors": lambda: fewer_motors("stewart_gough", 5),
    "ankle, one motor": lambda: fewer_motors("ankle", 1),
}
#: Whose paths end where they go farther.
NEARER = {
    "six legs": (0.01, 0.05),
    "tripod": (0.01, 0.2),
    "platform, five motors": (0.01, 0.2),
    "3-RRR, two motors": (0.01, 0.6),
    "flap": (0.01, 0.6),
    "four-bar in a leg": (0.01, 0.6),
}
QUICK = ("rssr", "rod and disc", "puck", "five-bar, one motor", "five_bar")


def machine(name):
    if name in IDLING:
        return IDLING[name]()
    return random_machine(int(name.split()[1])) if name.startswith("random ") else loaded(name)


def cases():
    for name in [*IDLING, *CATALOGUE, *(f"random {seed}" for seed in range(5))]:
        for share in NEARER.get(name, (0.01, 0.6, 3.0)) if name in IDLING else (0.6,):
            quick = name in QUICK and share in (0.01, 0.6)
            yield pytest.param(name, share, marks=[] if quick else [pytest.mark.slow])


def apart(mechanism, q, others):
    """How far poses are from others, a rad counted as one length."""
    partition = mechanism.problem.partition
    ways = [pin.difference(mechanism.model, *both) for both in zip(q, others, strict=True)]
    lengths = np.reshape(ways, (-1, mechanism.nv)) / partition.column_scale
    return np.abs(lengths).max(initial=0.0) / partition.length


def singles(mechanism, values):
    """Where single calls lead, and the share of the way."""
    q, share = [], []
    for one in values:
        try:
            q.append(mechanism.close(one, enforce_limits=False).q)
            share.append(1.0)
        except pj.ClosureError as error:
            q.append(error.reached.q)
            share.append(error.share)
    return np.array(q), np.array(share)


def batches(name, share):
    """By the kernel, by NumPy, and of two machines by compiled programs: these take seconds."""
    many = pj.batch(machine(name))
    yield many
    by_numpy = pj.batch(machine(name))
    by_numpy._closing = replace(by_numpy._closing, lanes=None)
    yield by_numpy
    compiled = (name, share) in (("tripod", 0.2), ("rssr", 0.6))
    if compiled and shutil.which("cc") and many_paths_kernel() is not None:
        yield pj.batch(machine(name), compiled=True)


@pytest.mark.parametrize(("name", "share"), list(cases()))
def test_all_ways_lead_to_one_pose(name, share, rng, tmp_path, monkeypatch):
    """By singular values, by programs, in batches: statuses, and every joint, what idles too."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    mechanism = unrecorded(machine(name))
    values = targets(mechanism, 8, share, rng)
    q, shares = singles(mechanism, values)
    arrived = shares == 1.0
    others = [singles(recorded(machine(name)), values)]
    for many in batches(name, share):
        poses = many.close(values, enforce_limits=False)
        others.append((poses.q, poses.share))
    for found, how_far in others:
        np.testing.assert_array_equal(how_far == 1.0, arrived)
        assert np.count_nonzero(arrived) > 2 or name not in IDLING
        assert apart(mechanism, found[arrived], q[arrived]) < SAME


@pytest.mark.parametrize("name", ["rssr", "rod", "puck", "tripod", "3-RPR, two motors"])
def test_steps_of_any_length_lead_to_one_pose(name, rng, monkeypatch):
    mechanism = unrecorded(machine(name))
    values = targets(mechanism, 5, 0.6, rng)
    q, shares = singles(mechanism, values)
    monkeypatch.setattr(straight_path, "LARGEST_STEP", 0.04)
    again, shares_again = singles(mechanism, values)
    arrived = (shares == 1.0) & (shares_again == 1.0)
    assert np.count_nonzero(arrived) > 2
    assert apart(mechanism, again[arrived], q[arrived]) < SAME


def test_a_rod_does_not_turn_about_itself():
    """Of the turn that leads from its first orientation to its last, nothing is about the rod."""
    mechanism = rod_on_a_ball()
    entries = mechanism.model.joints[mechanism.model.getJointId("ball")].idx_q
    first = Rotation.from_quat(mechanism.home.q[entries:][:4])
    for theta in (0.1, 0.9, 1.35):
        last = Rotation.from_quat(mechanism.close([theta]).q[entries:][:4])
        turn = (first.inv() * last).as_rotvec()
        assert np.linalg.norm(turn) > 0.1
        assert abs(turn[0]) < 1e-14


def test_loose_joints_stay_where_they_are():
    """The disc that no loop holds, and the puck's ball."""
    for mechanism, name, size in ((rod_on_a_ball(disc=True), "disc", 4), (puck(), "ball", 4)):
        entries = mechanism.model.joints[mechanism.model.getJointId(name)].idx_q
        at_home = mechanism.home.q[entries:][:size]
        q = mechanism.close([1.2]).q
        np.testing.assert_allclose(q[entries:][:size], at_home, atol=1e-14)


@pytest.mark.parametrize("make", [rssr, rod_on_a_ball, puck])
def test_a_long_way_is_cut_into_lengths(make):
    mechanism = make()
    start = mechanism.home.actuated
    at_once = mechanism.close(start + 3.0).q
    pose = mechanism.home
    for _ in range(3):
        pose = mechanism.close(pose.actuated + 1.0, guess=pose)
    assert apart(mechanism, [at_once], [pose.q]) < SAME
    in_halves = mechanism.close(start + 3.0, guess=mechanism.close(start + 1.5)).q
    assert apart(mechanism, [at_once], [in_halves]) > 1e-4  # where it idled does matter


def test_each_path_has_its_own_start(rng):
    """From a different pose each, and over a grid, from neighbour to neighbour."""
    mechanism = tripod()[0]
    many = pj.batch(mechanism)
    starts = many.close(targets(mechanism, 6, 0.1, rng), enforce_limits=False).q
    values = targets(mechanism, 6, 0.3, rng)
    poses = many.close(values, guess=starts, enforce_limits=False)
    for q, start, one, share in zip(poses.q, starts, values, poses.share, strict=True):
        assert share == 1.0
        guess = mechanism.configuration(start)
        single = mechanism.close(one, guess=guess, enforce_limits=False)
        assert apart(mechanism, [q], [single.q]) < SAME
    at = mechanism.home.actuated
    grid = many.grid({"l0": at[0] + np.linspace(-0.1, 0.1, 4)}, enforce_limits=False)
    for q, source in zip(grid.q, grid.source.tolist(), strict=True):
        guess = mechanism.home if source < 0 else mechanism.configuration(grid.q[source])
        single = mechanism.close(mechanism.configuration(q).actuated, guess=guess)
        assert apart(mechanism, [q], [single.q]) < SAME


def test_beside_a_fold_nothing_is_brought_back_onto_another_mode():
    """Where the modes are near, and what idles has gone far: the rocker says on which it is."""
    alone, machine = rod_of_an_rssr(body=False), rod_of_an_rssr(body=True)
    many, first, compared = pj.batch(machine), machine.home.actuated[0], 0
    for way in (6.0, -6.0):
        with pytest.raises(pj.ClosureError) as caught:
            alone.close([first + way], enforce_limits=False)
        fold = caught.value.reached.actuated[0]
        targets = fold + np.geomspace(1e-8, 1e-2, 13)[:, None] * (first - fold)
        at_once = many.close(targets, enforce_limits=False)
        for target, q, status in zip(targets, at_once.q, at_once.status, strict=True):
            expected = alone.close(target, enforce_limits=False).joint_values["psi"]
            own = machine.close(target, enforce_limits=False).joint_values["psi"]
            assert own == pytest.approx(expected, abs=1e-7)
            assert status == pj.Status.CLOSED
            assert q[1] == pytest.approx(expected, abs=1e-7)
            compared += 1
    assert compared == 26
