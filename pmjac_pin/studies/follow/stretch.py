"""Stretch: a part of a path, a closed pose for each t."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

from pmjac_pin.closing.closed import Closed
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.motor_path import PathPiece
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class PathPose:
    """A closed pose at t, and dq/dt (nv,) there."""

    t: float
    point: Closed
    velocity: Array

    @property
    def q(self) -> Array:
        """Pinocchio's configuration vector."""
        return self.point.q


@dataclass(frozen=True, slots=True, eq=False)
class Stretch(ABC):
    """A part of one piece of a path."""

    course: Course
    piece: PathPiece
    start: PathPose
    end: PathPose
    _known: dict[float, PathPose] = field(init=False, default_factory=dict)

    def at(self, t: float) -> PathPose:
        """Return the pose at a parameter: that of the nearer end where it is not between."""
        if t <= self.start.t:
            return self.start
        if t >= self.end.t:
            return self.end
        if (known := self._known.get(t)) is None:
            known = self._known[t] = self._between(t)
        return known

    @abstractmethod
    def _between(self, t: float) -> PathPose:
        """Return the pose at a parameter between the ends."""
