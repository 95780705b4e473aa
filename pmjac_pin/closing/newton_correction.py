"""Newton's correction onto the closed poses: of the passive joints, the motors at rest."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pmjac_pin.closing.closed import Closed, closed_point, passive_motion
from pmjac_pin.closing.closure_problem import ROUNDING, ClosureProblem
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.lapack import least_squares, solved

LARGEST_CORRECTION = 0.25  # the first one, as a share of the predicted motion
SLOWEST_CONTRACTION = 0.25  # of one correction by the next
WALKING = 1e-13  # gap on the way, in lengths: beside a fold, more would hide how near that is
MOST_CORRECTIONS = 50  # at a fold, polishing halves the error each time


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
