"""CourseWalker: from step to covered step along a path, until none is covered or it ends."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from pmjac_pin.closing.closed import is_invertible, is_singular
from pmjac_pin.closing.straight_path import LARGEST_STEP, SMALLEST_STEP, ends_path
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.motor_path import PathPiece
from pmjac_pin.studies.follow.step import CoveredStep
from pmjac_pin.studies.follow.stretch import PathPose
from pmjac_pin.values.arrays import Array

_LEAST_STRIDE = 1e-15  # of a parameter
Halt = Literal["end", "uncovered", "singular", "strayed"]


class CourseWalker:
    """Walks a course from a closed pose.

    Attributes
    ----------
    pose : PathPose
        Where it is.
    piece : PathPiece
    halt : {"end", "uncovered", "singular", "strayed"}
        Why it has stopped.
    """

    def __init__(self, course: Course, pose: PathPose) -> None:
        self.course, self.pose = course, pose
        self.number = course.path.number_at(pose.t)
        self.piece: PathPiece = course.path.pieces[self.number]
        self.halt: Halt = "end"

    def steps(self) -> Iterator[CoveredStep]:
        """Yield covered steps, each of which begins where the one before ends."""
        course, stride = self.course, self.piece.end - self.piece.start
        if is_singular(self.pose.point, course.problem.partition):
            self.halt = "singular"
            return
        while self.pose.t < course.path.end:
            if self.pose.t >= self.piece.end:
                self.number += 1
                self.piece = course.path.pieces[self.number]
                velocity = course.velocity(self.pose.point, self.piece, self.pose.t)
                self.pose = PathPose(self.pose.t, self.pose.point, velocity)
            step = self._covered(stride)
            if step is None:
                self.halt = "uncovered"
                return
            self.pose, stride = step.end, 2.0 * step.width
            if course.strayed(step.end.q, self.piece, step.end.t):
                self.halt = "strayed"
                return
            yield step
            partition = course.problem.partition
            if ends_path(step.start.point, step.end.point, partition):
                self.halt = "singular"
                return
        self.halt = "end"

    def _covered(self, stride: float) -> CoveredStep | None:
        """Return a step of this length or of one that is halved until it is covered."""
        course, piece, start = self.course, self.piece, self.pose
        while True:
            end = start.t + stride
            if end >= piece.end or piece.end - end < 1e-3 * stride:
                end = piece.end
            motion = course.motion_between(start.point, piece, start.t, end)
            size = course.size(motion)
            if size <= LARGEST_STEP and (step := self._tried(end, motion)) is not None:
                return step
            stride = 0.5 * (end - start.t)
            moved = max(size, course.size(start.velocity) * stride)
            if moved < SMALLEST_STEP or stride <= _LEAST_STRIDE * max(abs(start.t), abs(end)):
                return None

    def _tried(self, end: float, motion: Array) -> CoveredStep | None:
        course, piece, start = self.course, self.piece, self.pose
        problem = course.problem
        point = course.close(problem.integrate(start.q, motion), piece, end, motion)
        if point is None or not is_invertible(point, problem.partition):
            return None
        step = CoveredStep(
            course, piece, start, PathPose(end, point, course.velocity(point, piece, end))
        )
        aside = course.aside(piece, start.t, end)
        covered = course.mechanism.step_guard.covers(
            problem, start.point, point, *step.rates(), aside=aside
        )
        return step if covered else None
