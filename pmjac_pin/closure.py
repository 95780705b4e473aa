"""Closing the loops: assembling from an open start, and following one assembly mode.

`assemble` is damped least squares: it finds *a* closed pose near an open one. `follow` is
direct kinematics by continuation: from a closed pose it walks the motors straight to their
targets, predicting along φ̇ = −K*⁻¹ K θ̇ and correcting by Newton, in steps short enough
that it cannot change the assembly mode unseen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dgesv

from pmjac_pin.closure_problem import ROUNDING, ClosureProblem
from pmjac_pin.damped_closure import assemble
from pmjac_pin.factorisation import Factorisation, norm
from pmjac_pin.partition import Partition

Array = NDArray[np.float64]
Index = NDArray[np.intp]

# All lengths relative to the mechanism's characteristic length.
_LARGEST_STEP = 0.25  # motion in one step, a rad counted as one length
_SMALLEST_STEP = 1e-15  # of the whole path
_LARGEST_CORRECTION = 0.25  # first Newton correction, as a share of the predicted motion
_SLOWEST_CONTRACTION = 0.25  # of one Newton correction by the next
_HARDLY_ANYTHING = 1e-8  # left of the motors' path, where it may have ended at a fold
_BESIDE = 1e-5  # m or rad: both modes that meet at a fold are as near when the gap is 1e-12
_WALKING = 1e-13  # gap on the way: beside a fold, more would hide how near that is
_MOST_STEPS = 2000  # of full length, for a path that is very long beside the mechanism
_MOST_CORRECTIONS = 50  # at a fold, polishing halves the error each time


@dataclass(frozen=True, slots=True, eq=False)
class Closed:
    """A point on a path: closed loops, and K* factorised there, in the anchors' axes."""

    q: Array
    gap: float
    scaled: Array
    factors: Factorisation
    iterations: int


@dataclass(frozen=True, slots=True, eq=False)
class Followed:
    """Where a path ended: at its target when `share` is 1."""

    point: Closed
    share: float
    iterations: int


def follow(
    problem: ClosureProblem, start: Closed, displacement: Array, target: Callable[[Array], Array]
) -> Followed:
    """Walk the motors along a straight path, staying on the assembly mode of `start`.

    Parameters
    ----------
    problem : ClosureProblem
    start : Closed
    displacement : ndarray, shape (n,)
        Of the motors, over the whole path.
    target : callable
        q ↦ q with the motors at their targets, exactly.
    """
    partition = problem.partition
    distance = norm(displacement / partition.column_scale[partition.actuated])
    largest_step = max(_LARGEST_STEP * partition.length, distance / _MOST_STEPS)
    point, share, step, iterations = start, 0.0, 1.0, 0
    while share < 1.0:
        if _is_singular(point, partition):
            break
        velocity = _path_velocity(point, displacement, partition)
        pace = norm(velocity / partition.column_scale)
        step = min(step, largest_step / pace if pace else 1.0)
        last = step >= 1.0 - share
        stride = 1.0 - share if last else step
        tangent = velocity * stride
        ahead = problem.integrate(point.q, tangent)
        candidate = _correct(problem, target(ahead) if last else ahead, point, tangent, last)
        if candidate is None:
            step *= 0.5
            if step < _SMALLEST_STEP:
                break
            continue
        iterations += candidate.iterations
        point, share = candidate, 1.0 if last else share + step
        step *= 2.0
    ended = Followed(point, share, iterations)
    if share < 1.0 and (1.0 - share) * distance <= _HARDLY_ANYTHING * partition.length:
        return _arrived(problem, ended, target) or ended
    return ended


def _arrived(
    problem: ClosureProblem, ended: Followed, target: Callable[[Array], Array]
) -> Followed | None:
    """Return the target itself, when the path ended at a fold that rounding puts beside it."""
    partition = problem.partition
    weights = np.zeros(partition.column_scale.size)
    weights[partition.passive] = 1.0
    found = assemble(problem, target(ended.point.q), weights)
    moved = np.abs(found.q - ended.point.q).max(initial=0.0)
    if found.gap > problem.tolerance or moved > _BESIDE * max(1.0, partition.length):
        return None
    return Followed(closed_point(problem, found.q), 1.0, ended.iterations + found.iterations)


