"""Search: closed poses from many random starts, and how much of the start space is settled.

Damped Newton (Levenberg–Marquardt) runs from all starts of a batch at once. The share p of the
start space that leads to poses not seen yet is bounded with a confidence 1 − δ: had n starts in
a row, drawn after the last new pose, met none, then (1 − p)ⁿ ≥ δ, hence p ≤ −ln δ / n. The k-th
such question gets δₖ = 6δ/(πk)², so that all of them together err with probability δ at most.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pmjac_pin.closing.held_motors import ROUNDED_SHARE
from pmjac_pin.closing.levenberg_marquardt import (
    Descended,
    Patience,
    damped_step,
    descend,
    norms,
    points_at,
)
from pmjac_pin.studies.modes.passive_joints import PassiveJoints
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.found_once import found_once

if TYPE_CHECKING:
    from pmjac_pin.studies.modes.descents_in_lanes import DescentsInLanes

_STEPS_OF_A_START = 60  # of one start
_CLOSED = 1e-9  # of the characteristic length: two steps of Newton's do the rest
_FALLING = 1e-8  # of itself: a gap within the tolerance that falls less is the least there is
_STUCK = 1e8  # damping at which a start is given up
_CREEPING = 1e-4  # of itself: an open gap that falls less in each of so many steps stays open
_STEPS_PATIENCE = 3
_STILL_OPEN = 1e-7  # of itself: an open gap that falls less stays open, however patient one is
_AS_PROMISED = 0.25  # of the fall to first order
_ONE_STEP = Patience(steps=1, enough=0.0)
_LAST_STEPS = Patience(steps=2, enough=0.0)


class Ends(NamedTuple):
    """Where starts lead to, rows of q.

    `closed` where the loops are, `open` where they were given up at gaps `open_by` that hardly
    fall, m; `spent` where the steps were used up.
    """

    closed: Array
    open: Array
    open_by: Array
    spent: Array


@dataclass(frozen=True, eq=False)
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
        return self._ends(np.concatenate([ends.spent, self._falling(ends)]), _STILL_OPEN)

    def nearly(self, ends: Ends) -> Array:
        """Return the open rows at which the gap is as small as rounded numbers leave it."""
        return np.asarray(ends.open[ends.open_by <= ROUNDED_SHARE * self.problem.length])

    def _descended(self, q: Array, patience: Patience) -> Descended:
        in_lanes = self._in_lanes
        if in_lanes is None:
            return descend(self._joints, q, patience)
        return in_lanes.descend(q, patience)

    @found_once
    def _joints(self) -> PassiveJoints:
        return PassiveJoints(self.problem, self.strides)

    @found_once
    def _in_lanes(self) -> DescentsInLanes | None:
        """By the kernel, None where there is none, or no programs."""
        from pmjac_pin.studies.modes.descents_in_lanes import (  # noqa: PLC0415
            DescentsInLanes,
            descent_kernel,
        )
        from pmjac_pin.studies.modes.recorded_descent import recorded_descent  # noqa: PLC0415

        if (library := descent_kernel()) is None:
            return None
        programs = recorded_descent(self.problem, self.strides)
        if programs is None:
            return None
        return DescentsInLanes(library, programs, self._joints.stride)

    def _falling(self, ends: Ends) -> Array:
        """Return the open rows whose gap falls along an undamped step, as its first order says."""
        falls = ends.open_by - self._descended(ends.open, _ONE_STEP).gap
        some = falls > _STILL_OPEN * ends.open_by
        q, gap, fall = ends.open[some], ends.open_by[some], falls[some]
        if not len(q):
            return q
        points = points_at(self._joints, q)
        step = damped_step(self._joints, points, np.zeros(len(q)))
        ahead = norms(points.error + np.einsum("bij,bj->bi", points.rows, step))
        return np.asarray(q[fall > _AS_PROMISED * (gap - ahead)])

    def _ends(self, starts: Array, creeps: float) -> Ends:
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
        ends = self._descended(starts, patience)
        left = ~ends.closed & ~ends.spent
        closed = self._polished(ends.q[ends.closed])
        return Ends(closed, ends.q[left], ends.gap[left], ends.q[ends.spent])

    def _polished(self, q: Array) -> Array:
        """Return closed rows after Newton's last steps, where these close them further.

        Beside a singularity poses that are closed to little are far from each other, though one.
        """
        return self._descended(q, _LAST_STEPS).q


class FewClosures(ManyClosures):
    """The same over few poses, by NumPy: they do not pay for recording."""

    def _descended(self, q: Array, patience: Patience) -> Descended:
        return descend(self._joints, q, patience)


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
