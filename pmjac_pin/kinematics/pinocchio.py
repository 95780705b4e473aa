"""Kinematics: where Pinocchio is called, in the one order that gives right numbers.

Model, loops and tool never change; Pinocchio's scratch data is one set for each thread.
"""

from __future__ import annotations

import threading
from functools import cache
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from pmjac_pin.kinematics.loop_system import LoopData, LoopSystem
from pmjac_pin.kinematics.tool import ToolKinematics
from pmjac_pin.model.tool_rows import WORLD_AXES, ToolRows
from pmjac_pin.model.twist_frame import change_frame
from pmjac_pin.values.arrays import Array, read_only


class Snapshot(NamedTuple):
    """Everything about one q that later steps need, as plain arrays.

    Attributes
    ----------
    residual : ndarray, shape (p,)
        η(q).
    constraint_jacobian : ndarray, shape (p, nv)
        ∂η/∂v, all rows, world axes.
    tool_jacobian : ndarray, shape (6, nv)
        In LOCAL_WORLD_ALIGNED.
    tool_pose : pin.SE3
        In the world.
    """

    residual: Array
    constraint_jacobian: Array
    tool_jacobian: Array
    tool_pose: pin.SE3

    @property
    def rotation(self) -> Array:
        """The tool's axes in the world, as columns, shape (3, 3)."""
        rotation: Array = self.tool_pose.rotation
        return rotation

    @property
    def position(self) -> Array:
        """Where the tool is in the world, shape (3,), m."""
        position: Array = self.tool_pose.translation
        return position

    def judged_jacobian(self, rows: ToolRows) -> Array:
        """Return the tool Jacobian (6, nv) in the axes of the rows that are judged."""
        return change_frame(self.tool_jacobian, rows.axes, self.rotation, self.position)

    def axes_of(self, rows: ToolRows) -> Array:
        """Return the axes of the rows that are judged, as columns in the world, shape (3, 3)."""
        return np.eye(3) if rows.axes == WORLD_AXES else self.rotation


class _Scratch(threading.local):
    data: pin.Data
    loops: LoopData


class Kinematics:
    """The loops and the tool as functions of q; safe to use from many threads.

    Parameters
    ----------
    model : pin.Model
    loops : LoopSystem
    tool : ToolKinematics
    data : pin.Data, optional
        For this thread: that of the model, or of it standing elsewhere, which nobody else uses.
        One of a large model costs more to make than a hundred poses.
    """

    __slots__ = ("_scratch", "loops", "model", "tool")

    def __init__(
        self,
        model: pin.Model,
        loops: LoopSystem,
        tool: ToolKinematics,
        data: pin.Data | None = None,
    ) -> None:
        self.model = model
        self.loops = loops
        self.tool = tool
        self._scratch = _Scratch()
        if data is not None:
            self._scratch.data, self._scratch.loops = data, loops.create_data()

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Return the residual η (p,) and its Jacobian ∂η/∂v (p, nv), in the anchors' axes."""
        scratch = self._at(q)
        return self.loops.evaluate(self.model, scratch.data, scratch.loops, q)

    def closure(self, q: Array) -> tuple[Array, Array]:
        """Return η (p,) and ∂η/∂v (p, nv), each loop seen from the body that carries both ends.

        The derivative is that of rows which turn with their second frame: off closure, exact for
        Newton's method, where both are turned alike.
        """
        scratch = self._at(q)
        return self.loops.from_base(self.model, scratch.data, scratch.loops, q)

    def loop_equations(self, q: Array) -> tuple[Array, Array]:
        """Return η (p,) and ∂η/∂v (p, nv) in world axes, exact on and off closure."""
        scratch = self._at(q)
        residual, jacobian = self.loops.in_world(self.model, scratch.data, scratch.loops, q)
        self.loops.add_turning(self.model, scratch.data, residual, jacobian)
        return residual, jacobian

    def snapshot(self, q: Array) -> Snapshot:
        """Return loops and tool at q."""
        scratch = self._at(q)
        data = scratch.data
        residual, constraint_jacobian = self.loops.in_world(self.model, data, scratch.loops, q)
        tool_jacobian, tool_pose = self.tool.at(self.model, data)
        return Snapshot(residual, constraint_jacobian, tool_jacobian, tool_pose)

    def tool_at(self, q: Array, tool: ToolKinematics) -> tuple[Array, pin.SE3]:
        """Return the Jacobian (6, nv) of any tool, LOCAL_WORLD_ALIGNED, and its pose."""
        return tool.at(self.model, self._at(q).data)

    def mass_matrix(self, q: Array) -> Array:
        """Return that of the cut tree, shape (nv, nv), armatures included."""
        if is_depth_first(self.model):
            masses = pin.crba(self.model, self._thread_scratch().data, q)
        else:  # of these `crba` gives other numbers, without a word
            masses = self._masses_by_columns(q)
        upper = masses * _upper_half(self.model.nv)
        whole: Array = upper + upper.T
        return whole

    def _masses_by_columns(self, q: Array) -> Array:
        """Return the mass matrix by what each joint's acceleration asks for."""
        still, one_by_one = np.zeros(self.model.nv), np.eye(self.model.nv)
        at_rest = self.efforts(q, still, still)
        return np.stack([self.efforts(q, still, a) - at_rest for a in one_by_one], axis=1)

    def efforts(self, q: Array, v: Array, a: Array) -> Array:
        """Return the efforts (nv,) that move the cut tree so, gravity included."""
        efforts: Array = pin.rnea(self.model, self._thread_scratch().data, q, v, a)
        return efforts.copy()

    def placed(self, q: Array) -> pin.Data:
        """Return this thread's scratch data, joints' motions and frames computed at q.

        What is read off it has to be read before the next call, which ranks are found by, too, when
        they are first asked for.
        """
        data = self._at(q).data
        pin.updateFramePlacements(self.model, data)
        return data

    def _at(self, q: Array) -> _Scratch:
        """Return this thread's scratch, the joints' motions computed at q."""
        scratch = self._scratch
        try:
            pin.computeJointJacobians(self.model, scratch.data, q)
        except AttributeError:  # the first call of a thread
            pin.computeJointJacobians(self.model, self._thread_scratch().data, q)
        return scratch

    def _thread_scratch(self) -> _Scratch:
        scratch = self._scratch
        if not hasattr(scratch, "data"):
            scratch.data = self.model.createData()
            scratch.loops = self.loops.create_data()
        return scratch


def is_depth_first(model: pin.Model) -> bool:
    """Tell whether each joint's subtree follows it at once, as in what Pinocchio reads itself.

    In a model that is put together joint by joint others may stand between.
    """
    way = [0]
    for joint, parent in enumerate(list(model.parents)[1:], start=1):
        while way and way[-1] != parent:
            way.pop()
        if not way:
            return False
        way.append(joint)
    return True


@cache
def _upper_half(size: int) -> Array:
    """Return what makes of a matrix, added to its transpose, the symmetric one of its upper half.

    `crba` writes the upper half alone.
    """
    return read_only(np.triu(np.ones((size, size))) - 0.5 * np.eye(size))
