"""Where joints leave their limits on a path, and where they come back."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.crossings import IntervalEnds, Watched, slack_crossings, zero_beside
from pmjac_pin.studies.follow.event import Event
from pmjac_pin.studies.follow.stretch import Stretch
from pmjac_pin.values.arrays import Array

_WITHIN = 1e-9  # m or rad: rounding on the way to a limit is no violation


class JointLimits:
    """The limits of all joints along a course.

    Joints of one degree of freedom and one entry in q have limits, full turns and all.
    """

    def __init__(self, course: Course) -> None:
        self._course, coordinates = course, course.shown.coordinates
        columns = course.shown.problem.partition.columns
        self._names = {column: name for name, column in columns.items()}
        sides = [
            (k, side, limit)
            for limits, side in ((coordinates.lower, -1.0), (coordinates.upper, 1.0))
            for k, limit in enumerate(limits.tolist())
            if np.isfinite(limit)
        ]
        self._columns = np.array([k for k, _, _ in sides], dtype=np.intp)
        self._sides = np.array([side for _, side, _ in sides])
        self._limits = np.array([limit for _, _, limit in sides])

    def events(self, stretch: Stretch) -> Iterator[Event]:
        """Yield what happens on a part of a path."""
        if not self._columns.size:
            return
        ends = [self._beyond(stretch, t) for t in (stretch.start.t, stretch.end.t)]
        (first, leaving), (last, arriving) = ends
        for k in range(self._columns.size):
            a, b, c, d = (float(x[k]) for x in (first, leaving, last, arriving))
            if IntervalEnds(a, b, c, d, stretch.end.t - stretch.start.t).may_pass(_WITHIN):
                watched = self._one(stretch, k)
                within = stretch.start.t, stretch.end.t
                for t in slack_crossings(watched, *within, _WITHIN):
                    at = zero_beside(watched, t, *within)
                    yield self._event(stretch, k, at, watched(t)[1] > 0.0)

    def _words(self, k: int) -> str:
        column = int(self._columns[k])
        unit = "rad" if self._course.shown.coordinates.rotational[column] else "m"
        side = "upper" if self._sides[k] > 0.0 else "lower"
        limit = f"{side} limit {float(self._limits[k]):.9g} {unit}"
        return f"{self._names[column]!r} passes its {limit}"

    def _beyond(self, stretch: Stretch, t: float) -> tuple[Array, Array]:
        pose, coordinates = stretch.at(t), self._course.shown.coordinates
        values = coordinates.values_of(pose.q, self._columns)
        rates = self._sides * pose.velocity[self._columns]
        return self._sides * (values - self._limits), rates

    def _one(self, stretch: Stretch, k: int) -> Watched:
        def watched(t: float) -> tuple[float, float]:
            values, rates = self._beyond(stretch, t)
            return float(values[k]), float(rates[k])

        return watched

    def _event(self, stretch: Stretch, k: int, t: float, leaves: bool) -> Event:
        column = int(self._columns[k])
        motor = column in self._course.shown.problem.partition.actuated
        return Event(
            "motor limit" if motor else "passive limit",
            t,
            self._course.configuration(stretch.at(t).q),
            f"{self._words(k)}, " + ("outwards" if leaves else "back within it"),
            self._names[column],
            leaves=leaves,
        )
