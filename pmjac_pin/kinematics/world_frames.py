"""Frames in the world over number types: their axes, places and Jacobians, as arrays.

Components first, then whatever poses there are.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.kinematics.loops import Loops
from pmjac_pin.kinematics.places import through
from pmjac_pin.kinematics.tree import Poses
from pmjac_pin.model.frames import Frame


class FrameMotion(NamedTuple):
    """Where a frame is and how it moves, in world axes.

    Attributes
    ----------
    rotation, position : number, (3, 3, b) and (3, b)
    jacobian : number, (6, nv, b)
    """

    rotation: Numbers
    position: Numbers
    jacobian: Numbers


def frame_motion(poses: Poses, frame: Frame, nv: int, count: int) -> FrameMotion:
    """Return where a frame is in so many poses, and how it moves by all freedoms."""
    seen = poses.twisted(0, frame)
    origin, axes = seen.origin(), seen.carried(np.eye(3)).value
    jacobian = np.full((6, nv, count), 0.0, dtype=np.result_type(origin.value, axes))
    if origin.columns:
        jacobian[:3, origin.columns] = origin.rates
    for one in poses.freedoms(0, frame.joint):
        if one.origin is not None:
            jacobian[3:, one.column] = one.axis[:, 0]
    rotation = np.broadcast_to(axes[:, :, 0], (3, 3, count))
    return FrameMotion(rotation, np.broadcast_to(origin.value[:, 0], (3, count)), jacobian)


def vectors_in_bodies(loops: Loops, poses: Poses) -> Iterator[tuple[slice, Numbers]]:
    """Yield the rows that are a vector's components in a moving body's axes, and these axes.

    As columns, shape (3, 3, b).
    """
    for pair in loops.pairs:
        if pair.base and any(block.vector for _, block in pair.blocks):
            axes = _axes_of(poses, pair.base)
            yield from ((rows, axes) for rows, block in pair.blocks if block.vector)


def _axes_of(poses: Poses, body: int) -> Numbers:
    pose, _ = poses.body(0, body)
    *axes, _ = through(poses.algebra, pose, poses.tree.links[body].after)
    return np.stack(np.broadcast_arrays(*(axis[:, 0] for axis in axes)), axis=1)
