"""Many paths at once, each a straight one of the motors, as `closure.follow` walks a single one.

The paths take their steps together, each of its own length. Whether a step is covered is judged by
norms here (`recorded_step`), which may ask for shorter steps than `StepGuard`, and so may where a
correction counts as small; what the paths lead to does not depend on either.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.closing import closure
from pmjac_pin.closing.closed import closed_point
from pmjac_pin.closing.closure_problem import ROUNDING, ClosureProblem
from pmjac_pin.closing.step_guard import MARGIN
from pmjac_pin.kinematics.many import ManyPoses
from pmjac_pin.values.arrays import Array, Index, Mask

Run = Callable[[Tape, Array], Array]


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Poses and what is known there, one row each.

    Attributes
    ----------
    q : ndarray, shape (b, nq)
    gap : ndarray, shape (b,)
        How far the loops are open, m.
    inverse, size : ndarray, shape (b,)
        ‖K*⁻¹‖ and ‖[K K*]‖, dimensionless.
    newton, velocity : ndarray, shape (b, nv)
        What closes the loops, and how all joints follow the motors.
    """

    q: Array
    gap: Array
    inverse: Array
    size: Array
    newton: Array
    velocity: Array

    def __getitem__(self, which: Index | Mask) -> Points:
        return Points(*(getattr(self, one.name)[which] for one in fields(self)))

    def put(self, which: Index, others: Points) -> None:
        """Take others' rows in place of some of these."""
        for one in fields(self):
            getattr(self, one.name)[which] = getattr(others, one.name)


@dataclass(frozen=True, slots=True, eq=False)
class Paths:
    """Where paths ended.

    Attributes
    ----------
    points : Points
        A closed pose each.
    share : ndarray, shape (b,)
        Of the way; 1 at the target.
    settled : ndarray of bool, shape (b,)
        At the target, at a pose where K* is singular, or where steps become too small beside one.
        The others ran out of steps, or ended where the bounds alone call K* singular, or right
        beside a target that may be: what `close` says of them is not known here.
    """

    points: Points
    share: Array
    settled: Mask


