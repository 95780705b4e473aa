"""Paths that end early: what the program of many of them says is what `close` says, and why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded, mostly_slow
from random_machines import planar_four_bar
from test_batch import NAMES, in_a_row, single, targets

import pmjac_pin as pj
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.closing.many_paths import FEW, LONG, Paths
from pmjac_pin.closing.path_kernel import many_paths_kernel
from pmjac_pin.closing.paths_in_lanes import Outcome
from pmjac_pin.closing.recorded_step import BOUNDS
from pmjac_pin.closing.straight_path import MOST_STEPS

FOLDING = ("five_bar", "bricard", "planar_3rpr", "planar_3rrr", "three_rps", "three_rps_ss")
SAME = 1e-8  # of the way: steps on both sides become shorter than can be resolved


def together(many, start, values, **options):
    q, share = np.empty_like(start), np.empty(len(values))
    return q, share, many._closing.together(start, values, (q, share), **options).settled


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("five_bar", 50),
        *(pytest.param(name, 300, marks=pytest.mark.slow) for name in FOLDING),
        *(
            pytest.param(name, 60, marks=pytest.mark.slow)
            for name in ("stewart_gough", "stewart_gough_dietmaier")
        ),
    ],
)
def test_where_paths_end(name, count, rng):
    """Nothing that the program settles is walked again, so all of it must be right."""
    mechanism = loaded(name)
    assert mechanism.problem.partition.full
    values = targets(mechanism, count, 0.6, rng)
    start = np.tile(mechanism.home.q, (count, 1))
    q, share, settled = together(pj.batch(mechanism), start, values)
    assert settled.mean() > 0.95
    assert (share[settled] < 1.0).sum() > 1
    for k in np.flatnonzero(settled).tolist():
        end, expected = single(mechanism, values[k])
        assert (share[k] == 1.0) == (end == 1.0)
        assert share[k] == pytest.approx(end, abs=SAME)
        if end == 1.0:
            size = max(1.0, mechanism.characteristic_length)
            np.testing.assert_allclose(q[k], expected, atol=1e-10 * size)


def test_what_is_not_settled_in_few_steps_is_said_to_be_so(rng):
    mechanism = loaded("five_bar")
    many, values = pj.batch(mechanism), targets(mechanism, 200, 0.6, rng)
    start = np.tile(mechanism.home.q, (200, 1))
    q, share, settled = together(many, start, values)
    early, share_early, settled_early = together(many, start, values, most_steps=5)
    assert 0.05 < settled_early.mean() < 0.95
    np.testing.assert_array_equal(early[settled_early], q[settled_early])
    assert (share_early[~settled_early] <= share[~settled_early] + 1e-12).all()
    assert settled.all()


@pytest.mark.skipif(many_paths_kernel() is None, reason="no kernel was built")
@pytest.mark.parametrize("name", mostly_slow(NAMES, ("four_bar", "five_bar", "bennett")))
def test_the_kernel_walks_as_numpy_does(name, rng):
    """More paths than lanes, so that lanes take up others; none, one and few."""
    mechanism = loaded(name)
    closing, problem = pj.batch(mechanism)._closing, mechanism.problem
    if closing.walker is None or problem.partition.constraint_rank > problem.partition.passive_rank:
        pytest.skip("single calls walk it")
    values = targets(mechanism, 150, 0.3, rng)
    common = np.broadcast_to(mechanism.home.q, (150, mechanism.nq))
    displacement, length = values - mechanism.home.actuated, mechanism.characteristic_length
    each, all_steps = np.array(common), MOST_STEPS
    for start, count, most in (
        (common, 150, all_steps), (each, 150, all_steps), (each, 150, 3), (common, 1, all_steps),
        (common, 0, 3),
    ):  # fmt: skip
        told = []
        paths = start[:count], displacement[:count], values[:count], lambda: told.append(1)  # noqa: B023
        found, expected = (one.walk(*paths, most) for one in (closing.lanes, closing.walker))
        # The last few of long paths are left to single calls: which, depends on when they began.
        apart = np.count_nonzero(found.settled != expected.settled)
        assert apart <= (2 * FEW if most > LONG else 0)
        both = found.settled & expected.settled
        np.testing.assert_allclose(found.share[both], expected.share[both], rtol=0.0, atol=SAME)
        arrived = both & (expected.share == 1.0)
        np.testing.assert_array_equal(both & (found.share == 1.0), arrived)
        size = max(1.0, length)
        np.testing.assert_allclose(found.q[arrived], expected.q[arrived], atol=1e-9 * size)
        assert told or not count


@pytest.mark.skipif(many_paths_kernel() is None, reason="no kernel was built")
@pytest.mark.parametrize("at", [np.tile, lambda q, shape: np.broadcast_to(q, (shape[0], q.size))])
def test_no_lane_depends_on_another(at, rng):
    """Each path with a start of its own, and all with one in common."""
    mechanism = loaded("five_bar")
    lanes, values = pj.batch(mechanism)._closing.lanes, targets(mechanism, 150, 0.6, rng)
    start = at(mechanism.home.q, (150, 1))
    displacement = values - mechanism.home.actuated
    together = lanes.walk(start, displacement, values, lambda: None)
    order = rng.permutation(150)
    apart = lanes.walk(start, displacement[order], values[order], lambda: None)
    for name in ("q", "share", "settled"):
        np.testing.assert_array_equal(getattr(together, name)[order], getattr(apart, name))


@pytest.mark.skipif(many_paths_kernel() is None, reason="no kernel was built")
@pytest.mark.parametrize("at", [np.tile, lambda q, shape: np.broadcast_to(q, (shape[0], q.size))])
@pytest.mark.parametrize("name", mostly_slow(NAMES, ("five_bar", "slider_crank", "three_rps")))
def test_the_kernel_finds_how_far_motors_go(name, at, rng):
    """That is how far they go, to the last bit; where they are not entries of q, it is told so."""
    mechanism = loaded(name)
    closing, values = pj.batch(mechanism)._closing, targets(mechanism, 150, 0.6, rng)
    if closing.lanes is None or not mechanism.motors.are_entries:
        pytest.skip("motors of other kinds, or single calls walk it")
    start = at(mechanism.home.q, (150, 1))
    given = mechanism.motors.ways(start, values)
    np.testing.assert_array_equal(given, values - mechanism.home.actuated)
    for most in (MOST_STEPS, 3):
        paths = [
            closing.lanes.walk(start, ways, values, lambda: None, most) for ways in (given, None)
        ]
        for one, other in zip(*paths, strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.skipif(many_paths_kernel() is None, reason="no kernel was built")
@pytest.mark.parametrize(("share", "outcome"), [(0.05, Outcome.ALL_ARRIVED), (0.6, Paths)])
def test_who_waits_for_paths_from_one_pose_is_asked_now_and_then(share, outcome, rng):
    """Between calls that take some milliseconds; whoever raises then is heard."""
    many = pj.batch(loaded("five_bar"))
    closing, nq = many._closing, many.mechanism.nq
    values, told = targets(many.mechanism, 4000, share, rng), []
    ends, start = (
        (np.empty((4000, nq)), np.empty(4000)),
        closing.common_start(many.mechanism.home.q),
    )

    def stop():
        raise InterruptedError

    found = closing.lanes.walk_from(start, values, lambda: told.append(1), ends)
    assert (found if isinstance(found, Outcome) else type(found)) is outcome
    assert len(told) >= (3 if outcome is Paths else 1)
    with pytest.raises(InterruptedError):
        closing.lanes.walk_from(start, values, stop, ends)
    again = closing.lanes.walk(
        np.tile(many.mechanism.home.q, (4000, 1)), None, values, lambda: None
    )
    np.testing.assert_allclose(ends[0][again.share == 1.0], again.q[again.share == 1.0], atol=1e-12)


def folding_four_bar():
    """No bar turns all around, and no joint has limits."""
    found = planar_four_bar(
        (1.0, 0.0), (1.5, 0.0), ((1.0, 1.0), (1.5, 1.0)), ["a"], name="folding", home={"a": 1.2}
    )
    assert min(found.coordinates.upper) == np.inf
    return found


@pytest.mark.parametrize("far", [1e6, -1e8])
@pytest.mark.parametrize(
    "machine",
    [
        lambda: loaded("five_bar"),
        lambda: loaded("three_rps"),
        lambda: in_a_row(pin.JointModelRZ(), np.full(2, np.inf)),
        folding_four_bar,
    ],
    ids=["five_bar", "three_rps", "no limits", "no limits but folds"],
)
def test_what_is_too_long_for_any_number_of_steps_is_not_followed(machine, far, rng):
    """As by the single call, which tells the share of the way."""
    mechanism = machine()
    many, values = pj.batch(mechanism), targets(mechanism, 5, 0.05, rng)
    values[2, 0] += far
    with pytest.raises(pj.ClosureError) as raised:
        mechanism.close(values[2], enforce_limits=False)
    for guess in ("home", np.tile(mechanism.home.q, (5, 1))):
        poses = many.close(values, guess, enforce_limits=False)
        np.testing.assert_array_equal(poses.status == pj.Status.STOPPED, np.arange(5) == 2)
        assert poses.share[2] == raised.value.share


class ShortSteps:
    """Steps of a mechanism from home, and what the leg's program tells of them."""

    def __init__(self, name, rng):
        self.mechanism = mechanism = loaded(name)
        self.walker = walker = pj.batch(mechanism)._closing.walker
        if walker is None:
            pytest.skip("single calls walk it")
        displacement = targets(mechanism, 30, 0.005, rng) - mechanism.home.actuated
        self.start = walker.at(np.tile(mechanism.home.q[:, None], 30), displacement.T)
        ahead = run(walker.move, np.vstack([self.start.q, self.start.velocity]))
        self.end, good = walker._correct(
            ahead, np.full(30, np.inf), displacement.T, np.zeros(30, dtype=bool)
        )
        assert good.size == 30
        ends = [self.start.q, self.end.q, self.start.velocity, self.end.velocity]
        self.inputs = np.vstack([*ends, self.start.inverse, self.end.inverse])
        self.told = run(walker.leg, self.inputs).reshape(BOUNDS, 4, -1)

    def curve(self, step, share):
        """The cubic that leaves and arrives as the path does, by Pinocchio."""
        model = self.mechanism.model
        first, last = self.start.q[:, step].copy(), self.end.q[:, step].copy()
        way = pin.difference(model, first, last)
        slope = pin.dDifference(model, first, last, pin.ArgumentPosition.ARG1)
        leaving, arriving = self.start.velocity[:, step], slope @ self.end.velocity[:, step]
        cubic = share**2 * (3.0 - 2.0 * share) * way
        cubic += share * (1.0 - share) * ((1.0 - share) * leaving - share * arriving)
        return pin.integrate(model, first, cubic)

    def scaled(self, q):
        """η and K* on the columns that the program keeps."""
        problem = self.mechanism.problem
        residual, jacobian = problem.evaluate(q)
        kept = self.mechanism.recorded.rates.kept
        scaled = problem.partition.scaled(jacobian)
        return residual * problem.partition.row_scale, scaled[:, kept]


