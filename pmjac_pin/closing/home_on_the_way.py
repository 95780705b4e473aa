"""The home pose followed from some dimensions to others, the motors at rest.

At once, an assembly from the home pose of other dimensions might end on another assembly mode. So a
stretch of the way is taken at once only where Newton's corrections at its end contract from the
first on; other stretches are halved.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pmjac_pin.closing.closed import closed_point
from pmjac_pin.closing.closure import LARGEST_STEP, SLOWEST_CONTRACTION
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.damped_closure import assemble
from pmjac_pin.closing.parts import Parts
from pmjac_pin.closing.pose_assembly import motor_weights
from pmjac_pin.values.arrays import Array, norm

_SHORTEST = 1.0 / 16.0  # of the way: so short a stretch is taken wherever its end can be closed
_LEAST_SHARE = 0.4  # of σ_min at first: below, the motors move on the way


class HomePose(NamedTuple):
    """A closed pose with the motors where home has them.

    Attributes
    ----------
    q : ndarray, shape (nq,)
    rank : int
        Of K*.
    smallest : float
        Its smallest singular value that is not zero, beside the size of [K K*].
    """

    q: Array
    rank: int
    smallest: float

    def loses(self, other: HomePose) -> bool:
        """Tell whether another pose is singular, or nearly, beside this one."""
        return other.rank < self.rank or other.smallest < _LEAST_SHARE * self.smallest


def home_pose(parts: Parts, start: Array | None = None) -> HomePose | None:
    """Return the closed pose near home's values or near a start, None where loops stay open."""
    problem = parts.problem
    q = parts.home_q if start is None else start
    found = assemble(problem, q, motor_weights(problem, 0.0))
    if found.gap > problem.tolerance:
        return None
    factors = closed_point(problem, found.q).factors
    smallest = factors.singular_values[: factors.rank].min(initial=np.inf) / (factors.size or 1.0)
    return HomePose(found.q, factors.rank, float(smallest))


def followed(first: HomePose | None, at: Callable[[float], Parts]) -> Array | None:
    """Return where to assemble the home pose at the end of a way.

    That is the home pose there, or the last on the way while it is regular with the motors at rest;
    None where there is none.

    Parameters
    ----------
    first : HomePose or None
        At the beginning, None where it is open there; dimensions on the way need not close, either.
    at : callable
        Share of the way ↦ the parts there, not assembled.
    """
    begin = 0.0
    while first is None and begin + _SHORTEST < 1.0:
        begin += _SHORTEST
        first = home_pose(at(begin))
    if first is None:
        return None
    here, waiting = first, [(begin, 1.0)]
    while waiting:
        begin, end = waiting.pop()
        short = end - begin <= _SHORTEST
        parts = at(end)
        near = _is_near(parts.problem, here.q) or (short and end < 1.0)
        found = home_pose(parts, here.q) if near else None
        if found is not None and not first.loses(found):
            here = found
        elif not short:
            middle = 0.5 * (begin + end)
            waiting += [(middle, end), (begin, middle)]
    return here.q


def _is_near(problem: ClosureProblem, q: Array) -> bool:
    """Tell whether a closed pose is near enough for Newton's corrections to contract at once."""
    partition = problem.partition
    here = closed_point(problem, q)
    correction = -here.factors.solve(here.residual)
    size = norm(correction)
    if not size <= LARGEST_STEP * partition.length:
        return False
    step = np.zeros(partition.column_scale.size)
    step[partition.passive] = partition.column_scale[partition.passive] * correction
    ahead = problem.integrate(q, step)
    error = problem.evaluate(ahead)[0] * partition.row_scale
    left = norm(here.factors.solve(error))
    return left <= SLOWEST_CONTRACTION * size or left <= problem.tolerance
