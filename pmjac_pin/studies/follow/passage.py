"""Passage: a part of a path that leads by a branch point."""

from __future__ import annotations

from dataclasses import dataclass

from pmjac_pin.studies.follow.stretch import PathPose, Stretch
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class Passage(Stretch):
    """From a pose before a branch point to one beyond, along the tangent that goes on.

    Attributes
    ----------
    spot : PathPose
        The branch point, and dq/dt on the branch.
    """

    spot: PathPose

    def _between(self, t: float) -> PathPose:
        """Return the pose there: to first order where it is hardly apart from the branch point."""
        course = self.course
        motion: Array = (t - self.spot.t) * self.spot.velocity
        point = course.close(course.problem.integrate(self.spot.q, motion), self.piece, t, motion)
        if point is None:
            return PathPose(t, self.spot.point, self.spot.velocity)
        return PathPose(t, point, self.spot.velocity)