STEPS = mostly_slow(NAMES, ("five_bar", "three_rps", "bennett"))


@pytest.mark.parametrize("name", STEPS)
def test_what_is_told_of_a_step_holds_all_along_it(name, rng):
    """K* changes no more from the start up to where the end takes over, nor from the end back."""
    steps = ShortSteps(name, rng)
    change, rho, *_ = steps.told.swapaxes(0, 1)
    assert (change < 1.0).all()
    inverse = steps.start.inverse, steps.end.inverse
    middle = inverse[1] / np.maximum(
        inverse[0] + inverse[1], 1e-300
    )  # nothing follows in open chains
    for step in range(0, 30, 6):
        ends = [steps.scaled(points.q[:, step].copy()) for points in (steps.start, steps.end)]
        back = [np.linalg.pinv(matrix) for _, matrix in ends]
        for share in np.linspace(0.0, 1.0, 11):
            residual, matrix = steps.scaled(steps.curve(step, share))
            assert np.linalg.norm(residual) <= rho[0, step]
            changes = [
                np.linalg.norm(one @ (matrix - end), 2)
                for one, (_, end) in zip(back, ends, strict=True)
            ]
            assert changes[0] <= change[1:, step].min() * (1.0 + 1e-12) + 1e-14
            near = changes[0] if share <= middle[step] else changes[1]
            assert near <= change[0, step] * (1.0 + 1e-12) + 1e-14


