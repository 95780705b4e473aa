"""Names: what a format keeps for itself, or cannot hold, is called otherwise or refused."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import pinocchio as pin
from msgspec.structs import replace as replaced

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.model.loop_spec import JointLoop, Loop
from pmjac_pin.studies.export.plain_machine import PlainBody, PlainJoint, PlainMachine

# What XML 1.0 holds (W3C, "Extensible Markup Language", production 2).
_XML = re.compile("[\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]+")

NO_NAMES: Mapping[str, str] = MappingProxyType({})


def check_names(machine: PlainMachine) -> None:
    """Refuse names that no XML holds.

    Raises
    ------
    ArgumentError
    """
    for name in sorted(machine.taken):
        if not _XML.fullmatch(name):
            wrong = "is empty" if not name else "has a character that no XML file holds"
            raise ArgumentError(f"the name {quoted(name)} {wrong}; rename it in the model")


def with_root(machine: PlainMachine, root: str) -> tuple[PlainMachine, list[str]]:
    """Return the machine with its world called so, and its own name a frame there; and notes."""
    own = machine.bodies[0].name
    if own == root:
        return machine, []
    clash = {root: unused_name(root, machine.taken)} if root in machine.frames else {}
    machine, notes = renamed(machine, clash)
    world = machine.bodies[0]
    frames = {own: pin.SE3.Identity(), **world.frames}
    bodies = (replace(world, name=root, frames=frames), *machine.bodies[1:])
    return replace(machine, bodies=bodies), notes


def renamed(
    machine: PlainMachine, frames: Mapping[str, str], joints: Mapping[str, str] = NO_NAMES
) -> tuple[PlainMachine, list[str]]:
    """Return the machine with frames (bodies' own too) and joints by other names; and notes."""

    def of_body(body: PlainBody) -> PlainBody:
        others = {frames.get(name, name): place for name, place in body.frames.items()}
        return replace(body, name=frames.get(body.name, body.name), frames=others)

    def of_joint(joint: PlainJoint) -> PlainJoint:
        steps = tuple(replace(one, name=joints.get(one.name, one.name)) for one in joint.steps)
        return replace(joint, name=joints.get(joint.name, joint.name), steps=steps)

    def of_loop(loop: Loop) -> Loop:
        known = joints if isinstance(loop, JointLoop) else frames
        first, second = (known.get(name, name) for name in loop.ends)
        if isinstance(loop, JointLoop):
            return replaced(loop, joints=(first, second))
        return replaced(loop, frames=(first, second))

    changed = replace(
        machine,
        bodies=tuple(map(of_body, machine.bodies)),
        joints=tuple(map(of_joint, machine.joints)),
        loops=tuple(map(of_loop, machine.loops)),
        poses={
            pose: {joints.get(step, step): value for step, value in values.items()}
            for pose, values in machine.poses.items()
        },
        motors=tuple(joints.get(name, name) for name in machine.motors),
        tool=tuple(frames.get(name, name) for name in machine.tool),
    )
    told = (
        (what, old, new)
        for what, names in (("frame", frames), ("joint", joints))
        for old, new in names.items()
    )
    return changed, [
        f"{what} {quoted(old)} is called {quoted(new)} in the file" for what, old, new in told
    ]
