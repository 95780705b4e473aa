"""Search: closed poses from many random starts, and how much of the start space is settled.

Damped Newton (Levenberg–Marquardt) runs from all starts of a batch at once. The share p of the
start space that leads to poses not seen yet is bounded with a confidence 1 − δ: had n starts in
a row, drawn after the last new pose, met none, then (1 − p)ⁿ ≥ δ, hence p ≤ −ln δ / n. The k-th
such question gets δₖ = 6δ/(πk)², so that all of them together err with probability δ at most.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pmjac_pin.closing.held_motors import ROUNDED_SHARE
from pmjac_pin.closing.levenberg_marquardt import (
    Patience,
    by_normal_equations,
    damped_step,
    descend,
    norms,
    points_at,
)
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.values.arrays import Array

_STEPS_OF_A_START = 60  # of one start
_CLOSED = 1e-9  # of the characteristic length: two steps of Newton's do the rest
_FORGOTTEN = 0.3  # of how a joint moved the loops, in one step
_FALLING = 1e-8  # of itself: a gap within the tolerance that falls less is the least there is
_IDLE_COLUMN = 1e-6  # of the largest column of K*: one that is smaller moves the loops by nothing
_STUCK = 1e8  # damping at which a start is given up
_CREEPING = 1e-4  # of itself: an open gap that falls less in each of so many steps stays open
_STEPS_PATIENCE = 3
_STILL_OPEN = 1e-7  # of itself: an open gap that falls less stays open, however patient one is
_AS_PROMISED = 0.25  # of the fall to first order
_LAST_STEPS = Patience(steps=2, enough=0.0)


class Ends(NamedTuple):
    """Where starts lead to, rows of q.

    `closed` where the loops are, `open` where they were given up at a gap that hardly falls;
    `spent` where the steps were used up.
    """

    closed: Array
    open: Array
    spent: Array


@dataclass(frozen=True, slots=True, eq=False)
class ManyClosures:
    """Damped Newton on the passive joints, over many poses.

    Attributes
    ----------
    problem : SearchProblem
    strides : ndarray, shape (m_p,)
        What one step may move each passive degree of freedom alone, m; a rad counts as one length.
    """

    problem: SearchProblem
    strides: Array

    def closed(self, starts: Array) -> Array:
        """Return the rows of q that close the loops, of those that starts (b, nq) lead to."""
        return self.ends(starts).closed

    def ends(self, starts: Array) -> Ends:
        """Return where starts (b, nq) lead to.

        Loops with redundant rows that close to a tolerance only are closed as far as they can be:
        the many poses around that are within the tolerance, too, are that one. Without redundant
        rows a gap that stays is none of rounding, but of a fold that is not reached.
        """
        return self._ends(starts, _CREEPING)

    def finished(self, ends: Ends) -> Ends:
        """Go on from the ends that are none yet, for as many steps and with more patience.

        Those are the starts that have used up their steps, and those that were given up though
        a whole step brings them nearer by as much as the loops promise: slides that have far to
        go at a small angle. What is `spent` then has not been decided.
        """
        return self._ends(np.concatenate([ends.spent, self._falling(ends.open)]), _STILL_OPEN)

    def nearly(self, q: Array) -> Array:
        """Return the rows of q at which the gap is as small as rounded numbers leave it."""
        if not len(q):
            return q
        gap = norms(self._descent.evaluate(q)[0])
        return np.asarray(q[gap <= ROUNDED_SHARE * self.problem.length])

    @property
    def _descent(self) -> _ManyPoses:
        return _ManyPoses(self.problem, self.strides)

    def _falling(self, q: Array) -> Array:
        """Return the rows whose gap falls along an undamped step, as its first order says."""
        if not len(q):
            return q
        descent = self._descent
        points = points_at(descent, q)
        step = damped_step(descent, points, np.zeros(len(q)))
        ahead = norms(points.error + np.einsum("bij,bj->bi", points.rows, step))
        gap = norms(points.error)
        fall = gap - norms(descent.evaluate(descent.moved(q, step))[0])
        return np.asarray(q[(fall > _STILL_OPEN * gap) & (fall > _AS_PROMISED * (gap - ahead))])

    def _ends(self, starts: Array, creeps: float) -> Ends:
        if not len(starts):
            return Ends(starts, starts, starts)
        partition = self.problem.partition
        redundant = partition.row_scale.size > partition.passive_rank
        patience = Patience(
            steps=_STEPS_OF_A_START,
            enough=_CLOSED * self.problem.length,
            tolerance=self.problem.mechanism.problem.tolerance if redundant else 0.0,
            damping=1e-2,
            least=1e-9,
            most=_STUCK,
            shrinks=5.0,
            grows=5.0,
            grows_within=5.0,
            falling=_FALLING,
            creeping=creeps,
            creeping_steps=_STEPS_PATIENCE,
        )
        ends = descend(self._descent, starts, patience)
        left = ~ends.closed & ~ends.spent
        return Ends(self._polished(ends.q[ends.closed]), ends.q[left], ends.q[ends.spent])

    def _polished(self, q: Array) -> Array:
        """Return closed rows after Newton's last steps, where these close them further.

        Beside a singularity poses that are closed to little are far from each other, though one.
        """
        return descend(self._descent, q, _LAST_STEPS).q if len(q) else q


class _ManyPoses:
    """The passive joints of many poses: what is to be closed.

    Each unknown is eased by what it moves the loops by (Marquardt's scaling), so that damping
    holds back no joint for moving the loops little: a platform's turn moves them by its own size
    only, however long its legs are.
    """

    __slots__ = ("_problem", "_scale", "_strides")

    solution = staticmethod(by_normal_equations)

    def __init__(self, problem: SearchProblem, strides: Array) -> None:
        self._problem, self._strides = problem, strides
        self._scale = problem.partition.column_scale[problem.partition.passive]

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Return η in m and K* on the scaled columns."""
        partition = self._problem.partition
        residual, jacobian = self._problem.loops.evaluate(q)
        K_star = jacobian.take(partition.passive, axis=2)
        K_star *= partition.row_scale[:, None] * self._scale
        return residual * partition.row_scale, K_star

    def ease(self, q: Array, error: Array, rows: Array, before: Array | None) -> Array:
        """Return one by the sizes of K*'s columns.

        They shrink slowly on the way: a column that vanishes where the loops close would have its
        joint thrown about there.
        """
        sizes = np.sqrt(np.einsum("bij,bij->bj", rows, rows))
        if before is not None:
            sizes = np.maximum(_FORGOTTEN / before, sizes)
        sizes = np.maximum(sizes, _IDLE_COLUMN * sizes.max(axis=1, initial=0.0, keepdims=True))
        return np.asarray(1.0 / np.where(sizes > 0.0, sizes, 1.0))  # no joint may move the loops

    def fading(self, gap: Array) -> Array:
        """Return the gap, in strides."""
        return gap / float(self._strides.max(initial=self._problem.length))

    def bounded(self, q: Array, step: Array) -> Array:
        """Return steps of the scaled columns, each no longer than a stride."""
        return np.asarray(step / np.maximum(norms(step / self._strides), 1.0)[:, None])

    def moved(self, q: Array, step: Array) -> Array:
        """Return q ⊕ v."""
        partition = self._problem.partition
        velocity = np.zeros((len(q), partition.column_scale.size))
        velocity[:, partition.passive] = step * self._scale
        return self._problem.tree.moved(q, velocity)


def unseen_share(starts: int, question: int, confidence: float) -> float:
    """Return the bound on the share of start space whose pose has not been seen.

    Parameters
    ----------
    starts : int
        In a row without a new pose, drawn after the last new one.
    question : int
        How many such rows have been begun.
    confidence : float
        1 − δ.

    Examples
    --------
    >>> round(unseen_share(4000, 1, 0.99), 6)
    0.001276
    """
    if starts == 0:
        return 1.0
    error = 6.0 * (1.0 - confidence) / (math.pi * question) ** 2
    return min(1.0, -math.log(error) / starts)
