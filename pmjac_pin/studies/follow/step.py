"""CoveredStep: a covered part of a path, and the closed poses along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.closing.closed import is_singular
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ClosureError
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.stretch import PathPose, Stretch
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class CoveredStep(Stretch):
    """From one closed pose to another, with one closed pose in the tube between for each t."""

    @property
    def width(self) -> float:
        """How long it is."""
        return self.end.t - self.start.t

    def _between(self, t: float) -> PathPose:
        course, problem = self.course, self.course.problem
        way = problem.difference(self.start.q, self.end.q)
        motion = hermite((t - self.start.t) / self.width, way, *self.rates())
        point = course.close(problem.integrate(self.start.q, motion), self.piece, t, way)
        if point is None:
            message = f"no closed pose is found at t = {t!r}, in a step that is covered"
            raise ClosureError(message, residual_norm=np.inf, q=self.start.q)
        return PathPose(t, point, course.velocity(point, self.piece, t))

    def rates(self) -> tuple[Array, Array]:
        """Return how all joints leave and arrive, for s from 0 to 1."""
        return self.width * self.start.velocity, self.width * self.end.velocity


def beginning(course: Course, start: Configuration) -> PathPose:
    """Return where a course begins; its rates are NaN at a singular pose."""
    path = course.path
    point, velocity = course.pose_at(start.q), np.full(start.mechanism.nv, np.nan)
    if not is_singular(point, course.problem.partition):
        velocity = course.velocity(point, path.pieces[0], path.start)
    return PathPose(path.start, point, velocity)


def hermite(s: float, way: Array, leaving: Array, arriving: Array) -> Array:
    """Return the cubic x(s) from 0 to `way` with these rates at 0 and 1."""
    third = leaving + arriving - 2.0 * way
    return np.asarray(s * (leaving + s * (3.0 * way - 2.0 * leaving - arriving + s * third)))
