"""Hubs: a loop of any kind as the joints that keep it closed, and a weld behind them.

The joints move a link without mass on the loop's first body, the hub, and that is welded to the
second. What the loop allows and forbids stays the same, exactly; the hub's motions are new.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.model.joint_kind import JointKind
from pmjac_pin.model.linkage import Edge
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.model.loop_joint import Anchor, loop_joint
from pmjac_pin.model.loop_spec import FrameLoop
from pmjac_pin.studies.export.plain_machine import (
    PlainBody,
    PlainJoint,
    PlainMachine,
    PlainStep,
    StepKind,
)
from pmjac_pin.studies.export.steps import step_values, turns_freely
from pmjac_pin.values.arrays import Array

_Move = tuple[StepKind, Array, str]


def with_hub(machine: PlainMachine, loop: LoopBetweenFrames) -> PlainMachine:
    """Return the machine with a hub, and a frame loop in a loop's stead."""
    first, second = (machine.frames[name] for name in loop.frames)
    label, taken = "-".join(loop.frames), machine.taken
    count = len(loop.form({}).steps)
    numbers = [len(machine.bodies) + k for k in range(count)]
    held = loop_joint(
        loop,
        {},
        Anchor(*first),
        Anchor(numbers[-1], pin.SE3.Identity()),
        name=label,
        link=numbers[0],
    )
    joints, carried = [], pin.SE3.Identity()
    for edge in held.edges:
        joints.append(_hub_joint(edge, carried, taken))
        carried = edge.after
    names = [unused_name(f"{label}_hub", taken) for _ in numbers]
    end = unused_name(f"{label}_hub_end", taken)
    bodies = [PlainBody(name, pin.Inertia.Zero(), {}) for name in names]
    bodies[-1] = replace(bodies[-1], frames={end: carried})
    poses = {}
    for pose, values in machine.poses.items():
        placed = dict(enumerate(machine.placements(pose)))
        placed[numbers[-1]] = placed[second[0]] * second[1]
        entries = held.entries(placed)
        new = dict(values)
        for joint, edge in zip(joints, held.edges, strict=True):
            new |= step_values(joint.steps, edge.kind, entries[edge.name], edge.pitch)
        poses[pose] = new
    closed = FrameLoop(frames=(end, loop.frames[1]))
    return replace(
        machine,
        bodies=(*machine.bodies, *bodies),
        joints=(*machine.joints, *joints),
        loops=tuple(closed if one is loop else one for one in machine.loops),
        poses=poses,
    )


def _hub_joint(edge: Edge, carried: pin.SE3, taken: set[str]) -> PlainJoint:
    """Return a joint whose body's frame is its own, moved; `carried` is what that is turned by."""
    name = unused_name(edge.name, taken)
    steps = tuple(_hub_steps(name, edge.kind))
    place = carried * edge.before
    return PlainJoint(name, edge.kind.name, edge.parent, edge.child, place, steps, edge.pitch)


def _hub_steps(name: str, kind: JointKind) -> Sequence[PlainStep]:
    """Return the steps of a joint along and about the axes of its own frame."""
    unit = np.eye(3)
    slides: list[_Move] = [("slide", unit[k], "xyz"[k]) for k in kind.along]
    turns: list[_Move] = [("hinge", unit[k], f"r{'xyz'[k]}") for k in kind.about]
    moves = [*slides, *([("ball", np.zeros(3), "r")] if turns_freely(kind) else turns)]
    if len(moves) == 1:
        return [PlainStep(name, moves[0][0], moves[0][1])]
    return [PlainStep(f"{name}.{letter}", motion, axis) for motion, axis, letter in moves]
