"""Names of frames on one side, Pinocchio's frame indices and placements on the other."""

from __future__ import annotations

from dataclasses import dataclass

import pinocchio as pin

from pmjac_pin.errors import unknown_name

# A link, a fixed joint and a joint may share a name: a user who writes it means the link.
_PREFERENCE = (pin.FrameType.BODY, pin.FrameType.FIXED_JOINT, pin.FrameType.OP_FRAME)


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame fixed to a joint of the tree.

    Attributes
    ----------
    index : int
        Pinocchio's frame index.
    joint : int
        Pinocchio's index of the joint that carries the frame.
    placement : pin.SE3
        Of the frame in that joint.
    """

    index: int
    joint: int
    placement: pin.SE3


def find_frame(model: pin.Model, name: str) -> Frame:
    """Return a frame by its name.

    Raises
    ------
    UnknownNameError
        Where Pinocchio's ``getFrameId`` would return ``nframes`` in silence.
    """
    matches = [
        index
        for index, frame in enumerate(model.frames)
        if frame.name == name and frame.type != pin.FrameType.SENSOR
    ]
    if not matches:
        raise unknown_name("frame", name, tuple(frame.name for frame in model.frames))

    def preference(index: int) -> int:
        kind = model.frames[index].type
        return _PREFERENCE.index(kind) if kind in _PREFERENCE else len(_PREFERENCE)

    index = min(matches, key=preference)
    frame = model.frames[index]
    return Frame(index, frame.parentJoint, frame.placement.copy())
