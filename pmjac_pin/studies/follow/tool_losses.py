"""Where the tool loses a motion on a path: its smallest singular value, with a sign, passes zero.

J_eq on the judged rows, without dimension, is A = U diag(σ) Vᵀ; along a path u, v and ± σ of the
value that decides can be continued smoothly through σ = 0, where the sign changes, and its rate is
uᵀ A' v. A minimum at zero is a touch.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ForbiddenRatesError, NoJacobianError, NoToolError
from pmjac_pin.kinematics.slopes import SlopesAlongMotions
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.crossings import IntervalEnds, located
from pmjac_pin.studies.follow.event import Event
from pmjac_pin.studies.follow.passage import Stretch
from pmjac_pin.studies.follow.step import PathPose
from pmjac_pin.values.arrays import Array

_SIGN_TOLD = 0.5  # of u and of v at both ends: a sign is told
_LOSS_HALVINGS = 14
_LOST = 1e-9  # of the tool's size


@dataclass(frozen=True, slots=True, eq=False)
class _Value:
    """The singular value that decides, its vectors, and its rate."""

    sigma: float
    rate: float
    left: Array
    right: Array

    def sign_of(self, other: _Value) -> float:
        """Return the sign of another, and 0 where it is not told."""
        left, right = float(self.left @ other.left), float(self.right @ other.right)
        return float(np.sign(left * right)) if min(abs(left), abs(right)) >= _SIGN_TOLD else 0.0


class ToolLosses:
    """The tool's motion along a course."""

    def __init__(self, course: Course, slopes: SlopesAlongMotions) -> None:
        self._course, self._slopes = course, slopes
        self._values: dict[float, _Value] = {}
        rows = course.whole.partition.tool_rows
        self._rows = list(rows.linear + rows.angular)
        self._number = course.whole.partition.tool_rank - 1

    @classmethod
    def of(cls, course: Course, start: Configuration) -> ToolLosses | None:
        """Return those of a course; None where motors do not decide alone what the tool does."""
        partition, slopes = course.whole.partition, course.mechanism._slopes
        freedoms = min(len(partition.tool_rows.names), course.columns.size)
        if slopes is None or not 0 < partition.tool_rank <= freedoms or not _has_jacobian(start):
            return None
        return cls(course, slopes)

    def events(self, stretch: Stretch) -> Iterator[Event]:
        """Yield what the tool loses on a part of a path."""
        self._values.clear()
        yield from self._between(stretch, stretch.start.t, stretch.end.t, _LOSS_HALVINGS)

    def _between(self, stretch: Stretch, a: float, b: float, halvings: int) -> Iterator[Event]:
        first, last = self._value(stretch, a), self._value(stretch, b)
        sign = first.sign_of(last)
        middle = 0.5 * (a + b)
        if sign:
            ends = IntervalEnds(first.sigma, first.rate, sign * last.sigma, sign * last.rate, b - a)
            if not ends.may_pass(0.0):
                return
            if sign < 0.0 or min(first.sigma, last.sigma) <= _LOST:
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
        A, slope, size = self._matrix(pose)
        left, values, right = np.linalg.svd(A)
        u, v = left[:, self._number], right[self._number]
        rate = float(u @ slope @ v)
        return _Value(float(values[self._number]) / size, rate / size, u, v)

    def _matrix(self, pose: PathPose) -> tuple[Array, Array, float]:
        """Return J_eq on the judged rows, scaled, how it changes, and the tool's size."""
        mechanism, partition = self._course.mechanism, self._course.problem.partition
        snapshot = mechanism.kinematics.snapshot(pose.q)
        slopes = self._slopes.at(pose.q, pose.velocity[:, None])
        tool = partition.scaled_tool(snapshot.judged_jacobian(partition.tool_rows))[self._rows]
        change = partition.scaled_tool(slopes.tool(partition.tool_rows.axes)[0])[self._rows]
        scaled, _, passive = partition.loop_rates(snapshot.constraint_jacobian)
        motions = np.zeros((tool.shape[1], partition.actuated.size))
        motions[partition.actuated] = np.eye(partition.actuated.size)
        rank = partition.passive_rank
        motions[partition.passive] = -passive.solve(scaled[:, partition.actuated], rank)
        opened = partition.scaled(slopes.constraint[0]) @ motions
        bent = -passive.solve(opened, rank)
        A = tool @ motions
        return A, change @ motions + tool[:, partition.passive] @ bent, float(np.linalg.norm(tool))

    def _event(self, stretch: Stretch, t: float, how: str) -> Event:
        configuration = self._course.configuration(stretch.at(t).q)
        what = f"the tool loses a motion: its smallest singular value {how}"
        return Event("loss", t, configuration, what)


def _has_jacobian(start: Configuration) -> bool:
    """Tell whether motors alone decide what the tool does."""
    try:
        start.jacobian()
    except ForbiddenRatesError:
        return True
    except (NoJacobianError, NoToolError):
        return False
    return True
