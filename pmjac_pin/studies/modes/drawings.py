"""Drawings: where the pieces of a URDF's visuals are, as far as that can be seen."""

from __future__ import annotations

from typing import assert_never

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import UnknownNameError
from pmjac_pin.files.shapes import Box, Cone, Cylinder, Shape, Sphere, Text
from pmjac_pin.files.visuals import read_visuals
from pmjac_pin.kinematics.many import WorldPoses
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import Frame, find_frame
from pmjac_pin.values.arrays import Array

_PIECE_ENTRIES = 31  # of a piece: which sort it is of, its middle, and up to three lines


class Drawings:
    """The drawn pieces of the bodies that move.

    A box may be turned by half a turn about its own axes, a cylinder about its own axis and end
    for end, a ball in any way. What else there is, such as a mesh, is not looked into: it is drawn
    in its link's whole pose.

    Parameters
    ----------
    mechanism : Mechanism
    model : pin.Model
        The mechanism's own, or what a search leaves of it.
    length : float
        Characteristic length, m.
    """

    def __init__(self, mechanism: Mechanism, model: pin.Model, length: float) -> None:
        self._length = length
        self._pieces: list[tuple[int, int, Shape | None, Array]] = []
        sorts: dict[object, int] = {}
        for visual in read_visuals(mechanism.urdf) if mechanism.urdf else []:
            frame = _link_frame(model, visual.link)
            if frame is None or frame.joint == 0:
                continue
            place = frame.placement.homogeneous
            for shape, transform in visual.pieces:
                sizes = tuple(np.linalg.norm(transform[:3, :3], axis=0).round(12).tolist())
                sort = sorts.setdefault((type(shape), sizes, visual.colour), len(sorts))
                self._pieces.append((frame.joint, sort, shape, place @ transform))
            if not visual.pieces:
                sort = sorts.setdefault((visual.link, visual.name), len(sorts))
                self._pieces.append((frame.joint, sort, None, place))

    def __call__(self, poses: WorldPoses) -> Array:
        """Return what each piece looks like in each pose, shape (b, pieces, entries)."""
        looks = np.zeros((poses.positions.shape[1], len(self._pieces), _PIECE_ENTRIES))
        for index, (body, sort, shape, place) in enumerate(self._pieces):
            sizes = np.linalg.norm(place[:3, :3], axis=0)
            axes = poses.rotations[body] @ (place[:3, :3] / sizes)
            middle = poses.positions[body] + poses.rotations[body] @ place[:3, 3]
            unit = self._length if shape is None else min(self._length, float(sizes.max()))
            look = np.hstack([middle / unit, _turned_looks(shape, axes)])
            looks[:, index, 0] = sort
            looks[:, index, 1 : 1 + look.shape[1]] = look
        return looks


def _turned_looks(shape: Shape | None, axes: Array) -> Array:
    """Return what is seen of how a shape with these axes (b, 3, 3) is turned, shape (b, k)."""
    match shape:
        case None | Cone() | Text():
            return axes.reshape(-1, 9)
        case Box():
            seen = axes
        case Cylinder():
            seen = axes[:, :, 2:]
        case Sphere():
            seen = axes[:, :, :0]
        case _:
            assert_never(shape)
    lines = seen.swapaxes(1, 2)
    return np.asarray(
        (lines[..., None] * lines[..., None, :]).reshape(len(axes), 9 * lines.shape[1])
    )


def _link_frame(model: pin.Model, link: str) -> Frame | None:
    """Return a link's frame, None where a search does without it."""
    try:
        return find_frame(model, link)
    except UnknownNameError:
        return None
