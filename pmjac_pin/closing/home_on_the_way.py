"""The home pose followed from some dimensions to others, the motors at rest.

At once, an assembly from the home pose of other dimensions might end on another assembly mode: so
it is followed in twelve steps.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pmjac_pin.closing.closed import closed_point
from pmjac_pin.closing.damped_closure import assemble
from pmjac_pin.closing.parts import Parts
from pmjac_pin.closing.pose_assembly import motor_weights
from pmjac_pin.values.arrays import Array

_STEPS_HOME = 12  # on the way
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

    That is the last home pose on the way that is regular with the motors at rest; None where there
    is none.

    Parameters
    ----------
    first : HomePose or None
        At the beginning, None where it is open there; dimensions on the way need not close, either.
    at : callable
        Share of the way, less than 1 ↦ the parts there, not assembled.
    """
    here = first
    for share in np.arange(1, _STEPS_HOME) / _STEPS_HOME:
        found = home_pose(at(float(share)), None if here is None else here.q)
        first = first or found
        if first and found and not first.loses(found):
            here = found
    return None if here is None else here.q
