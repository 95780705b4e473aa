"""Bodies called as their links, where a link's frame is turned against its joint's."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import pinocchio as pin

from pmjac_pin.studies.export.plain_machine import PlainBody, PlainJoint, PlainMachine


def with_links_for_bodies(machine: PlainMachine, links: Collection[str]) -> PlainMachine:
    """Return the machine, each body that is not called as a link in the frame of one on it.

    That of one at its joint, whose steps can be seen from there: hinges and slides, one by one.
    """
    for number, joint in enumerate(machine.joints, start=1):
        body = machine.bodies[number]
        if body.name in links or joint.kind == "planar" or not all(s.single for s in joint.steps):
            continue
        for name, place in body.frames.items():
            if name in links and not place.translation.any():
                machine = _turned(machine, number, name)
                break
    return machine


def _turned(machine: PlainMachine, number: int, name: str) -> PlainMachine:
    turn = machine.bodies[number].frames[name]
    bodies = list(machine.bodies)
    bodies[number] = _seen_body(bodies[number], name, turn)
    joints = (_seen_joint(joint, number, turn) for joint in machine.joints)
    return replace(machine, bodies=tuple(bodies), joints=tuple(joints))


def _seen_body(body: PlainBody, name: str, turn: pin.SE3) -> PlainBody:
    frames = {other: turn.actInv(place) for other, place in body.frames.items() if other != name}
    shapes = (replace(shape, place=turn.actInv(shape.place)) for shape in body.shapes)
    return PlainBody(name, turn.actInv(body.inertia), frames, tuple(shapes))


def _seen_joint(joint: PlainJoint, number: int, turn: pin.SE3) -> PlainJoint:
    if joint.parent == number:
        return replace(joint, placement=turn.actInv(joint.placement))
    if joint.child != number:
        return joint
    steps = tuple(step.seen_from(turn) for step in joint.steps)
    return replace(joint, placement=joint.placement * turn, steps=steps)
