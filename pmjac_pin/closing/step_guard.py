"""StepGuard: whether a step of a path is covered, so that no singularity hides between its ends.

A step leads from a closed pose q₀ to a closed pose q₁ while the motors move straight. Let
p(s) = q₀ ⊕ x(s), 0 ≤ s ≤ 1, be the cubic curve that leaves q₀ and arrives at q₁ as the path does,
with the passive rates −K*⁻¹ K θ̇ there. With A = K*(q₀) of generic rank r, and A⁺ its
pseudoinverse, let

    |A⁺ (K*(p(s)) − A)| ≤ N,    |η(p(s))| ≤ ρ,    |K*(p(s) ⊕ h) − K*(p(s))| ≤ W    for |h| ≤ 2τ

entry by entry, for all s, and τ = (I − N)⁻¹ |A⁺| ρ, where all eigenvalues of N are below 1: only
then has that inverse no negative entry, and is τ a bound. Where W τ ≤ ρ and all eigenvalues of
N + |A⁺| W are below 1 (Perron), Newton's map h − A⁺ η(p(s) ⊕ h) takes |h| ≤ 2τ into itself and
contracts there: for each s there is exactly one closed pose with |h| ≤ 2τ, K* has rank r at it, and
at s = 0 and 1 these are q₀ and q₁. So the path runs from q₀ to q₁ within that tube and meets no
singularity; how it winds in it does not matter.

N and ρ are what is measured at the ends and in the middle and what may lie between: x(s) is known,
and so are bounds on the third derivative of K*(p(s)) and on the fourth of η(p(s)) (`bends`), which
are all that interpolation between the measured points leaves out.

A short step needs neither the middle nor the rates. With x(s) = s x the straight line between its
ends, f(s) of K* or η is off what is linear between its ends by |f″|/8, and so

    N = |A⁺ (K*(q₁) − A)| + |A⁺| |K*″|/8,    ρ = |η″|/8.

Where the motors do not move straight, p(s) has their values and rates at both ends, and whatever
their own path strays from that cubic by, |θ(s) − θ_p(s)| ≤ α, opens the loops by |K| α more, and
lets K* change by as much more as such a motion bends it.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from pmjac_pin.closing.arms import Arms
from pmjac_pin.closing.bends import Bends, MotionSeries
from pmjac_pin.closing.closed import Closed
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.model.joint_kinds import kind_of
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, read_only
from pmjac_pin.values.lapack import solved

QUADRATIC = 3**0.5 / 216.0  # of |f‴|: f between its values at 0, ½ and 1
CHORD = 1.0 / 8.0  # of |f″|: f between its values at 0 and 1
CUBIC = 1.0 / 384.0  # of |f⁗|: f between its values and slopes at 0 and 1
SLOPES = 8.0 / 27.0  # of |f'|: what such slopes at both ends add
PARABOLA = 1.25  # of the largest of three values at 0, ½ and 1: that of the parabola through them
MARGIN = 1.1  # for rounding, and so that ends are not nearly singular


class _ScaledStep(NamedTuple):
    """What is known of a step, all of it scaled: A⁺, and the changes A⁺ΔK* that were measured.

    The first is that at the end; a second, that in the middle beyond half the first. `left_out` and
    `open_by` bound what interpolation leaves out of K* (p, m_p), and η (p,); `aside` (nv,) is what
    motors stray from the curve by.
    """

    partition: Partition
    motion: MotionSeries
    inverse: Array
    changes: tuple[Array, ...]
    left_out: Array
    open_by: Array
    aside: Array | None


class StepGuard:
    """Covers the steps of a mechanism's paths.

    Parameters
    ----------
    model : pin.Model
    arms : Arms
        Of its loops.
    """

    __slots__ = ("_bends", "_bounded", "_curved", "_curves", "_model")

    def __init__(self, model: pin.Model, arms: Arms) -> None:
        self._model, self._bends = model, Bends(arms)
        self._curves = np.zeros(model.nv, dtype=bool)
        for joint in list(model.joints)[1:]:
            kind = kind_of(joint)
            self._curves[joint.idx_v : joint.idx_v + joint.nv] = kind is None or kind.curved
        self._curved = bool(self._curves.any())
        self._bounded = len(arms.rates) > 0

    def covers(
        self,
        problem: ClosureProblem,
        start: Closed,
        end: Closed,
        leaving: Array,
        arriving: Array,
        *,
        aside: Array | None = None,
    ) -> bool:
        """Tell whether the path from one closed pose to another is proven regular.

        Parameters
        ----------
        problem : ClosureProblem
        start, end : Closed
            Of the generic rank.
        leaving, arriving : ndarray, shape (nv,)
            The path's rates at the ends, for s from 0 to 1.
        aside : ndarray, shape (nv,), optional
            How far motors are from the cubic curve at most, m or rad: 0 where they move straight.
        """
        if not problem.partition.passive_rank:
            return True
        step = self._cubic(problem, (start, end), (leaving, arriving), aside)
        # Loops that follow one another show in the joints themselves, what turns as a whole in
        # the singular vectors.
        return self._contracts(step, None) or self._contracts(
            step, start.factors.right[: problem.partition.passive_rank].T
        )

    def _cubic(
        self,
        problem: ClosureProblem,
        ends: tuple[Closed, Closed],
        rates: tuple[Array, Array],
        aside: Array | None,
    ) -> _ScaledStep:
        """Return what is measured and bounded of a step along the cubic curve."""
        (start, end), partition = ends, problem.partition
        passive = partition.passive
        inverse = start.factors.inverse(partition.passive_rank)
        half, motion = self._curve(start.q, end.q, *rates)
        residual, jacobian = problem.evaluate(problem.integrate(start.q, half))
        straight = inverse.dot((end.scaled - start.scaled).take(passive, axis=1))
        off = self._bends.off_closure * self._bends.block_norms(residual)[:, None]
        left_out = (QUADRATIC * self._bends.rates(motion) + off) * partition.scale
        scaled = jacobian * partition.scale
        open_by = self._open_by(motion, partition.row_scale, end.residual - start.residual)
        middle = inverse.dot((scaled - start.scaled).take(passive, axis=1))
        if aside is not None:
            beyond = left_out + self._bends.within(motion, aside) * partition.scale
            seen = start.scaled, scaled, end.scaled
            open_by += _largest_entries(seen, beyond).dot(aside / partition.column_scale)
        changes = straight, middle - 0.5 * straight
        left_out = left_out.take(passive, axis=1)
        return _ScaledStep(partition, motion, inverse, changes, left_out, open_by, aside)

    def covers_straight(self, problem: ClosureProblem, start: Closed, end: Closed) -> bool:
        """Tell whether the ends alone prove the path regular, its motors moving straight.

        False where that is not tried: of motors whose steps do not add up, of idle motions, and of
        joints that are not known, where nothing bounds what lies between.
        """
        partition = problem.partition
        passive = partition.passive
        if partition.passive_rank < passive.size or not passive.size:
            return not passive.size
        if not self._bounded or (self._curved and self._curves[partition.actuated].any()):
            return False
        way = pin.difference(self._model, start.q, end.q)
        motion = self._bends.straight(start.q, self._bends.speeds(way))
        open_by, left_out = self._bends.bending(motion)
        inverse = start.factors.inverse(partition.passive_rank)
        change = inverse.dot((end.scaled - start.scaled).take(passive, axis=1))
        step = _ScaledStep(
            partition,
            motion,
            inverse,
            (change,),
            (CHORD * left_out * partition.scale).take(passive, axis=1),
            (CHORD * open_by + self._bends.rounding(motion)) * partition.row_scale,
            None,
        )
        return self._contracts(step, None)

    def _open_by(self, motion: MotionSeries, row_scale: Array, rounding: Array) -> Array:
        """Return how far the cubic curve opens the loops at most, whose ends differ by rounding."""
        bound = CUBIC * self._bends.residual(motion) + self._bends.rounding(motion)
        bound *= row_scale
        bound += SLOPES * np.abs(rounding)
        return bound

    def _curve(
        self, first: Array, last: Array, leaving: Array, arriving: Array
    ) -> tuple[Array, MotionSeries]:
        """Return x(½), and the series along the cubic curve x(s)."""
        way = pin.difference(self._model, first, last)
        if self._curved:
            slope = pin.dDifference(self._model, first, last, pin.ArgumentPosition.ARG1)
            arriving = slope.dot(arriving)
        third = 6.0 * (leaving + arriving - 2.0 * way)
        second = 6.0 * way - 4.0 * leaving - 2.0 * arriving
        rates = np.array([leaving, arriving, third, second, second + third])
        u0, u1, c, b0, b1 = self._bends.speeds(rates)
        # x'(s) lies between its ends but for s (1 − s) x‴/2.
        speeds = np.array([np.maximum(u0, u1) + c / 8.0, np.maximum(b0, b1), c])
        return 0.5 * way + 0.125 * (leaving - arriving), self._bends.motion(first, speeds)

    def _contracts(self, step: _ScaledStep, basis: Array | None) -> bool:
        """Tell whether Newton's map contracts all along, measured in an orthonormal basis."""
        inverse, changes = step.inverse, step.changes
        mixed = None
        if basis is not None:
            mixed, inverse = np.abs(basis), basis.T.dot(inverse)
            changes = tuple(basis.T @ change @ basis for change in changes)
        sizes = np.abs(inverse)
        left_out = step.left_out if mixed is None else step.left_out.dot(mixed)
        change = sizes.dot(left_out)
        for measured in changes:
            change += np.abs(measured)
        identity, ones = _unit_matrix(len(change))
        open_by = step.open_by
        for _ in range(2):
            # With the ones: only where I − N has an inverse without negative entries is it a bound.
            bounds = solved(identity - change, np.array((sizes.dot(open_by), ones)).T)
            if bounds is None or not _at_least_one(bounds[:, 1]):
                return False
            tube = 2.0 * bounds[:, 0]
            within = self._within(step, tube, mixed)
            # Along the way from p(s) by h its mean is half of it, unless motors stray, too.
            beyond = (0.5 if step.aside is None else 1.0) * within.dot(tube)
            if np.count_nonzero(beyond <= open_by) == open_by.size:
                break
            open_by = np.maximum(open_by, 2.0 * beyond)
        else:
            return False
        change += sizes.dot(within)
        weights = solved(identity - MARGIN * change, ones)
        return weights is not None and _at_least_one(weights)

    def _within(self, step: _ScaledStep, tube: Array, mixed: Array | None) -> Array:
        """Return a bound on how K* changes in the tube, scaled, (p, m_p)."""
        partition = step.partition
        reach = np.zeros(partition.column_scale.size) if step.aside is None else step.aside.copy()
        joints = tube if mixed is None else mixed.dot(tube)
        reach[partition.passive] = joints * partition.passive_scale
        bound = self._bends.within(step.motion, reach) * partition.scale
        bound = bound.take(partition.passive, axis=1)
        return bound if mixed is None else bound.dot(mixed)


def _largest_entries(seen: tuple[Array, Array, Array], beyond: Array) -> Array:
    """Return sizes of [K K*] on a step at most: of the parabola through three, and beyond it."""
    start, middle, end = seen
    sizes: Array = np.maximum.reduce([np.abs(start), middle, -middle, np.abs(end)])
    return PARABOLA * sizes + beyond


def _at_least_one(weights: Array) -> bool:
    """Tell whether all x of (I − N) x = 1 are: only then are the eigenvalues of an N ≥ 0 below 1.

    N x = x − 1 < x then (Collatz and Wielandt); and x = 1 + N 1 + N² 1 + … else has no sum.
    """
    return int(np.count_nonzero((weights >= 1.0) & (weights < np.inf))) == weights.size


@cache
def _unit_matrix(count: int) -> tuple[Array, Array]:
    """Return the identity and a vector of ones."""
    return read_only(np.eye(count)), read_only(np.ones(count))
