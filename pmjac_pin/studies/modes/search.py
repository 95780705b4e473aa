"""Search: closed poses from many random starts, and how much of the start space is settled.

Damped Newton (Levenberg–Marquardt) runs from all starts of a batch at once. The share p of the
start space that leads to poses not seen yet is bounded with a confidence 1 − δ: had n starts in
a row, drawn after the last new pose, met none, then (1 − p)ⁿ ≥ δ, hence p ≤ −ln δ / n. The k-th
such question gets δₖ = 6δ/(πk)², so that all of them together err with probability δ at most.

That of one pose, `closing/damped_closure.py`, is another one: here a single pose would take several
times as long, and there hundreds of starts a hundred times, each of them by itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pmjac_pin.closing.held_motors import ROUNDED_SHARE
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.values.arrays import Array

_STEPS_OF_A_START = 60  # of one start
_CLOSED = 1e-9  # of the characteristic length: two steps of Newton's do the rest
_FORGOTTEN = 0.3  # of how a joint moved the loops, in one step
_LAST_STEPS = 2
_FALLING = 1e-8  # of itself: a gap within the tolerance that falls less is the least there is
_IDLE_COLUMN = 1e-6  # of the largest column of K*: one that is smaller moves the loops by nothing
_STUCK = 1e8  # damping at which a start is given up
_CREEPING = 1e-4  # of itself: an open gap that falls less in each of so many steps stays open
_STEPS_PATIENCE = 3
_STILL_OPEN = 1e-7  # of itself: an open gap that falls less stays open, however patient one is
_AS_PROMISED = 0.25  # of the fall to first order


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
        gap = np.linalg.norm(self._scaled(q)[0], axis=1)
        return np.asarray(q[gap <= ROUNDED_SHARE * self.problem.length])

    def _falling(self, q: Array) -> Array:
        """Return the rows whose gap falls along an undamped step, as its first order says."""
        if not len(q):
            return q
        partition = self.problem.partition
        error, rows = self._scaled(q)
        step = self._step(error, rows, _column_norms(rows), np.zeros(len(q)))
        rates = step[:, partition.passive] / partition.column_scale[partition.passive]
        ahead = np.linalg.norm(error + np.einsum("bij,bj->bi", rows, rates), axis=1)
        gap = np.linalg.norm(error, axis=1)
        fall = gap - np.linalg.norm(self._scaled(self.problem.tree.moved(q, step))[0], axis=1)
        return np.asarray(q[(fall > _STILL_OPEN * gap) & (fall > _AS_PROMISED * (gap - ahead))])

    def _ends(self, starts: Array, creeps: float) -> Ends:
        if not len(starts):
            return Ends(starts, starts, starts)
        problem, length = self.problem, self.problem.length
        farthest = float(self.strides.max(initial=length))
        redundant = problem.partition.row_scale.size > problem.partition.passive_rank
        tolerance = problem.tolerance if redundant else 0.0
        q, found, left = starts, [], []
        damping = np.full(len(q), 1e-2)
        error, rows = self._scaled(q)
        sizes = _column_norms(rows)
        gap = np.linalg.norm(error, axis=1)
        least, creeping = np.zeros(len(q), dtype=bool), np.zeros(len(q), dtype=int)
        for _ in range(_STEPS_OF_A_START):
            done = (gap <= _CLOSED * length) | least
            given_up = ~done & ((damping >= _STUCK) | (creeping >= _STEPS_PATIENCE))
            found.append(q[done])
            left.append(q[given_up])
            going = ~done & ~given_up
            q, error, rows, sizes = q[going], error[going], rows[going], sizes[going]
            gap, damping, creeping = gap[going], damping[going], creeping[going]
            if not len(q):
                break
            step = self._step(error, rows, sizes, damping * gap / farthest)
            trial = self.problem.tree.moved(q, step)
            trial_error, trial_rows = self._scaled(trial)
            trial_gap = np.linalg.norm(trial_error, axis=1)
            better = trial_gap < gap
            least = (gap <= tolerance) & better & (trial_gap >= (1.0 - _FALLING) * gap)
            falls = (trial_gap < (1.0 - creeps) * gap) | (gap <= tolerance)
            creeping = np.where(falls, 0, creeping + better)
            q = np.where(better[:, None], trial, q)
            error = np.where(better[:, None], trial_error, error)
            rows = np.where(better[:, None, None], trial_rows, rows)
            sizes = np.maximum(_FORGOTTEN * sizes, _column_norms(rows))
            gap = np.where(better, trial_gap, gap)
            damping = np.where(better, np.maximum(damping / 5.0, 1e-9), damping * 5.0)
        return Ends(self._polished(np.concatenate(found)), np.concatenate(left), q)

    def _polished(self, q: Array) -> Array:
        """Return closed rows after Newton's last steps, where these close them further.

        Beside a singularity poses that are closed to little are far from each other, though one.
        """
        for _ in range(_LAST_STEPS if len(q) else 0):
            error, rows = self._scaled(q)
            step = self._step(error, rows, _column_norms(rows), np.zeros(len(q)))
            trial = self.problem.tree.moved(q, step)
            better = np.linalg.norm(self._scaled(trial)[0], axis=1) < np.linalg.norm(error, axis=1)
            q = np.where(better[:, None], trial, q)
        return q

    def _scaled(self, q: Array) -> tuple[Array, Array]:
        """Return η in m and K* on the scaled columns."""
        partition = self.problem.partition
        residual, jacobian = self.problem.loops.evaluate(q)
        K_star = jacobian[:, :, partition.passive] * partition.column_scale[partition.passive]
        return residual * partition.row_scale, K_star * partition.row_scale[:, None]

    def _step(self, error: Array, rows: Array, sizes: Array, damping: Array) -> Array:
        """Return v (b, nv): −D⁻¹(JᵀJ + λ)⁻¹ Jᵀη on the passive columns, J = K D⁻¹, not too long.

        D are the sizes of K's columns (Marquardt's scaling), so that λ holds back no joint for
        moving the loops little: a platform's turn moves them by its own size only, however long
        its legs are. They shrink slowly on the way: a column that vanishes where the loops close
        would have its joint thrown about there.
        """
        partition = self.problem.partition
        sizes = np.maximum(sizes, _IDLE_COLUMN * sizes.max(axis=1, initial=0.0, keepdims=True))
        sizes = np.where(sizes > 0.0, sizes, 1.0)  # no passive joint moves the loops at all
        rows = rows / sizes[:, None, :]
        across = rows.transpose(0, 2, 1)
        square = across @ rows
        diagonal = np.einsum("bii->bi", square)
        diagonal += (damping + 1e-12)[:, None]
        step = -np.linalg.solve(square, across @ error[:, :, None])[:, :, 0] / sizes
        stride = np.linalg.norm(step / self.strides, axis=1)
        step /= np.maximum(stride, 1.0)[:, None]
        velocity = np.zeros((len(error), partition.column_scale.size))
        velocity[:, partition.passive] = step * partition.column_scale[partition.passive]
        return velocity


def _column_norms(rows: Array) -> Array:
    """Return the norms of the columns of each matrix, shape (b, m_p)."""
    return np.asarray(np.sqrt(np.einsum("bij,bij->bj", rows, rows)))


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
