"""Course: the loops of a mechanism, driven along a path of its motors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pmjac_pin.closing.closed import Closed, closed_point, path_velocity
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.newton_correction import corrected
from pmjac_pin.closing.over_actuation import Lead, lead
from pmjac_pin.configuration import Configuration
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.follow.motor_path import MotorPath, PathPiece
from pmjac_pin.values.arrays import Array, Index

_LED_TO = 1e-9  # m or rad: what led motors may be off by


@dataclass(frozen=True, eq=False)
class Course:
    """What a path is followed with.

    Attributes
    ----------
    mechanism : Mechanism
    path : MotorPath
    whole : ClosureProblem
        With the generic ranks of the branch that the path begins on.
    driven : Lead
        Which motors lead, and the loops with the others passive.
    shown : Mechanism
        What is told of: the machine itself, where `mechanism` is the one driven by its tool.
    """

    mechanism: Mechanism
    path: MotorPath
    whole: ClosureProblem
    driven: Lead
    shown: Mechanism

    @classmethod
    def beginning_at(
        cls, start: Configuration, path: MotorPath, shown: Mechanism | None = None
    ) -> Course:
        """Return that of a path that begins at a closed pose."""
        problem, mechanism = start.problem, start.mechanism
        driven = lead(problem, closed_point(problem, start.q))
        return cls(mechanism, path, problem, driven, mechanism if shown is None else shown)

    @property
    def by_tool(self) -> bool:
        """Whether the machine is driven by its tool."""
        return self.shown is not self.mechanism

    @property
    def problem(self) -> ClosureProblem:
        """The loops, with motors that are led passive."""
        return self.driven.problem

    @cached_property
    def columns(self) -> Index:
        """The columns of the motors that lead."""
        return self.problem.partition.actuated

    def driven_to(self, q: Array, piece: PathPiece, t: float) -> Array:
        """Return q with the leading motors where they are at t."""
        values = piece.values(t)[self.driven.leading]
        return self.mechanism.coordinates.with_values(q, self.columns, values)

    def velocity(self, point: Closed, piece: PathPiece, t: float) -> Array:
        """Return dq/dt (nv,) at a regular closed pose."""
        return path_velocity(point, piece.rates(t)[self.driven.leading], self.problem.partition)

    def motion_between(self, point: Closed, piece: PathPiece, start: float, end: float) -> Array:
        """Return how all joints move, to first order, while the motors go straight (nv,)."""
        moved = (piece.values(end) - piece.values(start))[self.driven.leading]
        return path_velocity(point, moved, self.problem.partition)

    def aside(self, piece: PathPiece, start: float, end: float) -> Array | None:
        """Return how far the motors are from a cubic on the way, (nv,); None for nowhere."""
        far = piece.aside(start, end)
        if far is None:
            return None
        found = np.zeros(self.problem.partition.column_scale.size)
        found[self.columns] = far[self.driven.leading]
        return found

    def size(self, motion: Array) -> float:
        """Return the size of a motion (nv,), a rad counted as one characteristic length."""
        partition = self.problem.partition
        return float(np.linalg.norm(motion / partition.column_scale)) / partition.length

    def close(self, q: Array, piece: PathPiece, t: float, motion: Array) -> Closed | None:
        """Close the loops near q at t; None unless Newton's method contracts at once."""
        return corrected(self.problem, self.driven_to(q, piece, t), motion, last=True)

    def strayed(self, q: Array, piece: PathPiece, t: float) -> float:
        """Return how far led motors are from where the path wants them, m or rad; 0 for nowhere."""
        led = self.driven.led
        if not led.size:
            return 0.0
        columns = self.whole.partition.actuated[led]
        off = self.mechanism.coordinates.motion_to(q, columns, piece.values(t)[led])
        far = float(np.abs(off).max())
        return far if far > _LED_TO else 0.0

    def pose_at(self, q: Array) -> Closed:
        """Return a q whose loops are closed, with K* factorised there."""
        return closed_point(self.problem, q)

    def configuration(self, q: Array) -> Configuration:
        """Return the closed pose at q, of the machine that is shown."""
        if self.by_tool:
            return self.shown.configuration(q[: self.shown.nq])
        return self.driven_configuration(q)

    def driven_configuration(self, q: Array) -> Configuration:
        """Return the closed pose at q, on the branch of the path."""
        return Configuration._of_point(self.mechanism, closed_point(self.whole, q), 0, self.whole)
