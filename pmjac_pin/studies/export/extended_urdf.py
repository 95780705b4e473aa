"""Extended URDF: a URDF of the tree, and a YAML file of what closes it and what drives it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.model.loop_spec import FrameLoop, Loop, PointLoop
from pmjac_pin.studies.export.closable import closable
from pmjac_pin.studies.export.from_home import FromHome
from pmjac_pin.studies.export.names import NO_NAMES, renamed
from pmjac_pin.studies.export.plain_machine import PlainMachine, Written
from pmjac_pin.studies.export.urdf_plus import with_mimics
from pmjac_pin.studies.export.urdf_tree import UrdfTree, motor_joints, prepared, urdf_name

#: The types of `closed_loop`, by the kinds of loops that they are.
EXTENDED_LOOPS: dict[type[Loop], str] = {PointLoop: "3D", FrameLoop: "6D"}


def extended_urdf(machine: PlainMachine, folder: Path) -> Written:
    """Return a machine's <robot>, and the YAML beside it.

    Raises
    ------
    ArgumentError
        Gears in which no order is.
    """
    machine, notes = closable(machine, tuple(EXTENDED_LOOPS))
    machine, renames = _told_apart(prepared(machine))
    machine = replace(machine, motors=motor_joints(machine))
    values = FromHome(machine)
    tree = UrdfTree(machine, folder, "floating", values)
    with_mimics(tree, values, "extended-urdf")
    notes = [*renames, *notes, *values.notes(), *tree.notes()]
    return Written(tree.urdf.robot, machine, tuple(notes), _yaml(machine))


def _told_apart(machine: PlainMachine) -> tuple[PlainMachine, list[str]]:
    """Return the machine with motors whose names are in no other joint's: all are motors then."""
    passive = [urdf_name(joint) for joint in machine.joints if not joint.driven]
    taken, names = machine.taken, {}
    for name in motor_joints(machine):
        wish = name
        while any(wish in other for other in passive):
            wish = f"{wish}_motor"
        if wish != name:
            names[name] = unused_name(wish, taken)
    return renamed(machine, NO_NAMES, names)


def _yaml(machine: PlainMachine) -> str:
    import yaml  # noqa: PLC0415 (with the first file)

    closed = [loop for loop in machine.loops if isinstance(loop, LoopBetweenFrames)]
    balls = [step.name for step in machine.steps if step.kind == "ball"]
    contents = {
        "closed_loop": [list(loop.frames) for loop in closed],
        "type": [
            next(tag for kind, tag in EXTENDED_LOOPS.items() if isinstance(loop, kind))
            for loop in closed
        ],
        "name_mot": list(machine.motors),
        "joint_name": balls,
        "joint_type": ["SPHERICAL"] * len(balls),
    }
    return str(yaml.safe_dump(contents, sort_keys=False, allow_unicode=True))
