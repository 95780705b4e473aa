"""Names of frames on one side, Pinocchio's frame indices and placements on the other."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError, unknown_name

# A link may share its name with a joint: a user who writes it means the link.
_JOINT_FRAMES = (pin.FrameType.JOINT, pin.FrameType.FIXED_JOINT)
_FRAME_KINDS = {
    pin.FrameType.BODY: "link",
    pin.FrameType.FIXED_JOINT: "fixed joint",
    pin.FrameType.JOINT: "joint",
    pin.FrameType.OP_FRAME: "frame",
}


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
    """Return a frame by its name: a link or an added frame rather than a joint.

    Raises
    ------
    UnknownNameError
        Where Pinocchio's ``getFrameId`` would return ``nframes`` in silence.
    ArgumentError
        Several of this name in different places, such as a link and a frame added to the model.
    """
    matches = _of_name(model, name)
    if not matches:
        raise unknown_name("frame", name, tuple(frame.name for frame in model.frames))
    meant = [index for index in matches if model.frames[index].type not in _JOINT_FRAMES] or matches
    frames = [model.frames[index] for index in meant]
    if not all(_at_one_place(frames[0], frame) for frame in frames[1:]):
        places = " and ".join(
            f"a {_FRAME_KINDS[f.type]} on {model.names[f.parentJoint]!r}" for f in frames
        )
        raise ArgumentError(f"frame {name!r} is ambiguous: {places} have this name; rename one")
    return Frame(meant[0], frames[0].parentJoint, frames[0].placement.copy())


def _of_name(model: pin.Model, name: str) -> list[int]:
    """Return the frames of this name, in Pinocchio's order, but for sensors."""
    try:
        found = [kind for kind in _FRAME_KINDS if model.existFrame(name, kind)]
        return sorted(model.getFrameId(name, kind) for kind in found)
    except ValueError:  # several of one type
        return [k for k, frame in enumerate(model.frames) if _is_meant(frame, name)]


def _is_meant(frame: pin.Frame, name: str) -> bool:
    return bool(frame.name == name and frame.type in _FRAME_KINDS)


def moving_columns(model: pin.Model, frames: Sequence[Frame]) -> list[NDArray[np.intp]]:
    """Return the columns that move each of two frames, but not the other with it."""
    supports = [set(model.supports[frame.joint]) - {0} for frame in frames]
    own = [sorted(mine - theirs) for mine, theirs in zip(supports, supports[::-1], strict=True)]
    starts, counts = model.idx_vs, model.nvs
    return [
        np.array([starts[joint] + k for joint in joints for k in range(counts[joint])], np.intp)
        for joints in own
    ]


def carrying_columns(model: pin.Model, names: Sequence[str]) -> NDArray[np.bool_]:
    """Tell which columns move one of these frames, shape (nv,)."""
    carrying = np.zeros(model.nv, dtype=bool)
    for name in names:
        for k in model.supports[find_frame(model, name).joint]:
            joint = model.joints[k]
            carrying[joint.idx_v : joint.idx_v + joint.nv] = k > 0
    return carrying


def frames_from_the_ends(model: pin.Model, loops: Collection[str]) -> tuple[str, ...]:
    """Return the links, those at the ends of chains first, of these the farthest from the root.

    Frames of loops come last: many are there for these alone.
    """
    holding = set(model.parents.tolist()[1:])
    frames = model.frames.tolist()
    above = {frame.parentFrame for frame in frames}

    def place(index: int) -> tuple[bool, bool, int, bool]:
        name, joint = frames[index].name, frames[index].parentJoint
        return name in loops, joint in holding, -len(model.supports[joint]), index in above

    links = [k for k, frame in enumerate(frames) if frame.type == pin.FrameType.BODY]
    return tuple(frames[k].name for k in sorted(links, key=place))


def _at_one_place(one: pin.Frame, other: pin.Frame) -> bool:
    return bool(one.parentJoint == other.parentJoint and one.placement.isApprox(other.placement))
