"""The frames in which Pinocchio writes a twist, and a tool Jacobian in each of them."""

from __future__ import annotations

from typing import Literal

import numpy as np

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.arrays import Array

FrameName = Literal["LOCAL", "WORLD", "LOCAL_WORLD_ALIGNED"]


def change_frame(tool_jacobian: Array, frame: FrameName, rotation: Array, position: Array) -> Array:
    """Express a LOCAL_WORLD_ALIGNED Jacobian in another of Pinocchio's frames.

    LOCAL: both blocks times Rᵀ. WORLD: v at the world's origin, v + p × ω.

    Parameters
    ----------
    tool_jacobian : ndarray, shape (6, k)
    frame : {"LOCAL", "WORLD", "LOCAL_WORLD_ALIGNED"}
    rotation, position : ndarray, shapes (3, 3) and (3,)
        The tool's pose in the world.
    """
    linear, angular = tool_jacobian[:3], tool_jacobian[3:]
    match frame:
        case "LOCAL_WORLD_ALIGNED":
            return tool_jacobian
        case "LOCAL":
            return np.vstack([rotation.T @ linear, rotation.T @ angular])
        case "WORLD":
            return np.vstack([linear + np.cross(position, angular, axisb=0).T, angular])
    names = "LOCAL, WORLD or LOCAL_WORLD_ALIGNED"
    raise ArgumentError(f"frame must be {names}, got {quoted(frame)}")
