"""How loops hold a joint: the least force and moment between its bodies for a unit torque about it.

Rows λ of [K K*] (and of the tool, where it is locked) hold an effort τ at one joint, and none at
the other free ones, where λᵀ M = τᵀ, M the columns that are free. Rows that the loops' redundancy
leaves open, λᵀ M = 0, are chosen so that the force is least, and then the moment.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pmjac_pin.rates.factorisation import Factorisation, factorise
from pmjac_pin.rates.margins import JointMargin
from pmjac_pin.values.arrays import Array, Index, norm

JointMotionKind = Literal["turns", "turns any way", "slides"]

_UNHELD = JointMargin(0.0, 0.0, 0.0)
_NONE = 1e-9  # of a unit torque: force × length, or distance, that is rounding
_FREE_MOTION = 1e-6  # of a motion on scaled rates: less is rounding
_PASSES = 1e-7  # of force × distance, or a unit torque: moment where the force passes through


@dataclass(frozen=True, slots=True, eq=False)
class HeldJoint:
    """A joint, and how rows act between its two bodies.

    Attributes
    ----------
    name : str
    columns : ndarray of int
    moves : {"turns", "turns any way", "slides"}
    axis : ndarray, shape (3,)
        World axes; of no meaning where it turns any way.
    wrenches : ndarray, shape (6, p)
        Force and moment about `centre` that the rows of the loops exert on what the joint carries.
    of_tool : ndarray, shape (6, 6)
        The same of the rows of the tool's twist.
    centre : ndarray, shape (3,)
    sides : tuple of ndarray, shapes (k, 3)
        Where else each of its two bodies is held, world; nothing of the ground.
    """

    name: str
    columns: Index
    moves: JointMotionKind
    axis: Array
    wrenches: Array
    of_tool: Array
    centre: Array
    sides: tuple[Array, Array]


@dataclass(frozen=True, slots=True, eq=False)
class Holding:
    """What holds the free columns.

    Attributes
    ----------
    matrix : Factorisation
        M without dimension: the free columns of the loops' rows, and of the tool's where locked.
    rank : int
        Of M at the pose.
    columns : ndarray of int, shape (k,)
        The free ones.
    column_scale : ndarray, shape (k,)
        Theirs.
    gained : ndarray, shape (k, g)
        Motions on scaled rates that come free at this pose.
    idle : ndarray, shape (k, i)
        Those that are free at every pose.
    length : float
    """

    matrix: Factorisation
    rank: int
    columns: Index
    column_scale: Array
    gained: Array
    idle: Array
    length: float

    def margin(self, joint: HeldJoint, wrenches: Array) -> JointMargin | None:
        """Return a joint's margin, None where it moves freely at every pose.

        Parameters
        ----------
        joint : HeldJoint
        wrenches : ndarray, shape (6, rows)
            Of the scaled rows of M, between the bodies of the joint.
        """
        own = np.array([int(np.flatnonzero(self.columns == c)[0]) for c in joint.columns])
        efforts = factorise(self.idle[own].T, 1.0, _FREE_MOTION).null_space
        if not efforts.shape[1]:
            return None
        if norm(efforts.T @ self.gained[own]) > _FREE_MOTION:
            return _UNHELD
        torques = np.zeros((self.columns.size, efforts.shape[1]))
        torques[own] = self.column_scale[own, None] * efforts
        rows = self.matrix.inverse(self.rank).T @ torques
        forces, moments, open_moments = _least_forces(wrenches, rows, self._open())
        if joint.moves == "turns":
            return self._of_turning(joint, forces[:, 0], moments[:, 0], open_moments)
        largest = float(factorise(forces, 1.0).singular_values[0])
        if joint.moves == "slides":
            return JointMargin(math.inf, _elevation(joint.axis, forces[:, 0]))
        return JointMargin(self._arm(largest), math.pi / 2.0)

    def _open(self) -> Array:
        """Return the rows that hold nothing by themselves, (rows, k)."""
        return self.matrix.left[:, self.rank :]

    def _arm(self, force: float) -> float:
        return 1.0 / force if force * self.length > _NONE else math.inf

    def _of_turning(
        self, joint: HeldJoint, force: Array, moment: Array, open_moments: Array
    ) -> JointMargin:
        """Return the margin of a hinge: its moment is the least about any point of its axis."""
        along = np.column_stack([open_moments, np.cross(joint.axis, force) * self.length])
        chosen = factorise(along.T, max(norm(moment), norm(along))).null_space
        about = _MomentsAbout(joint, force, moment, chosen @ chosen.T)
        arm = self._arm(norm(force))
        angle = _elevation(joint.axis, about.at(joint.centre))
        return JointMargin(arm, angle, about.transmission() if math.isfinite(arm) else math.nan)


@dataclass(frozen=True, slots=True, eq=False)
class _MomentsAbout:
    """The force that holds a hinge, its moment about the hinge, and what of moments is not open.

    They are open in what the loops' redundancy leaves, and in what a point makes that moves along
    the axis.
    """

    joint: HeldJoint
    force: Array
    moment: Array
    closed: Array

    def at(self, point: Array) -> Array:
        """Return the moment about a point."""
        moved = self.moment - np.cross(point - self.joint.centre, self.force)
        return np.asarray(self.closed @ moved)

    def transmission(self) -> float:
        """Return the smallest angle between force and link, of links with one other joint."""
        found = []
        for points in self.joint.sides:
            across = np.cross(self.joint.axis, points - self.joint.centre)
            radius = norm(across[:1])
            alike = np.linalg.norm(across - across[:1], axis=1) <= _PASSES * radius
            if not (radius and alike.all()):  # of no other joint, or of several
                continue
            left = norm(self.at(points[0]))
            if left <= _PASSES * max(radius * norm(self.force), 1.0):
                found.append(_elevation(across[0] / radius, self.force))
        return min(found, default=math.nan)


def _least_forces(wrenches: Array, rows: Array, open_rows: Array) -> tuple[Array, Array, Array]:
    """Return forces and moments (3, k) of rows, with the least force that open rows leave.

    And the moments (3, i) that open rows make without a force.
    """
    by_open = wrenches @ open_rows
    found = factorise(by_open[:3], norm(wrenches[:3]))
    whole = wrenches @ rows
    chosen = whole - by_open @ (found.inverse(found.rank) @ whole[:3])
    return chosen[:3], chosen[3:], by_open[3:] @ found.null_space


def _elevation(axis: Array, vector: Array) -> float:
    """Return the angle, up to π/2, between a vector and the plane across a unit axis."""
    along = float(axis @ vector)
    return math.atan2(abs(along), norm(vector - along * axis))
