"""Where the tool loses a motion on a path: its smallest singular value, with a sign, passes zero.

J_eq on the judged rows, without dimension, is A = U diag(σ) Vᵀ; along a path u, v and ± σ of the
value that decides can be continued smoothly through σ = 0, where the sign changes, and its rate is
uᵀ A' v. A minimum at zero is a touch.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Literal, TypeAlias

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, ForbiddenRatesError, NoJacobianError, NoToolError
from pmjac_pin.kinematics.slopes import Slopes
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.crossings import IntervalEnds, located
from pmjac_pin.studies.follow.event import Event
from pmjac_pin.studies.follow.stretch import PathPose, Stretch
from pmjac_pin.values.arrays import Array

_SIGN_TOLD = 0.5  # of u and of v at both ends: a sign is told
_LOSS_HALVINGS = 14
_LOST = 1e-9  # of the tool's size: at a touch
_AT_AN_END = 1e-12  # where a step ends: no sign is told there
_FROM_AN_END = 1e-6  # of a step: from such an end, where it is
_SMOOTH = 1e-9  # of a rate
_OUT_OF_REACH = 2.0  # times what the matrix changes by


#: A pose of a path ↦ a matrix, how it changes along the path, and what its values compare with.
WatchedMatrix: TypeAlias = Callable[[PathPose], tuple[Array, Array, float]]
Lost = Literal["loss", "gain"]
_LOST_WORDS: dict[Lost, str] = {
    "loss": "the tool loses a motion",
    "gain": "the motors lose the tool, as passive joints come free",
}


@dataclass(frozen=True, slots=True, eq=False)
class _Value:
    """The singular value that decides, its vectors, its rate, and how fast it could be at most."""

    sigma: float
    rate: float
    fastest: float
    left: Array
    right: Array

    def sign_of(self, other: _Value) -> float:
        """Return the sign of another, and 0 where it is not told."""
        left, right = float(self.left @ other.left), float(self.right @ other.right)
        return float(np.sign(left * right)) if min(abs(left), abs(right)) >= _SIGN_TOLD else 0.0


class SingularValueSigns:
    """A matrix along a course, of which one singular value decides."""

    def __init__(self, course: Course, watched: WatchedMatrix, number: int, what: Lost) -> None:
        self._course, self._watched, self._number, self._what = course, watched, number, what
        self._values: dict[float, _Value] = {}
        self._end: tuple[PathPose, _Value] | None = None

    def events(self, stretch: Stretch) -> Iterator[Event]:
        """Yield what the tool loses on a part of a path."""
        a, b = stretch.start.t, stretch.end.t
        self._values.clear()
        if self._end is not None and _goes_on(self._end[0], stretch.start):
            self._values[a] = self._end[1]
        self._end = stretch.end, self._value(stretch, b)
        aside = _FROM_AN_END * (b - a)
        for t in (a, b):
            if self._value(stretch, t).sigma <= _AT_AN_END:
                yield self._event(stretch, t, "is zero")
                a, b = (a + aside, b) if t == a else (a, b - aside)
        yield from self._between(stretch, a, b, _LOSS_HALVINGS)

    def _between(self, stretch: Stretch, a: float, b: float, halvings: int) -> Iterator[Event]:
        first, last = self._value(stretch, a), self._value(stretch, b)
        if first.sigma + last.sigma > _OUT_OF_REACH * max(first.fastest, last.fastest) * (b - a):
            return
        sign = first.sign_of(last)
        middle = 0.5 * (a + b)
        if sign:
            ends = IntervalEnds(first.sigma, first.rate, sign * last.sigma, sign * last.rate, b - a)
            if not ends.may_pass(0.0):
                return
            if sign < 0.0:
                t = located(lambda t: self._signed(stretch, first, t), a, b)
                yield self._event(stretch, t, "changes its sign")
                return
            if ends.leaving < 0.0 < ends.arriving:
                t = located(lambda t: self._signed_rate(stretch, first, t), a, b)
                if self._value(stretch, t).sigma <= _LOST:
                    yield self._event(stretch, t, "touches zero")
                return
        elif not halvings:
            return
        if halvings:
            yield from self._between(stretch, a, middle, halvings - 1)
            yield from self._between(stretch, middle, b, halvings - 1)

    def _signed(self, stretch: Stretch, reference: _Value, t: float) -> float:
        here = self._value(stretch, t)
        return (reference.sign_of(here) or 1.0) * here.sigma

    def _signed_rate(self, stretch: Stretch, reference: _Value, t: float) -> float:
        here = self._value(stretch, t)
        return (reference.sign_of(here) or 1.0) * here.rate

    def _value(self, stretch: Stretch, t: float) -> _Value:
        if (known := self._values.get(t)) is None:
            known = self._values[t] = self._found(stretch.at(t))
        return known

    def _found(self, pose: PathPose) -> _Value:
        A, slope, size = self._watched(pose)
        left, values, right = np.linalg.svd(A)
        u, v = left[:, self._number], right[self._number]
        rate = float(u @ slope @ v)
        fastest = float(np.linalg.norm(slope)) / size
        return _Value(float(values[self._number]) / size, rate / size, fastest, u, v)

    def _event(self, stretch: Stretch, t: float, how: str) -> Event:
        configuration = self._course.configuration(stretch.at(t).q)
        what = f"{_LOST_WORDS[self._what]}: the smallest singular value {how}"
        return Event(self._what, t, configuration, what)


def _goes_on(end: PathPose, start: PathPose) -> bool:
    """Tell whether a part begins as the one before ends: at its pose, and without a kink."""
    same = end.point is start.point
    return same and np.allclose(end.velocity, start.velocity, rtol=_SMOOTH, atol=_SMOOTH)


def _has_jacobian(start: Configuration) -> bool:
    """Tell whether motors alone decide what the tool does."""
    try:
        start.jacobian()
    except ForbiddenRatesError:
        return True
    except (NoJacobianError, NoToolError):
        return False
    return True


def what_is_lost(course: Course, start: Configuration) -> SingularValueSigns | None:
    """Return what to watch: J_eq, or K* where the machine is driven by its tool.

    None where motors do not decide alone what the tool does, or nothing is passive.
    """
    partition = course.shown.problem.partition
    if course.shown.slopes is None:
        return None
    if course.by_tool:
        rank = partition.passive_rank
        watched = partial(_loops_matrix, course.shown)
        return SingularValueSigns(course, watched, rank - 1, "gain") if rank else None
    freedoms = min(len(partition.tool_rows.names), course.columns.size)
    if not 0 < course.whole.partition.tool_rank <= freedoms or not _has_jacobian(start):
        return None
    watched = partial(_tool_matrix, course)
    return SingularValueSigns(course, watched, course.whole.partition.tool_rank - 1, "loss")


def _slopes_along(mechanism: Mechanism, q: Array, motion: Array) -> Slopes:
    """Return how Jacobians change along a motion (nv,), by a program where one is recorded."""
    by = mechanism.recorded.slopes() or mechanism.slopes
    if by is None:
        raise ArgumentError(f"{mechanism.name} has a joint that is not in the table of joints")
    return by.at(q, motion[:, None])


def _loops_matrix(mechanism: Mechanism, pose: PathPose) -> tuple[Array, Array, float]:
    """Return K* of a machine, without dimension, how it changes, and the size of [K K*]."""
    partition, q = mechanism.problem.partition, pose.q[: mechanism.nq]
    slopes = _slopes_along(mechanism, q, pose.velocity[: mechanism.nv])
    scaled = partition.scaled(mechanism.kinematics.snapshot(q).constraint_jacobian)
    changed = partition.scaled(slopes.constraint[0])
    passive = partition.passive
    return scaled[:, passive], changed[:, passive], partition.size_of(scaled)


def _tool_matrix(course: Course, pose: PathPose) -> tuple[Array, Array, float]:
    """Return J_eq on the judged rows, scaled, how it changes, and the tool's size."""
    mechanism, partition = course.mechanism, course.problem.partition
    rows = list(partition.tool_rows.linear + partition.tool_rows.angular)
    snapshot = mechanism.kinematics.snapshot(pose.q)
    slopes = _slopes_along(mechanism, pose.q, pose.velocity)
    tool = partition.scaled_tool(snapshot.judged_jacobian(partition.tool_rows))[rows]
    change = partition.scaled_tool(slopes.tool(partition.tool_rows.axes)[0])[rows]
    loops = partition.loop_rates(snapshot.constraint_jacobian)
    scaled, passive = loops.scaled, loops.passive
    motions = np.zeros((tool.shape[1], partition.actuated.size))
    motions[partition.actuated] = np.eye(partition.actuated.size)
    rank = partition.passive_rank
    motions[partition.passive] = -passive.solve(scaled[:, partition.actuated], rank)
    opened = partition.scaled(slopes.constraint[0]) @ motions
    bent = -passive.solve(opened, rank)
    A = tool @ motions
    return A, change @ motions + tool[:, partition.passive] @ bent, float(np.linalg.norm(tool))
