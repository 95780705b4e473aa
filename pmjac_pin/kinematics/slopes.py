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
from pmjac_pin.kinematics.loops import Loops, by_twists
from pmjac_pin.kinematics.places import through
from pmjac_pin.kinematics.tool import spanned_jacobian, spanned_rotation
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.model.frames import Frame, find_frame
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
        moving = q + 1j * _COMPLEX_STEP * entry_rates(self._tree, q, motions)
        entries = np.ascontiguousarray(moving.T)[:, None]

        def motion(link: Link) -> JointMotion:
            return link.kind.motion(_COMPLEX, entries[link.entries], link.edge.pitch)

        poses, count = Poses(self._tree, _COMPLEX, motion), len(moving)
        constraint = self._constraint(poses, count)
        return Slopes(constraint.imag / _COMPLEX_STEP, tuple(self._tools(poses, count)))

    def _constraint(self, poses: Poses, count: int) -> Numbers:
        rates = np.zeros((self._loops.count, self._nv, count), dtype=complex)
        for pair in self._loops.pairs:
            axes = _axes(poses, pair.base) if pair.base else None
            for (rows, kind), block in zip(pair.blocks, by_twists(pair, poses), strict=True):
                if block.rows.columns:
                    rates[rows, block.rows.columns] = block.rows.rates
                if kind.vector and axes is not None:
                    rates[rows] = np.einsum("ijb,jkb->ikb", axes, rates[rows])
        return rates.transpose(2, 0, 1)

    def _tools(self, poses: Poses, count: int) -> list[tuple[Numbers, Numbers, Numbers]]:
        """Return Jacobian, rotation and position of the tool along each motion."""
        each = [self._frame(poses, frame, count) for frame in self._frames]
        if len(each) == 1:
            [(jacobian, rotation, position)] = each
            return [
                (jacobian[..., b], rotation[..., b], position[..., b] + self._place)
                for b in range(count)
            ]
        points = np.array([position for _, _, position in each])
        rates = np.array([jacobian[:3] for jacobian, *_ in each])
        found = []
        for b in range(count):
            rotation = spanned_rotation(points[..., b])
            jacobian = spanned_jacobian(points[..., b], rates[..., b], rotation)
            found.append((jacobian, rotation, points[..., b].mean(axis=0) + self._place))
        return found

    def _frame(self, poses: Poses, frame: Frame, count: int) -> tuple[Numbers, Numbers, Numbers]:
        """Return a frame's Jacobian, rotation and position: (6, nv, b), (3, 3, b) and (3, b)."""
        seen, jacobian = poses.twisted(0, frame), np.zeros((6, self._nv, count), dtype=complex)
        origin, axes = seen.origin(), seen.carried(np.eye(3)).value
        if origin.columns:
            jacobian[:3, origin.columns] = origin.rates
        for one in poses.freedoms(0, frame.joint):
            if one.origin is not None:
                jacobian[3:, one.column] = one.axis[:, 0]
        rotation = np.broadcast_to(axes[:, :, 0], (3, 3, count))
        return jacobian, rotation, np.broadcast_to(origin.value[:, 0], (3, count))


def entry_rates(tree: Tree, q: Array, motions: Array) -> Array:
    """Return the derivatives of q's entries along motions (nv, k), shape (k, nq)."""
    rates = np.empty((motions.shape[1], q.size))
    for link in tree.links.values():
        kind, own = link.kind, slice(link.column, link.column + link.kind.nv)
        if kind.nq == kind.nv and not kind.curved:
            rates[:, link.entries] = motions[own].T
        else:
            entries = np.tile(q[link.entries], (len(rates), 1))
            rates[:, link.entries] = kind.rates(entries, motions[own].T.copy())
    return rates


def _axes(poses: Poses, body: int) -> Numbers:
    """Return the axes of a body's frame in the world, as columns, (3, 3, b)."""
    pose, _ = poses.body(0, body)
    *axes, _ = through(_COMPLEX, pose, poses.tree.links[body].after)
    return np.stack(np.broadcast_arrays(*(axis[:, 0] for axis in axes)), axis=1)