def closed_point(problem: ClosureProblem, q: Array) -> Closed:
    """Evaluate and factorise at a q whose loops are closed."""
    residual, jacobian = problem.evaluate(q)
    return _point(problem, q, problem.gap(residual), jacobian, 0)


def _point(
    problem: ClosureProblem, q: Array, gap: float, jacobian: Array, iterations: int
) -> Closed:
    scaled = problem.partition.scaled(jacobian)
    factors = problem.partition.factorise(
        scaled.take(problem.partition.passive, axis=1), norm(scaled)
    )
    return Closed(q, gap, scaled, factors, iterations)


def _is_singular(point: Closed, partition: Partition) -> bool:
    return point.factors.rank < partition.passive_rank


def _path_velocity(point: Closed, displacement: Array, partition: Partition) -> Array:
    """Return v (nv,): the motors' displacement and φ̇ = −K*⁻¹ K θ̇ with it."""
    actuated, passive = partition.actuated, partition.passive
    velocity = np.zeros(partition.column_scale.size)
    velocity[actuated] = displacement / partition.column_scale[actuated]
    velocity[passive] = -point.factors.solve(
        point.scaled[:, actuated] @ velocity[actuated], partition.passive_rank
    )
    velocity *= partition.column_scale
    return velocity


def _correct(
    problem: ClosureProblem, q: Array, start: Closed, tangent: Array, last: bool
) -> Closed | None:
    """Newton on the passive joints; None unless it contracts at once and stays on the mode.

    A first correction that is small beside the predicted motion, and each next one small
    beside the one before, say that the prediction was close to the path. That K* stays regular
    (`Factorisation.stays_regular`) says that no singularity lies between them. Within the
    tolerance there is nothing left to tell apart: there it only polishes, slowly at a fold.
    """
    partition = problem.partition
    enough = (ROUNDING if last else _WALKING) * partition.length
    allowed = _LARGEST_CORRECTION * norm(tangent / partition.column_scale)
    corrections = no_motion = np.zeros(tangent.size)
    previous_gap = np.inf
    for iteration in range(1, _MOST_CORRECTIONS):
        residual, jacobian = problem.evaluate(q)
        gap = problem.gap(residual)
        closed = gap <= problem.tolerance
        done = gap <= enough or (closed and gap > 0.5 * previous_gap)
        velocity = no_motion if done else _newton_step(residual, jacobian, partition)
        size = norm(velocity / partition.column_scale)
        if done or (closed and not np.isfinite(size)):
            point = _point(problem, q, gap, jacobian, iteration)
            return point if _same_mode(problem, start, point, tangent, corrections) else None
        if not (closed or size <= allowed):
            return None
        allowed, previous_gap = _SLOWEST_CONTRACTION * size, gap
        q = problem.integrate(q, velocity)
        corrections = corrections + velocity
    return None


def _same_mode(
    problem: ClosureProblem, start: Closed, end: Closed, tangent: Array, corrections: Array
) -> bool:
    """Tell whether no singularity lies between two points; the end may be one itself.

    Halfway along a path that starts with the velocity t and ends at t + c, it is at t/2 + c/4,
    to second order.
    """
    partition = problem.partition
    passive = partition.passive
    if _is_singular(end, partition):
        return True

    def middle() -> Array:
        q = problem.integrate(problem.integrate(start.q, 0.5 * tangent), 0.25 * corrections)
        return partition.scaled(problem.evaluate(q)[1]).take(passive, axis=1)

    K_star = end.scaled.take(passive, axis=1)
    return start.factors.stays_regular(K_star, middle, partition.passive_rank)


def _newton_step(residual: Array, jacobian: Array, partition: Partition) -> Array:
    """Return v (nv,) that moves the passive joints only: K* φ̇ = −η, smallest φ̇."""
    passive = partition.passive
    velocity = np.zeros(partition.column_scale.size)
    if residual.size == passive.size == partition.passive_rank:
        *_, solution, failed = dgesv(jacobian.take(passive, axis=1), residual)
        velocity[passive] = np.nan if failed else -solution
        return velocity
    scaled = partition.scaled(jacobian).take(passive, axis=1)
    factors = partition.factorise(scaled, norm(scaled))
    error = residual * partition.row_scale
    velocity[passive] = -partition.column_scale[passive] * factors.solve(
        error, partition.passive_rank
    )
    return velocity
