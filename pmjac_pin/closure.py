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

from pmjac_pin.factorisation import Factorisation, factorise, norm
from pmjac_pin.partition import Partition

Array = NDArray[np.float64]
Index = NDArray[np.intp]

#: Loops count as closed below this gap, m; for machines beyond 100 m, rounding allows only
#: 1e-14 of their size.
CLOSURE_TOLERANCE = 1e-12

# All lengths relative to the mechanism's characteristic length.
_ROUNDING = 1e-15  # a gap that no further iteration can improve
_LONGEST_STRIDE = 0.5  # of one iteration of `assemble`: joints must not wind up
_LARGEST_STEP = 0.25  # motion in one step, a rad counted as one length
_SMALLEST_STEP = 1e-15  # of the whole path
_LARGEST_CORRECTION = 0.25  # first Newton correction, as a share of the predicted motion
_SLOWEST_CONTRACTION = 0.25  # of one Newton correction by the next
_HARDLY_ANYTHING = 1e-8  # left of the motors' path, where it may have ended at a fold
_BESIDE = 1e-5  # m or rad: both modes that meet at a fold are as near when the gap is 1e-12
_MOST_STEPS = 2000  # of full length, for a path that is very long beside the mechanism
_MOST_CORRECTIONS = 50  # at a fold, polishing halves the error each time


@dataclass(frozen=True, slots=True)
class ClosureProblem:
    """The loop equations as functions of q, and the partition of their columns.

    Attributes
    ----------
    evaluate : callable
        q ↦ (η (p,), ∂η/∂v (p, nv)).
    integrate : callable
        (q, v) ↦ q ⊕ v.
    partition : Partition
    given_tolerance : float or None
        The gap in m that the model calls closed; None for `CLOSURE_TOLERANCE`.
    """

    evaluate: Callable[[Array], tuple[Array, Array]]
    integrate: Callable[[Array, Array], Array]
    partition: Partition
    given_tolerance: float | None = None

    @property
    def tolerance(self) -> float:
        """The gap in m below which the loops are closed."""
        return max(self.given_tolerance or CLOSURE_TOLERANCE, 1e-14 * self.partition.length)

    def gap(self, residual: Array) -> float:
        """Return the Euclidean norm of a residual, in m."""
        return norm(residual * self.partition.row_scale)


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


@dataclass(frozen=True, slots=True, eq=False)
class Assembled:
    """The best pose that damped least squares found."""

    q: Array
    gap: float
    iterations: int


def assemble(problem: ClosureProblem, q: Array, weights: Array, limit: int = 200) -> Assembled:
    """Close the loops from an open start by damped least squares (Levenberg–Marquardt).

    Parameters
    ----------
    problem : ClosureProblem
    q : ndarray, shape (nq,)
    weights : ndarray, shape (nv,)
        How easily each degree of freedom moves; zero keeps it where it is.
    limit : int
        Number of iterations after which the best pose is returned as it is.
    """
    partition = problem.partition
    scale = weights * partition.column_scale
    residual, jacobian = problem.evaluate(q)
    gap, damping = problem.gap(residual), 1e-3
    finest = _ROUNDING * partition.length
    for iteration in range(limit):
        error = residual * partition.row_scale
        left, values, right = np.linalg.svd(
            partition.row_scale[:, None] * jacobian * scale, full_matrices=False
        )
        largest = values.max(initial=0.0)
        if gap <= finest or largest == 0.0:
            return Assembled(q, gap, iteration)
        # Damping fades with the gap, which keeps the convergence quadratic at a regular pose
        # and leaves idle and redundant directions, with σ at rounding, alone.
        squared = (
            damping * largest**2 * min(1.0, (gap / partition.length) ** 2) + (1e-9 * largest) ** 2
        )
        step = -scale * (right.T @ (values / (values**2 + squared) * (left.T @ error)))
        stride = norm(step / partition.column_scale)
        step *= min(1.0, _LONGEST_STRIDE * partition.length / (stride or 1.0))
        trial = problem.integrate(q, step)
        trial_residual, trial_jacobian = problem.evaluate(trial)
        trial_gap = problem.gap(trial_residual)
        if trial_gap < gap:
            q, residual, jacobian, gap = trial, trial_residual, trial_jacobian, trial_gap
            damping = max(damping / 8.0, 1e-12)
        elif gap <= problem.tolerance or damping > 1e16:
            return Assembled(q, gap, iteration)
        else:
            damping *= 4.0
    return Assembled(q, gap, limit)


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
        ahead = problem.integrate(point.q, velocity * stride)
        candidate = _correct(problem, target(ahead) if last else ahead, point, pace * stride, last)
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
    factors = factorise(scaled.take(problem.partition.passive, axis=1), norm(scaled))
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
    problem: ClosureProblem, q: Array, start: Closed, motion: float, last: bool
) -> Closed | None:
    """Newton on the passive joints; None unless it contracts at once and stays on the mode.

    A first correction that is small beside the predicted motion, and each next one small
    beside the one before, say that the prediction was close to the path. K* changing by less
    than its smallest singular value says that no singularity lies between them. Within the
    tolerance there is nothing left to tell apart: there it only polishes, slowly at a fold.
    """
    partition = problem.partition
    enough = _ROUNDING * partition.length if last else problem.tolerance
    allowed, previous_gap = _LARGEST_CORRECTION * motion, np.inf
    for iteration in range(1, _MOST_CORRECTIONS):
        residual, jacobian = problem.evaluate(q)
        gap = problem.gap(residual)
        closed = gap <= problem.tolerance
        if gap <= enough or (closed and gap > 0.5 * previous_gap):
            return _same_mode(start, _point(problem, q, gap, jacobian, iteration), partition)
        velocity = _newton_step(residual, jacobian, partition)
        size = norm(velocity / partition.column_scale)
        if closed and not np.isfinite(size):
            return _same_mode(start, _point(problem, q, gap, jacobian, iteration), partition)
        if not (closed or size <= allowed):
            return None
        allowed, previous_gap = _SLOWEST_CONTRACTION * size, gap
        q = problem.integrate(q, velocity)
    return None


def _same_mode(start: Closed, point: Closed, partition: Partition) -> Closed | None:
    """Return `point` if no singularity lies between it and `start`, or if it is one itself."""
    rank, passive = partition.passive_rank, partition.passive
    if _is_singular(point, partition):
        return point
    K_star = point.scaled.take(passive, axis=1)
    return point if start.factors.stays_regular_to(K_star, rank) else None


def _newton_step(residual: Array, jacobian: Array, partition: Partition) -> Array:
    """Return v (nv,) that moves the passive joints only: K* φ̇ = −η, smallest φ̇."""
    passive = partition.passive
    velocity = np.zeros(partition.column_scale.size)
    if residual.size == passive.size == partition.passive_rank:
        *_, solution, failed = dgesv(jacobian.take(passive, axis=1), residual)
        velocity[passive] = np.nan if failed else -solution
        return velocity
    scaled = partition.scaled(jacobian).take(passive, axis=1)
    factors = factorise(scaled, norm(scaled))
    error = residual * partition.row_scale
    velocity[passive] = -partition.column_scale[passive] * factors.solve(
        error, partition.passive_rank
    )
    return velocity
