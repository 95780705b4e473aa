"""Loops in the kinds that a format knows; those of others by rods, points and hubs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin

from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.model.loop_spec import DistanceLoop, Loop, PointLoop, RevoluteLoop
from pmjac_pin.studies.export.hubs import with_hub
from pmjac_pin.studies.export.plain_machine import PlainMachine
from pmjac_pin.studies.export.rods import with_rod
from pmjac_pin.values.arrays import Array


def closable(
    machine: PlainMachine, native: tuple[type[Loop], ...]
) -> tuple[PlainMachine, list[str]]:
    """Return the machine with loops of these kinds and gears alone, and notes on what was added.

    Each loop that is not of them becomes something that allows and forbids the same motions.
    """
    notes = []
    for loop in machine.loops:
        if isinstance(loop, native) or not isinstance(loop, LoopBetweenFrames):
            continue
        between = (
            f"the {loop.__struct_config__.tag} loop of {loop.frames[0]!r} and {loop.frames[1]!r}"
        )
        if isinstance(loop, DistanceLoop):
            machine = with_rod(machine, loop)
            notes.append(f"{between} is a rod in the file, a link between two hinges and a ball")
        elif isinstance(loop, RevoluteLoop):
            machine = with_two_points(machine, loop)
            notes.append(f"{between} is two points on its axis in the file")
        else:
            machine = with_hub(machine, loop)
            notes.append(f"{between} is a link that moves so, welded, in the file")
    return machine, notes


def with_point_on_axis(machine: PlainMachine, frame: str, axis: Array) -> tuple[PlainMachine, str]:
    """Return the machine with a frame on an axis through another, as far away as it is large."""
    body, place = machine.frames[frame]
    name = unused_name(f"{frame}_on_axis", machine.taken)
    end = place * pin.SE3(np.eye(3), machine.length * axis)
    return machine.with_frame(name, body, end), name


def with_two_points(machine: PlainMachine, loop: RevoluteLoop) -> PlainMachine:
    """Return the machine with two points on a hinge's axis, as far apart as it is large."""
    machine, one = with_point_on_axis(machine, loop.frames[0], np.array(loop.axis))
    machine, other = with_point_on_axis(machine, loop.frames[1], np.array(loop.axis))
    points = (PointLoop(frames=loop.frames), PointLoop(frames=(one, other)))
    loops = (points if one is loop else (one,) for one in machine.loops)
    return replace(machine, loops=tuple(one for some in loops for one in some))
