"""Rods: a distance loop as a link between a cross and a ball, for formats that know no distances.

The cross does not let the link spin, so that no motion is added. It is exact until the rod stands
along the cross's first axis, a quarter of a turn from home.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pinocchio as pin

from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.model.loop_spec import DistanceLoop, PointLoop
from pmjac_pin.studies.export.plain_machine import PlainBody, PlainJoint, PlainMachine, PlainStep
from pmjac_pin.values.arrays import Array

_X, _Y, _Z = np.eye(3)


def with_rod(machine: PlainMachine, loop: DistanceLoop) -> PlainMachine:
    """Return the machine with a link for a rod, and a point loop at its far end."""
    label, taken = "-".join(loop.frames), machine.taken
    body, place = machine.frames[loop.frames[0]]
    along = pin.Quaternion.FromTwoVectors(_Z, _rod_direction(machine, loop, "home")).matrix()
    names = [unused_name(f"{label}.{letter}", taken) for letter in "xy"]
    steps = (PlainStep(names[0], "hinge", _X), PlainStep(names[1], "hinge", _Y))
    rod, end = unused_name(f"{label}_rod", taken), unused_name(f"{label}_rod_end", taken)
    far = pin.SE3(np.eye(3), loop.resolved_length({}) * _Z)
    joint = PlainJoint(
        unused_name(label, taken),
        "universal",
        body,
        len(machine.bodies),
        place * pin.SE3(along, np.zeros(3)),
        steps,
    )
    poses = {}
    for pose, values in machine.poses.items():
        x, y, z = along.T @ _rod_direction(machine, loop, pose)
        turned = {names[0]: (math.atan2(-y, z),), names[1]: (math.asin(np.clip(x, -1.0, 1.0)),)}
        poses[pose] = {**values, **turned}
    closed = PointLoop(frames=(end, loop.frames[1]))
    return replace(
        machine,
        bodies=(*machine.bodies, PlainBody(rod, pin.Inertia.Zero(), {end: far})),
        joints=(*machine.joints, joint),
        loops=tuple(closed if one is loop else one for one in machine.loops),
        poses=poses,
    )


def _rod_direction(machine: PlainMachine, loop: DistanceLoop, pose: str) -> Array:
    """Return the direction from a rod's first point to its second, in the first frame."""
    placed, ends = machine.placements(pose), (machine.frames[name] for name in loop.frames)
    first, second = (placed[body] * place for body, place in ends)
    way = first.actInv(second.translation)
    return np.asarray(way / np.linalg.norm(way))
