"""Stretch: a part of a path, a closed pose for each t; Passage: one by a branch point."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.motor_path import PathPiece
from pmjac_pin.studies.follow.step import PathPose
from pmjac_pin.values.arrays import Array


class Stretch(Protocol):
    """A part of a path."""

    @property
    def course(self) -> Course: ...  # noqa: D102
    @property
    def piece(self) -> PathPiece: ...  # noqa: D102
    @property
    def start(self) -> PathPose: ...  # noqa: D102
    @property
    def end(self) -> PathPose: ...  # noqa: D102

    def at(self, t: float) -> PathPose:
        """Return the pose at a parameter between."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Passage:
    """From a pose before a branch point to one beyond, along the tangent that goes on.

    Attributes
    ----------
    spot : PathPose
        The branch point, and dq/dt on the branch.
    """

    course: Course
    piece: PathPiece
    start: PathPose
    end: PathPose
    spot: PathPose
    _known: dict[float, PathPose] = field(default_factory=dict)

    def at(self, t: float) -> PathPose:
        """Return the pose at a parameter between: to first order where it is hardly apart."""
        if t <= self.start.t:
            return self.start
        if t >= self.end.t:
            return self.end
        if (known := self._known.get(t)) is None:
            known = self._known[t] = self._beside(t)
        return known

    def _beside(self, t: float) -> PathPose:
        course = self.course
        motion: Array = (t - self.spot.t) * self.spot.velocity
        point = course.close(course.problem.integrate(self.spot.q, motion), self.piece, t, motion)
        if point is None:
            return PathPose(t, self.spot.point, self.spot.velocity)
        return PathPose(t, point, self.spot.velocity)
