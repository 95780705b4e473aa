"""Slopes: how the Jacobians of loops and tool change along motions of the joints.

By complex steps: what is analytic has, at x + i h v with h far below all rounding, its value as
the real part and h times its derivative along v as the imaginary one, and no digit is lost to a
difference. The kinematics are those of every other number type.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.floats import Floats
from pmjac_pin.kinematics.joint_steps import entry_rates
from pmjac_pin.kinematics.loops import Loops, by_twists
from pmjac_pin.kinematics.tool import spanned_jacobian, spanned_rotation
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.kinematics.world_frames import frame_motion, vectors_in_bodies
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.joint_kind import JointMotion
from pmjac_pin.model.spec import MechanismSpec
from pmjac_pin.model.twist_frame import FrameName, change_frame
from pmjac_pin.values.arrays import Array

_COMPLEX = Floats(rooted=False)
_COMPLEX_STEP = 1e-60  # its square is nothing beside 1


@dataclass(frozen=True, slots=True, eq=False)
class Slopes:
    """How Jacobians change along k motions, in one unit of time each.

    Attributes
    ----------
    constraint : ndarray, shape (k, p, nv)
        Of the constraint Jacobian, all rows, world axes, where the loops are closed.
    """

    constraint: Array
    _tools: tuple[tuple[Numbers, Numbers, Numbers], ...]

    @classmethod
    def of(cls, constraint: Array, tools: Sequence[Array]) -> Slopes:
        """Return those of numbers that a program tells, `RecordedRates.slopes_tape`.

        Parameters
        ----------
        constraint : ndarray, shape (k, p, nv)
        tools : sequence of ndarray, shape (2 (6 nv + 12),)
            How the entries of Jacobian, rotation and position change, and then these.
        """
        nv, found = constraint.shape[2], []
        for told in tools:
            slopes, values = told.reshape(2, -1)
            numbers = values + 1j * _COMPLEX_STEP * slopes
            jacobian, pose = numbers[: 6 * nv].reshape(6, nv), numbers[6 * nv :]
            found.append((jacobian, pose[:9].reshape(3, 3), pose[9:]))
        return cls(constraint, tuple(found))

    def tool(self, frame: FrameName) -> Array:
        """Return that of the tool Jacobian in one of Pinocchio's frames, shape (k, 6, nv)."""
        changed = [change_frame(jacobian, frame, *pose) for jacobian, *pose in self._tools]
        return np.imag(changed).reshape(-1, 6, self.constraint.shape[2]) / _COMPLEX_STEP


class SlopesAlongMotions:
    """The loops and the tool of a mechanism, moved along the real axis and beside it.

    Parameters
    ----------
    model : pin.Model
    spec : MechanismSpec
    values : mapping of str to float
        Of the parameters.
    place : ndarray, shape (3,)
        Where the model stands in the world, m.

    Raises
    ------
    ArgumentError
        A joint that is not in the table of joints.
    """

    __slots__ = ("_frames", "_loops", "_nv", "_place", "_tree")

    def __init__(
        self, model: pin.Model, spec: MechanismSpec, values: Mapping[str, float], place: Array
    ) -> None:
        self._tree, self._nv, self._place = Tree(model), model.nv, place
        self._loops = Loops(model, self._tree, spec.loops, values)
        self._frames = [find_frame(model, name) for name in spec.tool.names]

    def at(self, q: Array, motions: Array) -> Slopes:
        """Return how Jacobians change at a q (nq,) along the columns of motions (nv, k)."""
        if not motions.shape[1]:
            return Slopes(np.empty((0, self._loops.count, self._nv)), ())
        along = entry_rates(self._tree, q[:, None], motions)
        entries = (q[:, None] + 1j * _COMPLEX_STEP * along)[:, None]

        def motion(link: Link) -> JointMotion:
            return link.kind.motion(_COMPLEX, entries[link.entries], link.edge.pitch)

        poses, count = Poses(self._tree, _COMPLEX, motion), motions.shape[1]
        constraint = self._constraint(poses, count)
        return Slopes(constraint.imag / _COMPLEX_STEP, tuple(self._tools(poses, count)))

    def _constraint(self, poses: Poses, count: int) -> Numbers:
        rates = np.zeros((self._loops.count, self._nv, count), dtype=complex)
        for pair in self._loops.pairs:
            for (rows, _), block in zip(pair.blocks, by_twists(pair, poses), strict=True):
                if block.rows.columns:
                    rates[rows, block.rows.columns] = block.rows.rates
        for rows, axes in vectors_in_bodies(self._loops, poses):
            rates[rows] = np.einsum("ijb,jkb->ikb", axes, rates[rows])
        return rates.transpose(2, 0, 1)

    def _tools(self, poses: Poses, count: int) -> list[tuple[Numbers, Numbers, Numbers]]:
        """Return Jacobian, rotation and position of the tool along each motion."""
        each = [frame_motion(poses, frame, self._nv, count) for frame in self._frames]
        if len(each) == 1:
            [(rotation, position, jacobian)] = each
            return [
                (jacobian[..., b], rotation[..., b], position[..., b] + self._place)
                for b in range(count)
            ]
        points = np.array([frame.position for frame in each])
        rates = np.array([frame.jacobian[:3] for frame in each])
        found = []
        for b in range(count):
            rotation = spanned_rotation(points[..., b])
            jacobian = spanned_jacobian(points[..., b], rates[..., b], rotation)
            found.append((jacobian, rotation, points[..., b].mean(axis=0) + self._place))
        return found
