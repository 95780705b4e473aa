"""Many paths at once, each a straight one of the motors, as `straight_path.follow` walks one.

The paths take their steps together, each of its own length. Whether a step is covered is judged by
norms here (`recorded_step`), which may ask for shorter steps than `StepGuard`, and so may where a
correction counts as small; what the paths lead to does not depend on either, but for what
idles, which `many_idle_paths` brings back.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.closing import newton_correction, straight_path
from pmjac_pin.closing.closed import NO_INVERSE, closed_point
from pmjac_pin.closing.closure_problem import ROUNDING, ClosureProblem
from pmjac_pin.closing.path_points import PathPoints
from pmjac_pin.closing.recorded_step import BOUNDS
from pmjac_pin.closing.step_guard import MARGIN
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.rates.rank_bounds import RankBounds
from pmjac_pin.values.arrays import Array, Index, Mask

LONG, FEW = 300, 2  # so few paths with so many steps behind them are walked one by one sooner

GoOn: TypeAlias = Callable[[], object]


class Paths(NamedTuple):
    """Where paths ended.

    Attributes
    ----------
    q : ndarray, shape (b, nq)
        A closed pose each.
    share : ndarray, shape (b,)
        Of the way; 1 at the target.
    settled : ndarray of bool, shape (b,)
        At the target, at a pose where K* is singular, or where steps become too small beside one.
        The others ran out of steps, or ended where the bounds alone call K* singular, or right
        beside a target that may be: what `close` says of them is not known here.
    """

    q: Array
    share: Array
    settled: Mask

    def less(self, doubtful: Mask) -> Paths:
        """Return paths of which these are not settled where they end early."""
        return self._replace(settled=(self.settled & ~doubtful) | (self.share == 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class Walker:
    """Follows paths of one mechanism.

    Attributes
    ----------
    problem : ClosureProblem
    coordinates : JointCoordinates
    move, arrival, leg : Tape
        `RecordedRates.move_tape` and `arrival_tape`, and `leg_tape`.
    """

    problem: ClosureProblem
    coordinates: JointCoordinates
    move: Tape
    arrival: Tape
    leg: Tape

    def walk(
        self,
        q: Array,
        displacement: Array,
        target: Array,
        go_on: GoOn,
        most_steps: int = straight_path.MOST_STEPS,
        *,
        design: Array | None = None,
        ends: tuple[Array, Array] | None = None,
    ) -> Paths:
        """Walk from closed poses.

        Parameters
        ----------
        q : ndarray, shape (b, nq)
        displacement, target : ndarray, shape (b, n)
            Of the motors: over the whole path, and at its end.
        go_on : callable
            Called now and then; raises where nobody waits any longer.
        most_steps : int
            Tried in each path; what runs out of them is not settled.
        design : ndarray, shape (b, k), optional
            What the programs take of each path's own machine.
        ends : (ndarray, ndarray), shapes (b, nq) and (b,), optional
            Where q and share go.
        """
        own = np.zeros((0, len(q))) if design is None else design.T
        displacement = np.vstack([displacement.T, own])
        here = self.at(q.T, displacement)
        share, step = np.zeros(len(q)), np.ones(len(q))
        going = np.flatnonzero(self.regular(here))
        for tried in range(most_steps):
            go_on()
            going, stride = self._strides(here, going, step, 1.0 - share)
            if going.size <= (FEW if tried >= LONG else 0):
                break
            last, step[going] = stride >= 1.0 - share[going], 0.5 * stride
            steps = stride, last, target[going], displacement[:, going]
            found, good = self._stepped(here[going], *steps)
            done = going[good]
            here.put(done, found)
            share[done] = np.where(last[good], 1.0, share[done] + stride[good])
            step[done] = 2.0 * stride[good]
            ended = done[last[good] | ~self.regular(found)]
            going = np.setdiff1d(going, ended, assume_unique=True)
        doubtful = ~self.regular(here)
        spent = np.zeros(len(q), dtype=bool)
        spent[going] = True
        paths = Paths(here.q.T.copy(), share, ~spent)
        if ends is not None:
            ends[0][:], ends[1][:] = paths.q, paths.share
        if design is not None:
            return paths.less(doubtful)
        return judged(self.problem, paths, displacement.T, doubtful)

    def at(self, q: Array, displacement: Array, v: Array | None = None) -> PathPoints:
        """Return what is known at q ⊕ v, shapes (nq, b), (n, b) and (nv, b), closed or not.

        Below the displacement may stand what the program takes of each machine.
        """
        nv = self.problem.partition.column_scale.size
        motion = np.zeros((nv, q.shape[1])) if v is None else v
        return PathPoints(run(self.arrival, np.vstack([q, motion, displacement])), len(q))

    def regular(self, points: PathPoints) -> Mask:
        """Tell where K* has its generic rank for certain."""
        bounds = RankBounds.of(self.problem.partition)
        return np.asarray(bounds.regular(points.inverse, points.size))

    def _strides(
        self, here: PathPoints, going: Index, step: Array, left: Array
    ) -> tuple[Index, Array]:
        """Return the paths that go on, and how far in one step, as a share of the whole way."""
        length, pace = self.problem.partition.length, here.pace[going]
        most = np.where(
            pace > 0.0, straight_path.LARGEST_STEP * length / np.maximum(pace, 1e-300), 1.0
        )
        stride = np.minimum(np.minimum(step[going], most), left[going])
        on = (stride == left[going]) | (stride * pace >= straight_path.SMALLEST_STEP * length)
        return going[on], stride[on]

    def _stepped(
        self, start: PathPoints, stride: Array, last: Mask, target: Array, displacement: Array
    ) -> tuple[PathPoints, Index]:
        """Take one step of each path; return where those lead that are covered, and which."""
        tangent = start.velocity * stride
        ahead = self._ahead(start.q, tangent, last, target)
        allowed = newton_correction.LARGEST_CORRECTION * stride * start.pace
        found, good = self._correct(ahead, allowed, displacement, last)
        steps = [start.q[:, good], found.q, tangent[:, good], found.velocity * stride[good]]
        known = start.inverse[good], found.inverse, displacement[target.shape[1] :, good]
        proven = covered(run(self.leg, np.vstack([*steps, *known])))
        return found[proven], good[proven]

    def _ahead(self, q: Array, tangent: Array, last: Mask, target: Array) -> Array:
        """Return q ⊕ v (nq, b), the motors at their targets (b, n) where the step is the last."""
        ahead, motors = run(self.move, np.vstack([q, tangent])), self.problem.partition.actuated
        ahead[:, last] = self.coordinates.with_values(ahead[:, last].T, motors, target[last]).T
        return ahead

    def _correct(
        self, q: Array, allowed: Array, displacement: Array, last: Mask
    ) -> tuple[PathPoints, Index]:
        """Newton on the passive joints, as `corrected` does; return what it closed, and which."""
        enough = np.where(last, ROUNDING, newton_correction.WALKING) * self.problem.partition.length
        found = self.at(q, displacement)
        left, at, good = np.arange(len(last)), found, np.zeros(len(last), dtype=bool)
        before = np.full(len(last), np.inf)
        earlier, foretold = np.full((2, len(last)), np.nan)
        for _ in range(newton_correction.MOST_CORRECTIONS):
            size, closed = at.correction, at.gap <= self.problem.tolerance
            done = closed & ~np.isfinite(size) | (at.gap <= enough[left])
            done |= closed & ((foretold <= enough[left]) | (at.gap > 0.5 * before))
            if at is not found:
                found.put(left[done], at[done])
            good[left[done]] = True
            on = ~done & (closed | (size <= allowed))
            left = left[on]
            if not left.size:
                break
            at = at[on]
            allowed, before = newton_correction.SLOWEST_CONTRACTION * size[on], at.gap
            foretold = newton_correction.next_correction(earlier[on], size[on])
            earlier = np.where(size[on] > 0.0, size[on], np.nan)
            at = self.at(at.q, displacement[:, left], at.newton)
        good &= found.inverse * found.size * NO_INVERSE < 1.0
        return found[good], np.flatnonzero(good)


def covered(told: Array) -> Mask:
    """Tell which steps are proven regular, by one of the bounds, as `leg_tape` tells them."""
    change, rho, beyond, contraction = told.reshape(BOUNDS, 4, -1).swapaxes(0, 1)
    by_each = (MARGIN * contraction < 1.0) & (change < 1.0) & (beyond <= rho)
    return np.asarray(by_each.any(axis=0))


def judged(problem: ClosureProblem, paths: Paths, displacement: Array, doubtful: Mask) -> Paths:
    """Return paths of which less is settled: what ends early ends for a reason that is certain.

    Parameters
    ----------
    problem : ClosureProblem
    paths : Paths
        Settled where steps did not run out.
    displacement : ndarray, shape (b, n)
        Of the motors, over the whole path.
    doubtful : ndarray of bool, shape (b,)
        Where bounds do not tell that K* is regular.
    """
    partition = problem.partition
    scaled = displacement / partition.column_scale[partition.actuated]
    left = (1.0 - paths.share) * np.linalg.norm(scaled, axis=1)
    settled = paths.settled & (left > straight_path.HARDLY_ANYTHING * partition.length)
    for index in np.flatnonzero(settled & doubtful).tolist():
        factors = closed_point(problem, paths.q[index].copy()).factors
        settled[index] = factors.rank < partition.passive_rank
    return paths._replace(settled=settled | (paths.share == 1.0))
