"""The tool: its pose and the Jacobian of the cut tree, J = [J_v; J_ω], in LOCAL_WORLD_ALIGNED."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.errors import SingularError
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.tool_spec import Tool
from pmjac_pin.values.arrays import Array, norm

_SMALLEST_AREA = 1e-9  # of three points, relative to the product of two of their distances
_ALIGNED = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


class ToolKinematics(Protocol):
    """Jacobian and pose of the tool, once ``pin.computeJointJacobians`` has filled `data`."""

    def at(self, model: pin.Model, data: pin.Data) -> tuple[Array, pin.SE3]:
        """Return J (6, nv), linear rows first, world axes, at the tool's origin; and its pose."""
        ...


def tool_kinematics(model: pin.Model, tool: Tool) -> ToolKinematics:
    """Return the tool that a model file describes."""
    return FrameTool(model, tool.frame) if tool.frame else PointsTool(model, tool.points or ())


class FrameTool:
    """A frame of the tree."""

    __slots__ = ("_index",)

    def __init__(self, model: pin.Model, name: str) -> None:
        self._index = find_frame(model, name).index

    def at(self, model: pin.Model, data: pin.Data) -> tuple[Array, pin.SE3]:
        """Return Pinocchio's frame Jacobian and placement."""
        place = pin.updateFramePlacement(model, data, self._index).copy()
        return frame_jacobian(model, data, self._index), place


class PointsTool:
    """The frame spanned by three points: origin their centroid, x along p₂ − p₁, z their normal.

    The points may belong to bodies that only the loops hold together, as in the lecture's cut
    of the 3-RPS; J_ω is then the derivative of the spanned frame, ω̂ = Ṙ Rᵀ, for each joint
    rate alone, though the triangle deforms.
    """

    __slots__ = ("_indices",)

    def __init__(self, model: pin.Model, names: tuple[str, ...]) -> None:
        self._indices = [find_frame(model, name).index for name in names]

    def at(self, model: pin.Model, data: pin.Data) -> tuple[Array, pin.SE3]:
        """Return the rates of the centroid and of the spanned frame, and where that is."""
        points = self._points(model, data)
        rates = np.stack([frame_jacobian(model, data, index)[:3] for index in self._indices])
        rotation = spanned_rotation(points)
        place = pin.SE3(rotation, points.mean(axis=0))
        return spanned_jacobian(points, rates, rotation), place

    def _points(self, model: pin.Model, data: pin.Data) -> Array:
        points = np.stack(
            [pin.updateFramePlacement(model, data, index).translation for index in self._indices]
        )
        _check_spanning(points)
        return points


def spanned_jacobian(points: Numbers, rates: Numbers, rotation: Numbers) -> Numbers:
    """Return the rates (6, nv) of the centroid and of the frame that three points (3, 3) span.

    With x, y, z the frame's axes, d = p₂ − p₁, e = p₃ − p₁, d = |d|, e_x = x·e, e_y = y·e,
    ω_z = y·ḋ/d and ω_y = −z·ḋ/d follow from ẋ = ω × x, and
    ω_x = (z·ė − (e_x/d) z·ḋ)/e_y from the normal of d and e staying z.

    Parameters
    ----------
    points, rates : ndarray, shapes (3, 3) and (3, 3, nv)
        By rows, and how they move: numbers of any type.
    rotation : ndarray, shape (3, 3)
        `spanned_rotation` of the points.
    """
    x, y, z = rotation.T
    side, apex = points[1] - points[0], points[2] - points[0]
    side_rate, apex_rate = rates[1] - rates[0], rates[2] - rates[0]
    length = x @ side
    roll = (z @ apex_rate - (z @ side_rate) * (x @ apex / length)) / (y @ apex)
    turn = np.stack([roll, -(z @ side_rate) / length, (y @ side_rate) / length])
    return np.vstack([rates.sum(axis=0) / 3.0, rotation @ turn])


def spanned_rotation(points: Numbers, root: Callable[[Any], Any] = np.sqrt) -> Numbers:
    """Return the axes of the frame that three points span: numbers of any type that has roots."""
    side, apex = points[1] - points[0], points[2] - points[0]
    normal = _cross(side, apex)
    x, z = side / root(side.dot(side)), normal / root(normal.dot(normal))
    return np.array([x, _cross(z, x), z]).T


def _check_spanning(points: Array) -> None:
    side, apex = points[1] - points[0], points[2] - points[0]
    area = norm(_cross(side, apex))
    if area <= _SMALLEST_AREA * norm(side) * norm(apex):
        message = "the three points of the tool lie in one line here and span no frame"
        raise SingularError(message, singular_value=area, tolerance=_SMALLEST_AREA, free_motion={})


def frame_jacobian(model: pin.Model, data: pin.Data, index: int) -> Array:
    """Return a frame's Jacobian (6, nv), LOCAL_WORLD_ALIGNED.

    Of a model with one degree of freedom, Pinocchio returns a vector.
    """
    jacobian: Array = pin.getFrameJacobian(model, data, index, _ALIGNED)
    return jacobian if jacobian.ndim > 1 else jacobian[:, None]


def _cross(a: Numbers, b: Numbers) -> Numbers:
    """Return a × b: on single vectors NumPy's own costs ten times as much."""
    (a1, a2, a3), (b1, b2, b3) = a.tolist(), b.tolist()
    return np.array([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1])
