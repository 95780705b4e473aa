"""Mirror images: modes that the reflection in the plane of the base makes of each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import Frame, find_frame
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.values.arrays import Array

_MIRRORED_PLACE = 1e-5  # of the characteristic length


def mirror_images(mechanism: Mechanism, modes: Sequence[Configuration]) -> tuple[int | None, ...]:
    """Return for each mode the index of its mirror image, None where it has none.

    The plane is that of the points where the base carries joints and loops; without one, when
    they lie on a line or not in a plane, there are no mirror images.
    """
    none = (None,) * len(modes)
    length = mechanism.problem.partition.length
    plane = _plane(_base_points(mechanism), length)
    if plane is None or not modes or not _mirrored_points(mechanism, modes[0]).size:
        return none
    middle, normal = plane
    points = np.array([_mirrored_points(mechanism, mode) for mode in modes])
    heights = (points - middle) @ normal
    reflected = points - 2.0 * heights[:, :, None] * normal
    found: list[int | None] = []
    for index in range(len(modes)):
        apart = np.abs(points - reflected[index]).max(axis=(1, 2))
        apart[index] = np.inf
        nearest = int(np.argmin(apart))
        found.append(nearest if apart[nearest] <= _MIRRORED_PLACE * length else None)
    return tuple(found)


def _base_points(mechanism: Mechanism) -> Array:
    model = mechanism.kinematics.model
    roots = [
        model.jointPlacements[joint].translation
        for joint in range(1, model.njoints)
        if model.parents[joint] == 0 and model.joints[joint].nv == 1
    ]
    anchors = [one.placement.translation for one in _anchors(mechanism) if one.joint == 0]
    return np.array([*roots, *anchors]).reshape(-1, 3)


def _anchors(mechanism: Mechanism) -> list[Frame]:
    """Return the frames that loops join."""
    loops = (loop for loop in mechanism.spec.loops if not isinstance(loop, JointLoop))
    return [find_frame(mechanism.kinematics.model, name) for loop in loops for name in loop.frames]


def _plane(points: Array, length: float) -> tuple[Array, Array] | None:
    """Return the plane of the points as a point and a normal, if they span just one."""
    if len(points) < 3:
        return None
    middle = points.mean(axis=0)
    factors = factorise(points - middle, length, _MIRRORED_PLACE)
    return (middle, factors.right[2]) if factors.rank == 2 else None


def _mirrored_points(mechanism: Mechanism, mode: Configuration) -> Array:
    """Return the tool's origin and all loop anchors, shape (k, 3)."""
    placed = mechanism.kinematics.placed(mode.q).oMi
    anchors = [placed[one.joint].act(one.placement.translation) for one in _anchors(mechanism)]
    tool = [] if mechanism.spec.tool.is_none else [mode.tool_pose().translation]
    return np.array([*tool, *anchors]).reshape(-1, 3)
