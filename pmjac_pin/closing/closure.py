"""Closing the loops: assembling from an open start, and following one assembly mode.

`assemble` is damped least squares: it finds *a* closed pose near an open one. `follow` is
direct kinematics by continuation: from a closed pose it walks the motors straight to their
targets, predicting along φ̇ = −K*⁻¹ K θ̇ and correcting by Newton, in steps short enough
that it cannot change the assembly mode unseen.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from pmjac_pin.closing.closed import Closed, closed_point
from pmjac_pin.closing.closure_problem import ROUNDING, ClosureProblem
from pmjac_pin.closing.damped_closure import assemble
from pmjac_pin.closing.step_guard import StepGuard
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.lapack import least_squares, solved

MOST_STEPS = 20_000  #: tried in one path

# All lengths relative to the mechanism's characteristic length.
LARGEST_STEP = 0.25  # motion in one step, a rad counted as one length
SMALLEST_STEP = 1e-9  # motion in one step that is not the last: less is not resolved
LARGEST_CORRECTION = 0.25  # first Newton correction, as a share of the predicted motion
SLOWEST_CONTRACTION = 0.25  # of one Newton correction by the next
HARDLY_ANYTHING = 1e-4  # left of the motors' path, where a last step may reach a singular target
_NOTHING = 1e-5  # left of it, where such a target is reached as it is
_BESIDE_A_FOLD = (
    1e-5  # lengths or rad: both modes that meet at a fold are as near when the gap is 1e-12
)
WALKING = 1e-13  # gap on the way: beside a fold, more would hide how near that is
NO_INVERSE = 1e-9  # relative singular value of K* at a pose that no step is proven to lead to
MOST_CORRECTIONS = 50  # at a fold, polishing halves the error each time


class Followed(NamedTuple):
    """Where a path ended: at its target when `share` is 1.

    `spent` where it is so long that its steps were used up; `strayed` is where motors were led to
    that loops forbid to move so (`over_actuation`).
    """

    point: Closed
    share: float
    iterations: int
    spent: bool = False
    strayed: Array | None = None


def follow(
    problem: ClosureProblem,
    guard: StepGuard,
    start: Closed,
    displacement: Array,
    target: Callable[[Array], Array],
) -> Followed:
    """Walk the motors along a straight path, staying on the assembly mode of `start`.

    Parameters
    ----------
    problem : ClosureProblem
    guard : StepGuard
        Says which steps are covered.
    start : Closed
    displacement : ndarray, shape (n,)
        Of the motors, over the whole path.
    target : callable
        q ↦ q with the motors at their targets, exactly.
    """
    partition = problem.partition
    distance = norm(displacement / partition.motor_scale)
    if distance > MOST_STEPS * LARGEST_STEP * partition.length:
        return Followed(start, 0.0, 0, spent=True)
    point, share, step, iterations = start, 0.0, 1.0, 0
    regular = not is_singular(start, partition)
    velocity = path_velocity(start, displacement, partition) if regular else np.zeros(0)
    tries = 0
    while regular and tries < MOST_STEPS:
        tries += 1
        pace = norm(velocity / partition.column_scale) / partition.length
        if (stride := _stride(pace, step, 1.0 - share)) is None:
            break
        last = stride == 1.0 - share
        tangent = velocity * stride
        ahead = problem.integrate(point.q, tangent)
        candidate = corrected(problem, target(ahead) if last else ahead, tangent, last)
        step = 0.5 * stride
        if candidate is None:
            continue
        # Where ends alone prove K* regular it is invertible: at a pose where it is not, its change
        # from the start, which is regular, would not contract.
        if last and guard.covers_straight(problem, point, candidate):
            return Followed(candidate, 1.0, iterations + candidate.iterations)
        if not is_invertible(candidate, partition):
            continue
        arriving = path_velocity(candidate, displacement, partition)
        if not guard.covers(problem, point, candidate, tangent, arriving * stride):
            continue
        iterations += candidate.iterations
        before, point, velocity = point, candidate, arriving
        share = 1.0 if last else share + stride
        if last or is_singular(point, partition) or sinks_away(before, point, partition):
            break
        step = 2.0 * stride
    ended = Followed(point, share, iterations, spent=tries == MOST_STEPS)
    return _arrived(problem, guard, ended, displacement, target)


def _stride(pace: float, step: float, left: float) -> float | None:
    """Return how far to go of what is left, at lengths a unit of the way; None where too little."""
    step = min(step, LARGEST_STEP / pace if pace else 1.0)
    if step >= left:
        return left
    return None if step * pace < SMALLEST_STEP else step


def sinks_away(before: Closed, point: Closed, partition: Partition) -> bool:
    """Tell whether K* has come nearer to losing its rank and is beyond its tolerance already."""
    rank, least = partition.passive_rank, partition.rank_tolerance * partition.size
    if not rank or point.factors.exceeds(rank, least):
        return False
    # In m: beside a crossing all of K* is small.
    weakest, earlier = (one.factors.singular_values[rank - 1] for one in (point, before))
    return bool(weakest < earlier)


def _arrived(
    problem: ClosureProblem,
    guard: StepGuard,
    ended: Followed,
    displacement: Array,
    target: Callable[[Array], Array],
) -> Followed:
    """Return the target itself, when it is singular and the path ended right beside it."""
    partition, left = problem.partition, (1.0 - ended.share) * displacement
    far = norm(left / partition.motor_scale)
    if ended.share == 1.0 or far > HARDLY_ANYTHING * partition.length:
        return ended
    point = _covered_target(problem, guard, ended.point, left, target)
    if point is None and far <= _NOTHING * partition.length:
        point = beside(problem, ended.point.q, target(ended.point.q))
    if point is None or not is_singular(point, partition):
        return ended
    return Followed(point, 1.0, ended.iterations + point.iterations)


def _covered_target(
    problem: ClosureProblem,
    guard: StepGuard,
    point: Closed,
    left: Array,
    target: Callable[[Array], Array],
) -> Closed | None:
    """Return the target, where one step to it is covered from the singular pose that ended a path.

    How long the steps were decides where a path ends within what counts as singular: so whether it
    arrives is decided by what is proven of the rest of the way.
    """
    partition = problem.partition
    if not is_invertible(point, partition):
        return None
    leaving = path_velocity(point, left, partition)
    ahead = target(problem.integrate(point.q, leaving))
    found = corrected(problem, ahead, leaving, last=True)
    if found is None or not is_invertible(found, partition):
        return None
    arriving = path_velocity(found, left, partition)
    return found if guard.covers(problem, point, found, leaving, arriving) else None


def beside(problem: ClosureProblem, closed: Array, q: Array) -> Closed | None:
    """Close the loops at a q with its motors at rest, right beside a closed q; None elsewhere."""
    partition = problem.partition
    weights = np.zeros(partition.column_scale.size)
    weights[partition.passive] = 1.0
    found = assemble(problem, q, weights)
    moves = problem.difference(closed, found.q) / partition.column_scale
    moved = float(np.abs(moves).max(initial=0.0))
    if found.gap > problem.tolerance or moved > _BESIDE_A_FOLD * partition.length:
        return None
    return closed_point(problem, found.q, found.iterations)


def is_singular(point: Closed, partition: Partition) -> bool:
    """Tell whether K* is below its generic rank."""
    return point.factors.rank < partition.passive_rank


def is_invertible(point: Closed, partition: Partition) -> bool:
    """Tell whether K* has a pseudoinverse of its generic rank that rounding leaves alone."""
    factors = point.factors
    return factors.exceeds(partition.passive_rank, NO_INVERSE * factors.size)


def path_velocity(point: Closed, displacement: Array, partition: Partition) -> Array:
    """Return v (nv,): the motors' displacement and φ̇ = −K*⁻¹ K θ̇ with it."""
    driving = point.scaled.take(partition.actuated, axis=1)
    moves = point.factors.solve(
        driving.dot(displacement / partition.motor_scale), partition.passive_rank
    )
    velocity = _passive_motion(-moves, partition)
    velocity[partition.actuated] = displacement
    return velocity


