"""Closed poses near another one, and whether the rates that loops allow there lead anywhere.

Where branches of the configuration space meet, or in a structure, loops allow rates to first order
that no motion has. From there least squares alone falls back to where it came from. So one joint at
a time is displaced and held: with it, closed poses are away from home, or there are none.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain

import numpy as np

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.damped_closure import assemble
from pmjac_pin.values.arrays import Array, Index, norm
from pmjac_pin.values.ties import pivots

_PROBES = 2  # times three poses along allowed rates or with displaced motors
#: How far joints are displaced at most, rad or a share of the characteristic length.
FARTHEST = 0.05
_DISTANCES = (FARTHEST, 0.005, 0.0005)
_SHORT_ROD = 0.1  # of the machine: a rod that ends what can be displaced
_SEEN = 100.0  # tolerances: a gap of the square of a distance may have a small factor
_AWAY = 0.1  # of a probe's distance: nearer to home, the loops have only pulled it back
_TOO_FAR = 20.0  # times a probe's distance: another assembly mode
_ALL_TOGETHER = 0.05  # of how far joints can be displaced one by one: less is another branch's
_DECIMALS_OF_STEPS = 12  # which are of length 1: the rest is rounding
_SHAKEN = 3  # starts of each joint that is displaced and held
_LEAST_SHARE_OF_RATES = (
    0.05  # a joint's share in the rates that loops allow, below which others are tried
)


def nearby(problem: ClosureProblem, home_q: Array) -> list[Array]:
    """Return closed poses near home and away from it, in seeded random directions.

    First along motions that the loops allow, all joints free to close them again; then with
    the motors displaced and kept there. From a home pose where branches meet, the first may
    well fall back to where they came from, which does not count, and from one at the end of a
    motor's range half of the second have nowhere to go. Where none of them closes, single joints
    are displaced and held, the others starting around home.
    """
    rng = np.random.default_rng(0)
    allowed = _allowed(problem, home_q)
    directions = _distinct(_directions(problem, allowed, rng))

    def held(joints: Iterable[int]) -> Iterator[tuple[Array, Array]]:
        return (_displaced(allowed, joint, rng) for joint in joints for _ in range(_SHAKEN))

    moving = _moving(allowed)
    for distance in _seen_distances(problem):
        found = _closed_starts(problem, home_q, directions, distance)
        if found := found or _closed_starts(problem, home_q, held(moving), distance):
            return found
    for joint in moving:
        for distance in _short_distances(problem, joint):
            if found := _closed_starts(problem, home_q, held([joint]), distance):
                return found
    return []


def reach_of_joints(problem: ClosureProblem, q: Array) -> float:
    """Return how far all motions that the loops allow at a closed pose lead, as `FARTHEST` does.

    What they allow, in d independent ways, is to first order. At a regular pose the d joints that
    determine the others best can be displaced one by one, the others of them held. Where one of
    them can be displaced neither way so, the pose is singular, or part of the machine a structure:
    0. Where one can be displaced by very little only, loops may still part: gaps that grow with a
    high power of the distance are within the tolerance there. Infinite where nothing may move.

    Where branches meet, each joint may have its own to move on, but not all of them together. So
    they are displaced so, too, in one combination. By far less than one by one counts as not at
    all: gaps that grow with a higher power of the distance.
    """
    allowed = _allowed(problem, q)
    leading = pivots(allowed.T, allowed.shape[1])
    steps, farthest = allowed @ np.linalg.inv(allowed[leading]), math.inf
    ways = [
        (step, _short_distances(problem, joint))
        for joint, step in zip(leading.tolist(), steps.T, strict=True)
    ]
    for step, short in ways:
        farthest = min(farthest, _farthest_reach(problem, q, step, leading, short))
        if not farthest:
            break
    if len(ways) == 1 or not 0.0 < farthest < math.inf:
        return farthest
    combined = _unit_step(steps @ np.random.default_rng(0).normal(size=len(ways)))
    short = tuple(chain.from_iterable(short for _, short in ways))
    together = _farthest_reach(problem, q, combined, leading, short)
    return min(farthest, together) if together > _ALL_TOGETHER * farthest else 0.0


def _farthest_reach(
    problem: ClosureProblem,
    q: Array,
    step: Array,
    leading: Index,
    short: Sequence[float],
) -> float:
    """Return how far a step leads, the leading joints held, by the distances that are tried."""
    distances = (*_seen_distances(problem), *short)
    rng, weights = np.random.default_rng(0), np.ones(step.size)
    weights[leading] = 0.0
    tries = [step, *(step + weights * rng.normal(size=step.size) for _ in range(_SHAKEN))]
    moved = (
        distance
        for distance in distances
        for one in tries
        for way in (1.0, -1.0)
        if _closed_starts(problem, q, [(way * one, weights)], distance)
    )
    return next(moved, 0.0)


def _seen_distances(problem: ClosureProblem) -> tuple[float, ...]:
    """Return the distances at which a gap of second order would be seen under the tolerance."""
    least = _SEEN * problem.tolerance / problem.partition.length
    first, *nearer = _DISTANCES
    return (first, *(distance for distance in nearer if distance**2 >= least))


def _short_distances(problem: ClosureProblem, joint: int) -> tuple[float, ...]:
    """Return by how much less a slide can be displaced that a rod much shorter than all else ties.

    Of a distance d along a rod r, gaps of second order are d²/r.
    """
    partition = problem.partition
    stroke = float(partition.strokes[joint]) if partition.strokes.size else 1.0
    if stroke > _SHORT_ROD:
        return ()
    least = _SEEN * problem.tolerance / partition.length
    return tuple(stroke * distance for distance in _DISTANCES if distance**2 * stroke >= least)


def _allowed(problem: ClosureProblem, q: Array) -> Array:
    """Return orthonormal columns that span the scaled rates which loops allow at q, (nv, d)."""
    return problem.partition.factorise_all(problem.evaluate(q)[1]).null_space


def _moving(allowed: Array) -> list[int]:
    """Return the joints that take part well in what the loops allow."""
    return [int(k) for k in np.flatnonzero(np.linalg.norm(allowed, axis=1) > _LEAST_SHARE_OF_RATES)]


def _directions(
    problem: ClosureProblem, allowed: Array, rng: np.random.Generator
) -> Iterator[tuple[Array, Array]]:
    """Yield scaled steps of length 1, and how easily each joint moves from there."""
    partition, count = problem.partition, len(allowed)
    motors_kept = np.zeros(count)
    motors_kept[partition.passive] = 1.0
    for _ in range(_PROBES):
        yield _unit_step(allowed @ rng.normal(size=allowed.shape[1])), np.ones(count)
        motors = np.zeros(count)
        motors[partition.actuated] = rng.normal(size=partition.actuated.size)
        yield _unit_step(motors), motors_kept
        yield -_unit_step(motors), motors_kept


def _distinct(steps: Iterable[tuple[Array, Array]]) -> list[tuple[Array, Array]]:
    """Return the steps less those that agree with one before: a single motor has two ways only."""
    found: dict[bytes, tuple[Array, Array]] = {}
    for step, weights in steps:
        alike = np.concatenate((step.round(_DECIMALS_OF_STEPS), weights))
        alike += 0.0  # zeros have no sign then
        found.setdefault(alike.tobytes(), (step, weights))
    return list(found.values())


def _displaced(allowed: Array, joint: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return a step that displaces a joint by 1, the others around what is allowed with it."""
    weights = np.ones(len(allowed))
    weights[joint] = 0.0
    step: Array = allowed @ allowed[joint] / (allowed[joint] @ allowed[joint])
    step = step + rng.normal(size=step.size)
    step[joint] = 1.0
    return step, weights


def _closed_starts(
    problem: ClosureProblem, q: Array, steps: Iterable[tuple[Array, Array]], distance: float
) -> list[Array]:
    """Return where steps of this distance close, away from q and not on another assembly mode."""
    partition, found = problem.partition, []
    for step, weights in steps:
        start = problem.integrate(q, partition.length * partition.column_scale * (distance * step))
        pose = assemble(problem, start, weights, limit=50)
        moved = problem.difference(q, pose.q) / partition.column_scale
        away = norm(moved) / (distance * partition.length)
        if pose.gap <= problem.tolerance and _AWAY < away < _TOO_FAR:
            found.append(pose.q)
    return found


def _unit_step(step: Array) -> Array:
    return step / (norm(step) or 1.0)
