"""Held joints: how the rows of loops and of the tool act between the two bodies of a joint.

By the principle of virtual work: were what a joint carries moved by a twist, rows λ would do the
work λᵀ B of it, B their rates by that twist. So Bᵀ λ is the wrench that they exert on it.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
import pinocchio as pin

from pmjac_pin.closing.parts import Parts
from pmjac_pin.kinematics.tool import spanned_jacobian
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.joint_kinds import kind_of
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.model.twist_frame import change_frame
from pmjac_pin.rates.joint_margins import HeldJoint, JointMotionKind
from pmjac_pin.values.arrays import Array


class HeldJoints:
    """The joints of a mechanism at one q, those that turn about one axis or any way, or slide.

    Parameters
    ----------
    parts : Parts
    q : ndarray, shape (nq,)
    locked : collection of int
        Columns that are locked: bodies that these joints join are one.
    tool : bool
        Whether the tool is held, which then is a place where forces act.
    """

    def __init__(self, parts: Parts, q: Array, locked: Collection[int], *, tool: bool) -> None:
        self._parts, self._model, self._tool_held = parts, parts.model, tool
        self._body = _rigid_bodies(parts.model, locked)
        self._data = parts.kinematics.placed(q).copy()
        self._placed = [frame.translation for frame in self._data.oMf]
        self._loops = [
            (number, [find_frame(parts.model, name) for name in loop.frames])
            for number, loop in enumerate(parts.spec.loops)
            if not isinstance(loop, JointLoop)
        ]

    def of(self, names: Sequence[str]) -> list[HeldJoint]:
        """Return those of these joints whose motion is of one of the three kinds."""
        indices = [self._model.getJointId(name) for name in names]
        kinds = [_motion_kind(self._model.joints[index]) for index in indices]
        return [
            self._held(index, kind)
            for index, kind in zip(indices, kinds, strict=True)
            if kind is not None
        ]

    def _held(self, index: int, moves: JointMotionKind) -> HeldJoint:
        model, joint = self._model, self._model.joints[index]
        columns = joint.idx_v + np.arange(joint.nv)
        first = self._data.J[:, joint.idx_v]
        centre = self._data.oMi[index].translation.copy()
        carried = set(map(int, model.subtrees[index]))
        return HeldJoint(
            name=model.names[index],
            columns=columns,
            moves=moves,
            axis=np.array(first[:3] if moves == "slides" else first[3:]),
            wrenches=self._rows_by_twist(carried, centre).T,
            of_tool=self._tool_by_twist(carried, centre).T,
            centre=centre,
            sides=(self._points(index, index), self._points(index, model.parents[index])),
        )

    def _rows_by_twist(self, carried: set[int], centre: Array) -> Array:
        """Return B (p, 6): how rows, in the anchors' axes, change with a twist about a point."""
        loops = self._parts.kinematics.loops
        found = np.zeros((len(loops.row_names), 6))
        for number, (first, second) in self._loops:
            sign = (first.joint in carried) - (second.joint in carried)
            if sign:
                twists = sign * _velocities(self._placed[first.index] - centre)
                rows = loops.rows_by_twists(self._model, self._data, number, twists)
                found[loops.slices[number]] = rows
        return found

    def _tool_by_twist(self, carried: set[int], centre: Array) -> Array:
        """Return how the rows of the tool's twist, in the judged axes, change with one (6, 6)."""
        tool = self._parts.spec.tool
        if tool.is_none:
            return np.zeros((6, 6))
        frames = [find_frame(self._model, name) for name in tool.names]
        rates = np.array(
            [(f.joint in carried) * _velocities(self._placed[f.index] - centre) for f in frames]
        )
        pose = self._parts.kinematics.tool.at(self._model, self._data)[1]
        rotation, position = pose.rotation, pose.translation
        if len(frames) == 1:
            aligned = rates[0]
        else:
            points = np.array([self._placed[frame.index] for frame in frames])
            aligned = spanned_jacobian(points, rates[:, :3], rotation)
        return change_frame(aligned, tool.judged.axes, rotation, position)

    def _points(self, index: int, side: int) -> Array:
        """Return where else a joint's body is held: at joints, at loops and at the tool.

        Nothing of the ground, which is no link.
        """
        model, body = self._model, self._body
        if not body[side]:
            return np.zeros((0, 3))
        joints = [
            self._data.oMi[k].translation
            for k in range(1, model.njoints)
            if k != index and body[k] != body[model.parents[k]]
            if body[side] in (body[k], body[model.parents[k]])
        ]
        ends = [frame for _, frames in self._loops for frame in frames]
        if self._tool_held:
            ends += [find_frame(model, name) for name in self._parts.spec.tool.names]
        places = [self._placed[end.index] for end in ends if body[end.joint] == body[side]]
        return np.array([*joints, *places]).reshape(-1, 3)


def _rigid_bodies(model: pin.Model, locked: Collection[int]) -> list[int]:
    """Return for each body which one it is a part of, those that locked joints join being one."""
    bodies = [0]
    for index in range(1, model.njoints):
        joint = model.joints[index]
        still = all(joint.idx_v + k in locked for k in range(joint.nv))
        bodies.append(bodies[model.parents[index]] if still else index)
    return bodies


def _velocities(arm: Array) -> Array:
    """Return the twist (6, 6) at a point of a body that has unit twists where the arm starts."""
    found = np.eye(6)
    found[:3, 3:] = -pin.skew(arm)
    return found


def _motion_kind(joint: pin.JointModel) -> JointMotionKind | None:
    kind = kind_of(joint)
    if kind is None or kind.screw:
        return None
    if (kind.slides, kind.turns) == (1, 0):
        return "slides"
    if kind.slides or kind.in_turn:
        return None
    return "turns" if kind.turns == 1 else "turns any way"
