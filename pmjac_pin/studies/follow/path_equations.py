"""PathEquations: the loops near a pose of a path, as functions of passive joints and parameter.

Of the rows and passive motions that K* holds at a regular pose near by, r of each: x = (y, s), y
the passive joints' motion in lengths or rad, s the parameter, in which motors move by one length.
G is r numbers, G_x = [G_y G_s] is r × (r + 1), and the path is where G = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.motor_path import PathPiece
from pmjac_pin.values.arrays import Array, norm

_SLOPE_STEP = 1e-5  # of a length: where nothing but Pinocchio knows a joint


@dataclass(frozen=True, slots=True, eq=False)
class PathEquations:
    """The equations near a pose.

    Attributes
    ----------
    course : Course
    piece : PathPiece
    rows : ndarray, shape (r, p)
        What of η without dimension is asked for.
    motions : ndarray, shape (m_p, r)
        The passive motions, on the scaled rates.
    pace : float
        How fast the motors move there, m for a unit of the parameter.
    """

    course: Course
    piece: PathPiece
    rows: Array
    motions: Array
    pace: float

    @classmethod
    def near(cls, course: Course, piece: PathPiece, q: Array, t: float) -> PathEquations | None:
        """Return those of a regular pose; None where motors rest there, or nothing is passive."""
        partition = course.problem.partition
        pace = norm(piece.rates(t)[course.driven.leading] / partition.motor_scale)
        rank = partition.passive_rank
        if not (pace and rank):
            return None
        _, jacobian = course.mechanism.kinematics.loop_equations(q)
        factors = partition.loop_rates(jacobian).passive
        return cls(course, piece, factors.left[:, :rank].T, factors.right[:rank].T, pace)

    @property
    def rank(self) -> int:
        """How many equations there are."""
        return len(self.rows)

    def at(self, q: Array, t: float) -> tuple[Array, Array]:
        """Return G (r,) and G_x (r, r + 1)."""
        partition = self.course.problem.partition
        residual, jacobian = self.course.mechanism.kinematics.loop_equations(q)
        scaled = self.rows @ partition.scaled(jacobian)
        return self.rows @ (residual * partition.row_scale), self._by_unknowns(scaled, t)

    def moved(self, q: Array, t: float, step: Array) -> tuple[Array, float]:
        """Return q and t after a step of x."""
        course, there = self.course, t + float(step[-1]) / self.pace
        q = course.problem.integrate(q, self.velocity(t, np.append(step[:-1], 0.0)))
        return course.driven_to(q, self.piece, there), there

    def velocity(self, t: float, x: Array) -> Array:
        """Return the motion (nv,) of all joints, of one of x."""
        partition = self.course.problem.partition
        found = np.zeros(partition.column_scale.size)
        found[partition.passive] = self.motions @ x[:-1]
        found[partition.passive] *= partition.column_scale[partition.passive]
        rates = self.piece.rates(t)[self.course.driven.leading]
        found[partition.actuated] = rates * (x[-1] / self.pace)
        return found

    def rate(self, t: float, x: Array) -> Array:
        """Return dq/dt (nv,) along a tangent x on which the motors move."""
        return self.velocity(t, x * (self.pace / x[-1]))

    def slopes(self, q: Array, t: float, along: Array) -> Array:
        """Return how G_x changes along the columns of x (r + 1, k), shape (k, r, r + 1)."""
        partition, course = self.course.problem.partition, self.course
        motions = np.array([self.velocity(t, x) for x in along.T]).T
        changed = self._jacobian_slopes(q, motions)
        bent = self.piece.accelerations(t)[course.driven.leading]
        bent = bent / self.pace / partition.motor_scale
        _, jacobian = course.mechanism.kinematics.loop_equations(q)
        K = self.rows @ partition.scaled(jacobian)[:, partition.actuated]
        found = []
        for x, one in zip(along.T, changed, strict=True):
            slope = self._by_unknowns(self.rows @ partition.scaled(one), t)
            slope[:, -1] += K @ bent * (x[-1] / self.pace)
            found.append(slope)
        return np.array(found)

    def _by_unknowns(self, scaled: Array, t: float) -> Array:
        """Return derivatives by x of those by the scaled columns."""
        partition = self.course.problem.partition
        rates = self.piece.rates(t)[self.course.driven.leading] / partition.motor_scale
        own = scaled[:, partition.passive] @ self.motions
        return np.column_stack([own, scaled[:, partition.actuated] @ rates / self.pace])

    def _jacobian_slopes(self, q: Array, motions: Array) -> Array:
        mechanism, problem = self.course.mechanism, self.course.problem
        if (slopes := mechanism.slopes) is not None:
            return slopes.at(q, motions).constraint
        found = []
        for motion in motions.T:
            size = norm(motion / problem.partition.column_scale)
            h = _SLOPE_STEP * problem.partition.length / (size or 1.0)
            ends = [
                mechanism.kinematics.loop_equations(problem.integrate(q, side * h * motion))[1]
                for side in (-1.0, 1.0)
            ]
            found.append((ends[1] - ends[0]) / (2.0 * h))
        return np.array(found)
