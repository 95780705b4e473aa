"""Wrenches at one tool or several, as loads on the freedoms of the cut tree."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from numpy.typing import ArrayLike

from pmjac_pin.closing.parts import Parts
from pmjac_pin.errors import quoted
from pmjac_pin.kinematics.tool import tool_kinematics
from pmjac_pin.model.pinocchio_model import checked_tool
from pmjac_pin.model.tool_spec import Tool
from pmjac_pin.model.twist_frame import FrameName, change_frame
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_vector

Wrenches: TypeAlias = ArrayLike | Mapping[str | tuple[str, str, str], ArrayLike]


def held_wrenches(parts: Parts, q: Array, wrenches: Wrenches, frame: FrameName) -> list[Array]:
    """Return what it takes to hold the tree against each wrench, −Jᵀ w, shape (nv,).

    Parameters
    ----------
    parts : Parts
    q : ndarray, shape (nq,)
    wrenches : array_like, shape (6,), or mapping of frames to such
        On the tool, or on each of these: a frame, or three that span one.
    frame : FrameName
        In which each of them is written.

    Raises
    ------
    UnknownNameError, ArgumentError
        No such frame, or numbers that are no wrench.
    """
    return [
        _held_by_motors(parts, q, tool, wrench, frame) for tool, wrench in _by_tool(parts, wrenches)
    ]


def _by_tool(parts: Parts, wrenches: Wrenches) -> list[tuple[Tool, Array]]:
    if not isinstance(wrenches, Mapping):
        return [(parts.spec.tool, as_vector(wrenches, 6, "a wrench"))]
    return [
        (checked_tool(on), as_vector(wrench, 6, f"the wrench on {quoted(on)}"))
        for on, wrench in wrenches.items()
    ]


def _held_by_motors(parts: Parts, q: Array, tool: Tool, wrench: Array, frame: FrameName) -> Array:
    kinematics = parts.kinematics
    jacobian, pose = kinematics.tool_at(q, tool_kinematics(kinematics.model, tool))
    written = change_frame(jacobian, frame, pose.rotation, pose.translation + parts.place)
    held: Array = -written.T @ wrench
    return held
