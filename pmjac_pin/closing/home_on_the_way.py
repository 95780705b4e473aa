"""The home pose followed from some dimensions to others, the motors at rest.

At once, an assembly from the home pose of other dimensions might end on another assembly mode: so
it is followed in twelve steps, or in more where it goes far or bends. Where it goes hardly far, and
where Newton's first step says, one is enough. No machine is built on the way: joints, anchors and
rods move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pmjac_pin.closing.closed import closed_point
from pmjac_pin.closing.closure_problem import CLOSURE_TOLERANCE, ClosureProblem
from pmjac_pin.closing.damped_closure import assemble, motor_weights
from pmjac_pin.closing.parts import Parts
from pmjac_pin.kinematics.between_dimensions import BetweenDimensions, RowsOnTheWay
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.model.rows import Rows
from pmjac_pin.values.arrays import Array, norm

_TWO_ENDS = 2  # no stops between
_LONGEST, _SHORTEST = 1.0 / 12.0, 2.0**-12 / 12.0  # steps, as shares of the way
_FARTHEST = 0.3  # lengths or rad, of one step
_STRAIGHT = 0.25  # of a step: what it may differ by from Newton's
_NEAR, _NEARLY_STRAIGHT = 0.1, 0.1  # the same two, of the whole way in one step
_HARDLY = 1e-6  # lengths or rad: not looked at
_MOST_WAYS = 300  # after which steps are as long as they come
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

    @classmethod
    def at(cls, problem: ClosureProblem, q: Array) -> HomePose:
        """Return what there is to know of a closed pose."""
        factors = closed_point(problem, q).factors
        values = factors.singular_values
        smallest = values[: factors.rank].min(initial=np.inf)
        return cls(q, factors.rank, float(smallest) / (factors.size or 1.0))

    def loses(self, other: HomePose) -> bool:
        """Tell whether another pose is singular, or nearly, beside this one."""
        return other.rank < self.rank or other.smallest < _LEAST_SHARE * self.smallest


def home_pose(problem: ClosureProblem, start: Array) -> Array | None:
    """Return a closed pose near a start, the motors at rest; None where loops stay open."""
    found = assemble(problem, start, motor_weights(problem, 0.0), enough=CLOSURE_TOLERANCE)
    return None if found.gap > problem.tolerance else found.q


def followed(stops: Sequence[Parts], home_q: Array | None) -> Array | None:
    """Return where to assemble the home pose at the end of a way.

    That is the last home pose on the way that is regular with the motors at rest; None where there
    is none.

    Parameters
    ----------
    stops : sequence of Parts
        Not assembled; at equal shares of the way, the first and the last at its ends. Scales and
        tolerance are the end's all along.
    home_q : ndarray, shape (nq,), or None
        The home pose at the beginning, None where it is open there; dimensions on the way need not
        close, either.
    """
    end = stops[-1]
    between = BetweenDimensions([stop.kinematics for stop in stops], _rows(stops[0], end))

    def at(share: float) -> ClosureProblem:
        return replace(end.problem, loops=between.at(share))

    first = here = None if home_q is None else HomePose.at(at(0.0), home_q)
    if (
        first is not None
        and len(stops) == _TWO_ENDS
        and (q := _at_once(at(1.0), first)) is not None
    ):
        return q
    share = known = 0.0  # of the way; up to where `here` is known
    step, tries = _LONGEST, 0
    while share < 1.0:
        tries += 1
        ahead = share + step if share + step < 1.0 - 0.5 * _SHORTEST else 1.0
        problem = at(ahead)
        q = home_pose(problem, end.home_q if here is None else here.q)
        careful = known == share and step > _SHORTEST and tries < _MOST_WAYS
        before = here.q if careful and here is not None else None
        if q is not None and before is not None and not _is_next(problem, before, q):
            step *= 0.5
            continue
        found = None if q is None else HomePose.at(problem, q)
        first, share, step = first or found, ahead, min(2.0 * step, _LONGEST)
        if first and found and not first.loses(found):
            here, known = found, ahead
    return None if here is None else here.q


def _at_once(problem: ClosureProblem, first: HomePose) -> Array | None:
    """Return the home pose where one step certainly leads to it, regular as it was."""
    q = home_pose(problem, first.q)
    if q is None or not _is_next(problem, first.q, q, _NEAR, _NEARLY_STRAIGHT):
        return None
    return None if first.loses(HomePose.at(problem, q)) else q


def _is_next(
    problem: ClosureProblem,
    before: Array,
    q: Array,
    farthest: float = _FARTHEST,
    straight: float = _STRAIGHT,
) -> bool:
    """Tell whether a home pose is near the one before, and where Newton's first step leads.

    Where dimensions have changed by little that is so; a pose of another assembly mode is further
    away, or in another direction.
    """
    partition, point = problem.partition, closed_point(problem, before)
    expected = np.zeros(partition.column_scale.size)
    expected[partition.passive] = -point.factors.solve(point.residual)
    moved = problem.difference(before, q) / partition.column_scale
    size, missed = norm(moved), norm(moved - expected)
    return size <= farthest * partition.length and (
        missed <= straight * size or size <= _HARDLY * partition.length
    )


def part_of_the_way(
    begin: Mapping[str, float], end: Mapping[str, float], share: float
) -> dict[str, float]:
    """Return the parameters' values at a share of the way from some to others.

    Examples
    --------
    >>> part_of_the_way({"a": 1.0, "b": 2.0}, {"a": 3.0, "b": 2.0}, 0.25)
    {'a': 1.5, 'b': 2.0}
    """
    return {name: low + share * (end[name] - low) for name, low in begin.items()}


def _rows(beginning: Parts, end: Parts) -> RowsOnTheWay:
    loops = [loop for loop in end.spec.loops if not isinstance(loop, JointLoop)]

    def rows(share: float) -> list[tuple[Rows, ...]]:
        values = part_of_the_way(beginning.values, end.values, share)
        return [loop.rows(values) for loop in loops]

    return rows
