"""Joints of several steps as several joints, for formats that have no word for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pinocchio as pin

from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.studies.export.plain_machine import PlainBody, PlainJoint, PlainMachine


def with_single_steps(machine: PlainMachine, whole: Callable[[PlainJoint], bool]) -> PlainMachine:
    """Return the machine with a link without mass between the steps of each joint.

    Parameters
    ----------
    machine : PlainMachine
    whole : callable
        Tells which joints stay as they are.
    """
    taken, bodies, joints = machine.taken, [machine.bodies[0]], list[PlainJoint]()
    numbers = {0: 0}
    for joint in machine.joints:
        parent, place = numbers[joint.parent], joint.placement
        pieces = [joint.steps] if whole(joint) else [(step,) for step in joint.steps]
        for steps in pieces:
            last = steps is pieces[-1]
            name = joint.name if len(pieces) == 1 else steps[0].name
            kind = joint.kind if len(pieces) == 1 else steps[0].kind
            joints.append(PlainJoint(name, kind, parent, len(bodies), place, steps, joint.pitch))
            parent, place = len(bodies), pin.SE3.Identity()
            between = unused_name(f"{name}_link", taken) if not last else ""
            bodies.append(
                machine.bodies[joint.child] if last else PlainBody(between, pin.Inertia.Zero(), {})
            )
        numbers[joint.child] = parent
    return replace(machine, bodies=tuple(bodies), joints=tuple(joints))


def with_screws_geared(machine: PlainMachine) -> PlainMachine:
    """Return the machine with a gear between the turn and the slide of each screw."""
    gears = tuple(
        JointLoop(joints=(joint.steps[0].name, joint.steps[1].name), ratio=joint.pitch)
        for joint in machine.joints
        if joint.kind == "helical"
    )
    return replace(machine, loops=(*machine.loops, *gears))
