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
    that loops forbid to move so (`over_actuation`). Not `proven` where the target is singular, and
    so near to it nothing tells which of the modes that meet there has led to it.
    """

    point: Closed
    share: float
    iterations: int
    spent: bool = False
    strayed: Array | None = None
    proven: bool = True


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
    way = _StraightWay(problem, guard, displacement, target)
    if way.length() > MOST_STEPS * LARGEST_STEP * partition.length:
        return Followed(start, 0.0, 0, spent=True)
    if is_singular(start, partition):
        return _arrived(way, Followed(start, 0.0, 0))
    return _arrived(way, way.walked(start, ends_path))


class _StraightWay(NamedTuple):
    """Where the motors are led to, and along which displacement (n,)."""

    problem: ClosureProblem
    guard: StepGuard
    displacement: Array
    target: Callable[[Array], Array]

    def from_share(self, share: float) -> _StraightWay:
        """Return what is left of it."""
        return self._replace(displacement=(1.0 - share) * self.displacement)

    def is_open_midway(self, start: Closed) -> bool:
        """Tell whether the loops do not close where half of a short way leads."""
        half = np.zeros(self.problem.partition.column_scale.size)
        half[self.problem.partition.actuated] = 0.5 * self.displacement
        return beside(self.problem, start.q, self.problem.integrate(start.q, half)) is None

    def length(self) -> float:
        """Return how far it is, m or rad, a rad counted as one length."""
        return norm(self.displacement / self.problem.partition.motor_scale)

    def walked(self, start: Closed, ends: Callable[[Closed, Closed, Partition], bool]) -> Followed:
        """Go by covered steps to the target, or to where steps end: asked from one to the next."""
        partition, guard, problem = self.problem.partition, self.guard, self.problem
        point, share, step, iterations = start, 0.0, 1.0, 0
        velocity = path_velocity(start, self.displacement, partition)
        for _ in range(MOST_STEPS):
            pace = norm(velocity / partition.column_scale) / partition.length
            if (stride := _stride(pace, step, 1.0 - share)) is None:
                return Followed(point, share, iterations)
            last, step = stride == 1.0 - share, 0.5 * stride
            tangent = velocity * stride
            ahead = problem.integrate(point.q, tangent)
            candidate = corrected(problem, self.target(ahead) if last else ahead, tangent, last)
            if candidate is None:
                continue
            # Where ends alone prove K* regular it is invertible: at a pose where it is not, its
            # change from the start, which is regular, would not contract.
            if last and guard.covers_straight(problem, point, candidate):
                return Followed(candidate, 1.0, iterations + candidate.iterations)
            if not is_invertible(candidate, partition):
                continue
            arriving = path_velocity(candidate, self.displacement, partition)
            if not guard.covers(problem, point, candidate, tangent, arriving * stride):
                continue
            iterations += candidate.iterations
            before, point, velocity = point, candidate, arriving
            share = 1.0 if last else share + stride
            if last or ends(before, point, partition):
                return Followed(point, share, iterations)
            step = 2.0 * stride
        return Followed(point, share, iterations, spent=True)


def ends_path(before: Closed, point: Closed, partition: Partition) -> bool:
    """Tell whether a path ends at a pose: where K* is singular, or sinks away."""
    return is_singular(point, partition) or _sinks_away(before, point, partition)


def _stride(pace: float, step: float, left: float) -> float | None:
    """Return how far to go of what is left, at lengths a unit of the way; None where too little."""
    step = min(step, LARGEST_STEP / pace if pace else 1.0)
    if step >= left:
        return left
    return None if step * pace < SMALLEST_STEP else step


def _sinks_away(before: Closed, point: Closed, partition: Partition) -> bool:
    """Tell whether K* has come nearer to losing its rank and is beyond its tolerance already."""
    if not _is_weak(point, partition):
        return False
    # In m: beside a crossing all of K* is small.
    rank = partition.passive_rank
    weakest, earlier = (one.factors.singular_values[rank - 1] for one in (point, before))
    return bool(weakest < earlier)


def _is_weak(point: Closed, partition: Partition) -> bool:
    """Tell whether K* is below its generic rank beside the size that it has generically."""
    rank, least = partition.passive_rank, partition.rank_tolerance * partition.size
    return bool(rank) and not point.factors.exceeds(rank, least)


def _arrived(way: _StraightWay, ended: Followed) -> Followed:
    """Return the target itself, when it is singular and the path ended right beside it.

    How long the steps were decides where a path ends within what counts as singular: so whether it
    arrives is decided by what is proven of the rest of the way, to where K* has no inverse.
    """
    problem, partition = way.problem, way.problem.partition
    rest = way.from_share(ended.share)
    if ended.share == 1.0 or rest.length() > HARDLY_ANYTHING * partition.length:
        return ended
    onward = Followed(ended.point, 0.0, 0)
    if is_invertible(ended.point, partition):
        onward = rest.walked(ended.point, _nowhere)
    iterations = ended.iterations + onward.iterations
    if onward.share == 1.0:
        weak = is_singular(onward.point, partition) or _is_weak(onward.point, partition)
        return Followed(onward.point, 1.0, iterations) if weak else ended
    rest = rest.from_share(onward.share)
    if rest.length() > _NOTHING * partition.length or rest.is_open_midway(onward.point):
        return ended
    # Nothing is proven of what lies here: no pose that is not singular itself comes of it.
    found = beside(problem, onward.point.q, way.target(onward.point.q))
    if found is None or not is_singular(found, partition):
        return ended
    return Followed(found, 1.0, iterations + found.iterations, proven=False)


def _nowhere(before: Closed, point: Closed, partition: Partition) -> bool:
    """Tell that a path ends at no pose, before steps do."""
    return False


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
    velocity = passive_motion(-moves, partition)
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
        q = problem.integrate(q, passive_motion(moves, partition))
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


def passive_motion(moves: Array, partition: Partition) -> Array:
    """Return v (nv,) of the passive joints' moves (m_p,), which are without dimension."""
    velocity = np.zeros(partition.column_scale.size)
    velocity[partition.passive] = moves * partition.passive_scale
    return velocity