@dataclass(frozen=True, slots=True, eq=False)
class Walker:
    """Follows paths of one mechanism.

    Attributes
    ----------
    problem : ClosureProblem
    poses : ManyPoses
    point, step : Tape
        `RecordedRates.point_tape` and `step_tape`.
    run : callable
        (tape, inputs (k, b)) ↦ outputs.
    """

    problem: ClosureProblem
    poses: ManyPoses
    point: Tape
    step: Tape
    run: Run

    def walk(
        self, q: Array, displacement: Array, at_target: Callable[[Array, Index], Array]
    ) -> Paths:
        """Walk from closed poses.

        Parameters
        ----------
        q : ndarray, shape (b, nq)
        displacement : ndarray, shape (b, n)
            Of the motors, over the whole path.
        at_target : callable
            (q, which paths) ↦ q with the motors at their targets, exactly.
        """
        here, share, step = self.at(q.copy(), displacement), np.zeros(len(q)), np.ones(len(q))
        going = np.flatnonzero(self.regular(here))
        for _ in range(closure.MOST_STEPS):
            going, stride = self._strides(here, going, step, 1.0 - share)
            if not going.size:
                break
            last = stride >= 1.0 - share[going]
            tangent = here.velocity[going] * stride[:, None]
            ahead = self.poses.moved(here.q[going], tangent)
            ahead[last] = at_target(ahead[last], going[last])
            step[going] = 0.5 * stride
            found, good = self._correct(ahead, tangent, displacement[going], last)
            arriving = found.velocity * stride[good, None]
            covered = self._covers(here.q[going[good]], found.q, tangent[good], arriving)
            good = good[covered]
            done, found = going[good], found[covered]
            here.put(done, found)
            share[done] = np.where(last[good], 1.0, share[done] + stride[good])
            step[done] = 2.0 * stride[good]
            ended = done[last[good] | ~self.regular(found)]
            going = np.setdiff1d(going, ended, assume_unique=True)
        left = (1.0 - share) * self._size_of_motors(displacement)
        settled = left > closure.HARDLY_ANYTHING * self.problem.partition.length
        settled[going] = False
        for index in np.flatnonzero(settled & ~self.regular(here)).tolist():
            factors = closed_point(self.problem, here.q[index]).factors
            settled[index] = factors.rank < self.problem.partition.passive_rank
        return Paths(here, share, settled | (share == 1.0))

    def at(self, q: Array, displacement: Array) -> Points:
        """Return what is known at poses, closed or not."""
        gap, inverse, size, *motions = self.run(self.point, np.vstack([q.T, displacement.T]))
        newton, velocity = np.reshape(motions, (2, len(motions) // 2, len(q))).transpose(0, 2, 1)
        return Points(q, gap, inverse, size, newton, velocity)

    def regular(self, points: Points) -> Mask:
        """Tell where K* has its generic rank for certain."""
        partition = self.problem.partition
        size = np.maximum(points.size, partition.least_size)
        return np.asarray(points.inverse * partition.rank_tolerance * size < 1.0)

    def _strides(self, here: Points, going: Index, step: Array, left: Array) -> tuple[Index, Array]:
        """Return the paths that go on, and how far in one step, as a share of the whole way."""
        length = self.problem.partition.length
        pace = self._size(here.velocity[going])
        most = np.where(pace > 0.0, closure.LARGEST_STEP * length / np.maximum(pace, 1e-300), 1.0)
        stride = np.minimum(np.minimum(step[going], most), left[going])
        on = (stride == left[going]) | (stride * pace >= closure.SMALLEST_STEP * length)
        return going[on], stride[on]

    def _correct(
        self, q: Array, tangent: Array, displacement: Array, last: Mask
    ) -> tuple[Points, Index]:
        """Newton on the passive joints, as `closure` does; return what it closed, and which."""
        enough = np.where(last, ROUNDING, closure.WALKING) * self.problem.partition.length
        allowed = closure.LARGEST_CORRECTION * self._size(tangent)
        before = np.full(len(q), np.inf)
        found = self.at(q, displacement)
        left, at, good = np.arange(len(q)), found, np.zeros(len(q), dtype=bool)
        for _ in range(closure.MOST_CORRECTIONS):
            size, closed = self._size(at.newton), at.gap <= self.problem.tolerance
            done = closed & ~np.isfinite(size) | (at.gap <= enough[left])
            done |= closed & (at.gap > 0.5 * before[left])
            found.put(left[done], at[done])
            good[left[done]] = True
            on = ~done & (closed | (size <= allowed[left]))
            left, at = left[on], at[on]
            if not left.size:
                break
            allowed[left], before[left] = closure.SLOWEST_CONTRACTION * size[on], at.gap
            at = self.at(self.poses.moved(at.q, at.newton), displacement[left])
        good &= found.inverse * found.size * closure.NO_INVERSE < 1.0
        return found[good], np.flatnonzero(good)

    def _covers(self, start: Array, end: Array, leaving: Array, arriving: Array) -> Mask:
        """Tell which steps are proven regular, as `StepGuard.covers` does."""
        if not len(start):  # not every SciPy turns nothing
            return np.zeros(0, dtype=bool)
        way = self.poses.between(start, end)
        arriving = self.poses.arriving(way, arriving)
        half = self.poses.moved(start, 0.5 * way + 0.125 * (leaving - arriving))
        inputs = np.vstack([x.T for x in (start, end, half, leaving, arriving, way)])
        change, rho, tau, within, inverse = self.run(self.step, inputs)
        contracts = MARGIN * (change + inverse * within) < 1.0
        return np.asarray(contracts & (change < 1.0) & (within * tau <= rho))

    def _size_of_motors(self, displacement: Array) -> Array:
        partition = self.problem.partition
        scaled = displacement / partition.column_scale[partition.actuated]
        return np.asarray(np.linalg.norm(scaled, axis=1))

    def _size(self, motion: Array) -> Array:
        """Return the norms of motions (b, nv), a rad counted as one length."""
        norms: Array = np.linalg.norm(motion / self.problem.partition.column_scale, axis=1)
        return norms