def corrected(problem: ClosureProblem, q: Array, tangent: Array, last: bool) -> Closed | None:
    """Newton on the passive joints; None unless it contracts at once.

    A first correction that is small beside the predicted motion, and each next one small
    beside the one before, say that the prediction was close to the path. Within the
    tolerance there is nothing left to tell apart: there it only polishes, slowly at a fold, and no
    further than where a correction is foretold that is rounding.
    """
    partition, tolerance = problem.partition, problem.tolerance
    enough = (ROUNDING if last else WALKING) * partition.length
    allowed = LARGEST_CORRECTION * norm(tangent / partition.column_scale)
    previous_gap, previous_size, left = np.inf, np.nan, np.nan
    for iteration in range(1, MOST_CORRECTIONS):
        ending = left <= enough
        residual, jacobian = (problem.loops.closure if ending else problem.loops.evaluate)(q)
        error, scaled = residual * partition.row_scale, jacobian * partition.scale
        gap, size = norm(error), 0.0
        closed = gap <= tolerance
        done = gap <= enough or (closed and (ending or gap > 0.5 * previous_gap))
        if not done:
            moves = _newton_step(error, scaled, partition)
            size = norm(moves)
        if done or (closed and not math.isfinite(size)):
            if ending:
                return Closed(q, gap, error, scaled, partition, iteration)
            return closed_point(problem, q, iteration)
        if not (closed or size <= allowed):
            return None
        allowed, previous_gap = SLOWEST_CONTRACTION * size, gap
        left, previous_size = next_correction(previous_size, size), size or np.nan
        q = problem.integrate(q, _passive_motion(moves, partition))
    return None


def next_correction(before: Any, size: Any) -> Any:
    """Return how large Newton's next correction is, from the sizes of the last two: they square."""
    return size * (size / before) ** 2


def polished(problem: ClosureProblem, q: Array) -> Array:
    """Return a closed pose after as many further Newton steps as halve its gap."""
    point = corrected(problem, q, np.zeros(problem.partition.column_scale.size), last=True)
    return q if point is None else point.q


def _newton_step(error: Array, scaled: Array, partition: Partition) -> Array:
    """Return the smallest moves (m_p,) with K* moves = −η; no numbers where there are none.

    All without dimension: η as `error`, and `scaled` is [K K*].
    """
    K_star, rank = scaled.take(partition.passive, axis=1), partition.passive_rank
    rows, columns = K_star.shape
    if rows >= columns == rank:
        moves = (solved if rows == columns else least_squares)(K_star, error)
        return np.full(columns, np.nan) if moves is None else -moves
    factors = partition.factorise(K_star, partition.size_of(scaled))
    if not factors.singular_values[:rank].all():
        return np.full(columns, np.nan)
    return -factors.solve(error, rank)


def _passive_motion(moves: Array, partition: Partition) -> Array:
    """Return v (nv,) of the passive joints' moves (m_p,), which are without dimension."""
    velocity = np.zeros(partition.column_scale.size)
    velocity[partition.passive] = moves * partition.passive_scale
    return velocity
