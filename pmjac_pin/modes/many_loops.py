"""The loop equations over many poses at once: for a search, and only for that.

The rows vanish where those of `loops` do. Their derivatives are exact where they vanish, and
near enough elsewhere for damped least squares; what a search finds is judged by Pinocchio.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from pmjac_pin.coupling import Coupling, couple
from pmjac_pin.frames import Frame, find_frame
from pmjac_pin.loop_rows import HALF_A_TURN, Along, Distance, Gap, RightAngle, Rows, Tilt, Turn
from pmjac_pin.loop_spec import JointLoop, Loop
from pmjac_pin.loops import loop_blocks
from pmjac_pin.modes.many_poses import ManyPoses, Poses, crossed

Array = NDArray[np.float64]


class ManyLoops:
    """All loops of a mechanism over rows of q: η (b, p) and ∂η/∂v (b, p, nv)."""

    __slots__ = ("_couplings", "_joints", "_pairs", "_tree")

    def __init__(
        self, model: pin.Model, tree: ManyPoses, loops: Sequence[Loop], values: Mapping[str, float]
    ) -> None:
        self._tree = tree
        self._joints = {joint.idx_v: joint for joint in list(model.joints)[1:]}
        self._couplings: list[Coupling] = []
        self._pairs: list[tuple[Frame, Frame, list[Rows]]] = []
        for loop in loops:
            if isinstance(loop, JointLoop):
                self._couplings.append(couple(model, loop))
            else:
                first, second = (find_frame(model, name) for name in loop.frames)
                self._pairs.append((first, second, loop_blocks(loop, values)))

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Return η (b, p) and ∂η/∂v (b, p, nv) at each row of q."""
        poses = self._tree.poses(q)
        residuals, jacobians = [np.zeros((len(q), 0))], [poses.linear[:, :0]]
        for first, second, blocks in self._pairs:
            one, other = self._end(poses, first), self._end(poses, second)
            for block in blocks:
                residual, jacobian = _rows(block, one, other)
                residuals.append(residual)
                jacobians.append(jacobian)
        for coupling in self._couplings:
            residuals.append(self._coupled(coupling, q)[:, None])
            jacobians.append(
                np.broadcast_to(coupling.gradient, (len(q), 1, coupling.gradient.size))
            )
        return np.concatenate(residuals, axis=1), np.concatenate(jacobians, axis=1)

    def _coupled(self, coupling: Coupling, q: Array) -> Array:
        """Return a coupling's η (b,), as `Coupling.residual` does for one pose."""
        first, second = (self._values(q, column) for column in coupling.columns.tolist())
        difference: Array = second - coupling.ratio * first - coupling.offset
        if coupling.coordinates.wraps[coupling.columns[1]]:
            difference -= 2.0 * np.pi * np.round(difference / (2.0 * np.pi))
        return difference

    def _values(self, q: Array, column: int) -> Array:
        """Return the values (b,) of a joint of one degree of freedom."""
        entries = q[:, self._joints[column].idx_q :][:, : self._joints[column].nq]
        if entries.shape[1] == 1:
            return entries[:, 0]
        return np.asarray(np.arctan2(entries[:, 1], entries[:, 0]))

    def _end(self, poses: Poses, frame: Frame) -> _End:
        rotation, mask = poses.rotations[frame.joint], self._tree.moved_by[frame.joint]
        point = poses.positions[frame.joint] + rotation @ frame.placement.translation
        angular = poses.angular * mask
        velocity = poses.linear * mask - crossed(point, angular)
        return _End(point, rotation @ frame.placement.rotation, velocity, angular)


@dataclass(frozen=True, slots=True, eq=False)
class _End:
    """A loop's frame in b poses: origin, axes, and their rates by v in world axes."""

    point: Array
    axes: Array
    velocity: Array
    angular: Array


def _rows(block: Rows, one: _End, other: _End) -> tuple[Array, Array]:
    """Return η (b, k) and ∂η/∂v (b, k, nv) of one block."""
    gap, rates = one.point - other.point, one.velocity - other.velocity
    turning = one.angular - other.angular
    match block:
        case Gap():
            return gap, rates
        case Distance():
            square = np.einsum("bi,bi->b", gap, gap) - block.length**2
            return square[:, None], 2.0 * np.einsum("bi,biv->bv", gap, rates)[:, None]
        case Along():
            directions = np.einsum("bij,kj->bki", other.axes, block.directions)
            # The directions turn with the second frame.
            whole = rates + crossed(gap, other.angular)
            return np.einsum("bki,bi->bk", directions, gap), directions @ whole
        case Turn():
            return Rotation.from_matrix(
                one.axes @ other.axes.transpose(0, 2, 1)
            ).as_rotvec(), turning
        case Tilt():
            axis = one.axes @ block.axis
            directions = np.einsum("bij,kj->bki", other.axes, block.across)
            above = 1.0 + np.einsum("bi,bi->b", axis, other.axes @ block.axis)
            factor = np.sqrt(2.0 / np.maximum(above, HALF_A_TURN))[:, None]
            swing = -crossed(axis, turning)
            aside = factor * np.einsum("bki,bi->bk", directions, axis)
            aside[above < HALF_A_TURN] = 2.0, 0.0  # where its direction is lost, as in `loop_rows`
            return aside, factor[:, :, None] * (directions @ swing)
        case RightAngle():
            axis, normal = one.axes @ block.first, other.axes @ block.second
            swing = -crossed(axis, turning)
            cosine = np.einsum("bi,bi->b", axis, normal)
            return cosine[:, None], np.einsum("bi,biv->bv", normal, swing)[:, None]
    raise NotImplementedError(type(block).__name__)
