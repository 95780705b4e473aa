"""Where a home pose does not assemble: whether its loops close from elsewhere, all or alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.closure_problem import ClosureProblem
from pmjac_pin.damped_closure import Assembled, assemble
from pmjac_pin.parts import Parts

Array = NDArray[np.float64]

_STARTS = 20
_SPREAD = 0.5  # rad, or share of the characteristic length


def starts(parts: Parts, best: Array | None) -> list[Array]:
    """Return the given pose, the best that was found from it, and seeded random ones around it.

    Parameters
    ----------
    parts : Parts
        With the file's home pose.
    best : ndarray, shape (nq,), or None
    """
    rng, problem = np.random.default_rng(0), parts.problem
    given = parts.home_q
    spread = _SPREAD * problem.partition.length * problem.partition.column_scale
    known = [given] if best is None else [given, best]
    steps = rng.normal(size=(_STARTS, spread.size)) * spread
    below, above = parts.coordinates.room(given)
    inside = np.clip(steps, np.minimum(-below, 0.0), np.maximum(above, 0.0))
    return known + [problem.integrate(given, step) for step in inside]


def nearest_closed(parts: Parts, tried: Sequence[Array]) -> Array | None:
    """Return the first closed pose found from these starts, all joints free within their limits."""
    for start in tried:
        found = _assembled(parts, parts.problem, start)
        if found.gap <= parts.problem.tolerance:
            return found.q
    return None


def gap_alone(parts: Parts, rows: slice, tried: Sequence[Array]) -> float:
    """Return the smallest gap, m, that one loop reaches from these starts, the others left open."""
    problem, least = parts.problem, np.inf

    def evaluate(q: Array) -> tuple[Array, Array]:
        residual, jacobian = problem.evaluate(q)
        return residual[rows], jacobian[rows]

    partition = replace(problem.partition, row_scale=problem.partition.row_scale[rows])
    alone = replace(problem, evaluate=evaluate, partition=partition)
    for start in tried:
        least = min(least, _assembled(parts, alone, start).gap)
        if least <= problem.tolerance:
            break
    return float(least)


def _assembled(parts: Parts, problem: ClosureProblem, start: Array) -> Assembled:
    return assemble(problem, start, np.ones(parts.model.nv), room=parts.coordinates.room)
