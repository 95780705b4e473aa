"""Pinocchio's frames of a twist or a wrench, as a caller names them."""

from __future__ import annotations

import pinocchio as pin

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.twist_frame import FrameName


def frame_name(frame: str | pin.ReferenceFrame) -> FrameName:
    """Return the name of one of Pinocchio's frames, or say which there are."""
    name = frame.name if isinstance(frame, pin.ReferenceFrame) else frame
    if isinstance(name, str):  # of an array, a comparison is none
        match name.upper():
            case "LOCAL_WORLD_ALIGNED" | "LOCAL" | "WORLD" as known:
                return known
            case _:
                pass
    names = "LOCAL, WORLD or LOCAL_WORLD_ALIGNED"
    raise ArgumentError(f"frame must be {names}, got {quoted(frame)}")
