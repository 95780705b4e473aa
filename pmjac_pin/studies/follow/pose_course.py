"""Courses of whole poses: the machine driven by its tool, which turns by three hinges in turn.

Their angles are numbers along the path, for which polynomials stand as for any function. What of a
pose the machine cannot do, or what follows from the rest, has to fit: that is looked at.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.given_path import path_of
from pmjac_pin.studies.follow.pose_path import PosePath
from pmjac_pin.studies.follow.tool_course import begun
from pmjac_pin.studies.reach.driven import Driven, driven_along
from pmjac_pin.studies.reach.goal import ToolGoal, gaps_of, is_met, tool_at
from pmjac_pin.studies.reach.targets import read_goals
from pmjac_pin.studies.reach.task import Task
from pmjac_pin.values.arrays import Array

_SAMPLES = 64  # between kinks: where orientations are looked at, at first
_DOUBLED = 8  # times: twice as many, until angles go on from one to the next
_GOES_ON = 1.0  # rad between two samples


@dataclass(frozen=True, slots=True, eq=False)
class PoseTargets:
    """The poses of a path as targets of a machine.

    Attributes
    ----------
    mechanism : Mechanism
    path : PosePath
    task : Task
        Which rows count.
    tool : str or three str, optional
    """

    mechanism: Mechanism
    path: PosePath
    task: Task
    tool: Any

    def goals(self, t: float) -> tuple[ToolGoal, ...]:
        """Return the target at a parameter."""
        found = read_goals(self.mechanism, self.path.at(t), self.tool, self.task)
        return tuple(goal for goal in found if isinstance(goal, ToolGoal))

    def check_met(self, t: float, q: Array) -> None:
        """Raise ArgumentError where the tool cannot be where the path wants it."""
        if not is_met(self.goals(t), self.mechanism, q):
            miss = gaps_of(self.goals(t), self.mechanism, q).miss
            off = f"{miss.linear:.3g} m and {miss.angular:.3g} rad off"
            raise ArgumentError(
                f"{self.mechanism.name}: at t = {t:.6g} the tool is {off} the path in what it "
                "cannot do, or what follows from the rest: name the rows that count by a Task"
            )


def pose_course(targets: PoseTargets, start: Configuration) -> tuple[Course, Configuration]:
    """Return the course of a tool along poses, and the driven machine's where it begins.

    Raises
    ------
    ArgumentError
        No rows of the task tell the machine's pose, or no hinges turn the tool so; a first pose
        that the tool cannot have.
    ClosureError
        It is not reached on a straight way of the tool from `start`.
    """
    mechanism, task = targets.mechanism, targets.task
    if task.turning == "pointing":
        message = "where an axis points leaves the turn about it open, and is no path"
        raise ArgumentError(f"{mechanism.name}: {message}: give whole orientations")
    times = targets.path.times
    places = np.concatenate(
        [np.linspace(a, b, _SAMPLES, endpoint=False) for a, b in pairwise(times)] + [times[-1:]]
    )
    driven = _driven_along_path(targets, places, start)
    numbers = _ContinuousNumbers(targets, driven, start, places)
    path = path_of(numbers, times, numbers.names, np.asarray)
    begin = begun(driven, path.pieces[0].values(path.start), start)
    targets.check_met(path.start, begin.q[: mechanism.nq])
    return Course.beginning_at(begin, path, mechanism), begin


def _driven_along_path(targets: PoseTargets, places: Array, start: Configuration) -> Driven:
    mechanism, first = targets.mechanism, targets.goals(float(places[0]))
    own = first[0].tool
    turned = [tool_at(mechanism, own, q)[1].rotation for q in (mechanism.home.q, start.q)]
    turned += [targets.path.at(float(t)).rotation for t in places]
    driven = driven_along(mechanism, first, np.array(turned))
    if driven is None:
        told = f"{targets.task} does not tell where the machine is"
        raise ArgumentError(f"{mechanism.name}: {told}: name rows that do by a Task")
    return driven


class _ContinuousNumbers:
    """Motor values of the driven machine along a path, angles without jumps by full turns."""

    def __init__(
        self, targets: PoseTargets, driven: Driven, start: Configuration, places: Array
    ) -> None:
        self._targets, self._driven_along_path, self._start = targets, driven, start
        partition = driven.mechanism.problem.partition
        self.names = partition.actuated_names
        self._wraps = driven.mechanism.coordinates.wraps[partition.actuated]
        self._places, self._known = self._unwrapped(places)

    def __call__(self, t: float) -> Array:
        """Return them at a parameter."""
        values, turn = self._at(t), 2.0 * np.pi
        near = np.array([np.interp(t, self._places, column) for column in self._known.T])
        rounds = np.where(self._wraps, np.round((near - values) / turn), 0.0)
        return np.asarray(values + turn * rounds)

    def _at(self, t: float) -> Array:
        return self._driven_along_path.values(self._targets.goals(t), self._start)

    def _unwrapped(self, places: Array) -> tuple[Array, Array]:
        """Return places so near to each other that angles go on between them, and the numbers."""
        for _ in range(_DOUBLED):
            known = np.array([self._at(t) for t in places.tolist()])
            known[:, self._wraps] = np.unwrap(known[:, self._wraps], axis=0)
            steps = np.abs(np.diff(known[:, self._wraps], axis=0))
            if float(steps.max(initial=0.0)) < _GOES_ON:
                return places, known
            between = 0.5 * (places[:-1] + places[1:])
            places = np.sort(np.concatenate([places, between]))
        raise ArgumentError("the path's orientations turn too fast to be told from jumps")
