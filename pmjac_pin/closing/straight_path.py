"""The straight way of the motors from a closed pose, and its arrival.

Direct kinematics by continuation: `follow` walks the motors straight to their targets, predicting
along φ̇ = −K*⁻¹ K θ̇ and correcting by Newton, in steps short enough that it cannot change the
assembly mode unseen.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pmjac_pin.closing.closed import (
    Closed,
    closed_point,
    is_invertible,
    is_singular,
    path_velocity,
)
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.damped_closure import assemble
from pmjac_pin.closing.newton_correction import corrected
from pmjac_pin.closing.step_guard import StepGuard
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, norm

MOST_STEPS = 20_000  #: tried in one path

# All lengths relative to the mechanism's characteristic length.
LARGEST_STEP = 0.25  # motion in one step, a rad counted as one length
SMALLEST_STEP = 1e-9  # motion in one step that is not the last: less is not resolved
HARDLY_ANYTHING = 1e-4  # left of the motors' path, where a last step may reach a singular target
_NOTHING = 1e-5  # left of it, where such a target is reached as it is
_BESIDE_A_FOLD = (
    1e-5  # lengths or rad: both modes that meet at a fold are as near when the gap is 1e-12
)


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