@pytest.mark.parametrize("name", STEPS)
def test_what_is_told_sooner_of_a_step_is_the_same_alone(name, rng):
    """With A⁺ to both changes N is less than with A⁺ to one of them."""
    steps = ShortSteps(name, rng)
    change, rho, beyond, contraction = steps.told.swapaxes(0, 1)
    np.testing.assert_array_equal(rho[1:], rho[:-1])
    for bound in (change, beyond, contraction):
        assert (bound[1] >= bound[2] * (1.0 - 1e-12) - 1e-14).all()
    leg = steps.walker.leg
    assert list(leg.stages) == sorted(leg.stages)
    for number, length in enumerate(leg.stages):
        early = run(replace(leg, code=leg.code[:length]), steps.inputs)
        told = steps.told[: number + 1].reshape(-1, 30)
        np.testing.assert_array_equal(early[: 4 * number + 4], told)


@pytest.mark.parametrize("name", ["five_bar", "three_rps", "planar_3rpr"])
def test_why_a_path_has_stopped_is_told_by_the_measures_there(name, rng):
    mechanism = loaded(name)
    poses, found = pj.batch(mechanism).measures_at(
        targets(mechanism, 400, 0.8, rng), enforce_limits=False
    )
    stopped = poses.status == pj.Status.STOPPED
    assert stopped.sum() > 1
    assert found.smallest[stopped].max() < 1e-6
    assert np.median(found.smallest[~stopped]) > 1e-3
