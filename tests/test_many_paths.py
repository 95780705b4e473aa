"""Paths that end early: what the program of many of them says is what `close` says, and why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mechanisms import loaded, mostly_slow
from test_batch import NAMES, single, targets

import pmjac_pin as pj
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.closing.closure import MOST_STEPS
from pmjac_pin.closing.many_paths import FEW, LONG
from pmjac_pin.closing.path_kernel import many_paths_kernel
from pmjac_pin.closing.recorded_step import BOUNDS

FOLDING = ("five_bar", "bricard", "planar_3rpr", "planar_3rrr", "three_rps", "three_rps_ss")
SAME = 1e-8  # of the way: steps on both sides become shorter than can be resolved


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
    q, share, settled = pj.batch(mechanism)._closing.together(start, values)
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
    q, share, settled = many._closing.together(start, values)
    early, share_early, settled_early = many._closing.together(start, values, most_steps=5)
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


@pytest.mark.parametrize("name", mostly_slow(NAMES, ("five_bar", "three_rps", "bennett")))
def test_what_is_told_sooner_of_a_step_is_never_less(name, rng):
    """So a step that is covered by an early bound is covered by the last one."""
    mechanism = loaded(name)
    walker = pj.batch(mechanism)._closing.walker
    if walker is None:
        pytest.skip("single calls walk it")
    displacement = targets(mechanism, 30, 0.005, rng) - mechanism.home.actuated
    start = walker.at(np.tile(mechanism.home.q[:, None], 30), displacement.T)
    ahead = run(walker.move, np.vstack([start.q, start.velocity]))
    end = walker.at(ahead, displacement.T)
    steps = np.vstack([start.q, end.q, start.velocity, end.velocity, start.inverse])
    told = run(walker.leg, steps).reshape(BOUNDS, 4, -1)
    change, rho, tau, within = told.swapaxes(0, 1)
    np.testing.assert_array_equal(rho[1:], rho[:-1])
    sure = change[0] < 1.0
    assert sure.any()
    for bound in (change, tau[:, sure], within[:, sure]):
        assert (bound[:-1] >= bound[1:] * (1.0 - 1e-12) - 1e-14).all()
    parts = walker.leg.stages
    assert list(parts) == sorted(parts)
    for number, length in enumerate(parts):
        early = run(replace(walker.leg, code=walker.leg.code[:length]), steps)
        np.testing.assert_array_equal(early[: 4 * number + 4], told[: number + 1].reshape(-1, 30))
