"""Many poses at once: the tree and the loops over rows of q, in NumPy's doubles.

Pinocchio computes one pose at a time; a search over thousands of starts needs them together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra import tape_runner
from pmjac_pin.algebra.floats import Floats
from pmjac_pin.kinematics.joint_steps import moved_by
from pmjac_pin.kinematics.loops import Loops, by_twists
from pmjac_pin.kinematics.places import through
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.model.coupling import Coupling
from pmjac_pin.model.joint_kind import JointMotion
from pmjac_pin.model.loop_spec import Loop
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.found_once import found_once

if TYPE_CHECKING:
    from pmjac_pin.algebra.tape import Tape
    from pmjac_pin.algebra.terms import Term

_FLOATS = Floats()
_MANY = 64  # poses: few do not pay for recording


@dataclass(frozen=True, slots=True, eq=False)
class WorldPoses:
    """Where all bodies are in b poses, and how each degree of freedom moves them.

    Attributes
    ----------
    rotations, positions : ndarray, shapes (bodies, b, 3, 3) and (bodies, b, 3)
        In the world.
    linear, angular : ndarray, shapes (b, 3, nv)
        The motion of each degree of freedom in world axes: angular velocity, and velocity of
        the point of the moved body that is at the world's origin.
    """

    rotations: Array
    positions: Array
    linear: Array
    angular: Array

    def seen_from(self, body: int) -> WorldPoses:
        """Return the same in the axes of one of the bodies, and at its origin."""
        if body == 0:
            return self
        back, origin = self.rotations[body].swapaxes(1, 2), self.positions[body]
        moved = np.cross(origin[:, :, None], self.angular, axis=1)
        return WorldPoses(
            rotations=back @ self.rotations,
            positions=(back @ (self.positions - origin)[..., None])[..., 0],
            linear=back @ (self.linear - moved),
            angular=back @ self.angular,
        )


class ManyPoses:
    """The kinematics of a tree over rows of q.

    Attributes
    ----------
    tree : Tree
    moved_by : ndarray of bool, shape (bodies, nv)
        Which degrees of freedom move which body.
    """

    __slots__ = ("moved_by", "tree")

    def __init__(self, model: pin.Model) -> None:
        self.tree = Tree(model)
        self.moved_by = np.zeros((model.njoints, model.nv), dtype=bool)
        for body, link in self.tree.links.items():
            self.moved_by[body] = self.moved_by[link.edge.parent]
            self.moved_by[body, link.column : link.column + link.kind.nv] = True

    def at(self, q: Array) -> Poses:
        """Return the poses at rows of q, shape (b, nq)."""
        entries = np.ascontiguousarray(q.T)[:, None]

        def motion(link: Link) -> JointMotion:
            return link.kind.motion(_FLOATS, entries[link.entries], link.edge.pitch)

        return Poses(self.tree, _FLOATS, motion)

    def poses(self, q: Array) -> WorldPoses:
        """Return where the bodies are in the world at each row of q, shape (b, nq)."""
        poses, count = self.at(q), len(q)
        bodies, nv = self.moved_by.shape
        columns = np.zeros((bodies, 4, 3, count))
        columns[0, :3] = np.eye(3)[:, :, None]
        linear, angular = np.zeros((nv, 3, count)), np.zeros((nv, 3, count))
        for body, link in self.tree.links.items():
            pose, _ = poses.body(0, body)
            for place, column in enumerate(through(_FLOATS, pose, link.after)):
                columns[body, place] = column[:, 0]
            for one in poses.own_freedoms(0, body):
                if one.origin is None:
                    linear[one.column] = one.axis[:, 0]
                else:
                    moved = _FLOATS.cross(one.origin, one.axis) + one.pitch * one.axis
                    linear[one.column], angular[one.column] = moved[:, 0], one.axis[:, 0]
        return WorldPoses(
            columns[:, :3].transpose(0, 3, 2, 1),
            columns[:, 3].transpose(0, 2, 1),
            linear.transpose(2, 1, 0),
            angular.transpose(2, 1, 0),
        )

    def moved(self, q: Array, v: Array) -> Array:
        """Return q ⊕ v for each row, shapes (b, nq) and (b, nv)."""
        moved = moved_by(_FLOATS, self.tree, np.ascontiguousarray(q.T), np.ascontiguousarray(v.T))
        return np.ascontiguousarray(moved.T)


class ManyLoops:
    """All loops of a mechanism over rows of q: η (b, p) and ∂η/∂v (b, p, nv).

    The rows are those of `Mechanism.rows`, seen from the last body that carries both frames. Many
    go through a recorded program, where there is a kernel that runs it.

    Attributes
    ----------
    loops : Loops
    """

    def __init__(
        self, model: pin.Model, poses: ManyPoses, loops: Sequence[Loop], values: Mapping[str, float]
    ) -> None:
        self.loops, self._poses = Loops(model, poses.tree, loops, values), poses
        self._nq, self._nv = model.nq, model.nv

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Return η (b, p) and ∂η/∂v (b, p, nv) at each row of q, exact on and off closure."""
        tape = self._tape if len(q) >= _MANY else None
        if tape is None:
            return self._evaluated(q)
        found, rows = tape_runner.run(tape, q.T), self.loops.count
        jacobian = found[rows:].reshape(rows, self._nv, len(q))
        return found[:rows].T.copy(), jacobian.transpose(2, 0, 1).copy()

    @found_once
    def _tape(self) -> Tape | None:
        """The program of the rows, None where there is no kernel that runs it."""
        if tape_runner.tape_kernel() is None or not self.loops.count:
            return None
        from pmjac_pin.algebra.tape import Tape  # noqa: PLC0415
        from pmjac_pin.kinematics.recorded import recorded_rows  # noqa: PLC0415

        def make(q: Sequence[Term]) -> list[Term | float]:
            residual, rates = recorded_rows(self.loops, q, self._nv)
            return [*residual, *rates.ravel()]

        return Tape.recorded(self._nq, make)

    def _evaluated(self, q: Array) -> tuple[Array, Array]:
        poses, loops = self._poses.at(q), self.loops
        residual = np.empty((loops.count, len(q)))
        jacobian = np.zeros((loops.count, self._nv, len(q)))
        for pair in loops.pairs:
            for (rows, _), block in zip(pair.blocks, by_twists(pair, poses), strict=True):
                residual[rows] = block.rows.value[:, 0]
                if block.rows.columns:
                    jacobian[rows, block.rows.columns] = block.rows.rates
        for row, coupling in loops.couplings.items():
            residual[row] = self._coupled(coupling, q)
            jacobian[row] = coupling.gradient[:, None]
        return residual.T.copy(), jacobian.transpose(2, 0, 1).copy()

    def _coupled(self, coupling: Coupling, q: Array) -> Array:
        """Return a coupling's η (b,), as `Coupling.residual` does for one pose."""
        first, second = (self._values(q, column) for column in coupling.columns.tolist())
        return coupling.equation(first, second, _within_half_turns)

    def _values(self, q: Array, column: int) -> Array:
        """Return the values (b,) of a joint of one degree of freedom."""
        link = next(one for one in self._poses.tree.links.values() if one.column == column)
        entries = q[:, link.entries]
        if entries.shape[1] == 1:
            return entries[:, 0]
        return np.asarray(np.arctan2(entries[:, 1], entries[:, 0]))


def _within_half_turns(angles: Array) -> Array:
    return np.asarray(angles - 2.0 * np.pi * np.round(angles / (2.0 * np.pi)))
