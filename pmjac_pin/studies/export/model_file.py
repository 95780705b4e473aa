"""Our own model file of a mechanism: as it was read, or of a Pinocchio model and a URDF for it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import msgspec

from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.spec import JointValue, MechanismSpec
from pmjac_pin.studies.convert import closed_poses
from pmjac_pin.studies.export.from_home import FromZero
from pmjac_pin.studies.export.plain_machine import PlainJoint, PlainMachine
from pmjac_pin.studies.export.single_steps import with_single_steps
from pmjac_pin.studies.export.urdf_tree import UrdfTree, motor_joints


def as_read(mechanism: Mechanism) -> tuple[MechanismSpec, Urdf] | None:
    """Return what a file said of a mechanism, at its parameters' values; None without a file."""
    if (blueprint := mechanism.blueprint) is None:
        return None
    spec, values = mechanism.spec, mechanism.parameters
    parameters = {
        name: msgspec.structs.replace(parameter, default=values[name])
        for name, parameter in spec.parameters.items()
    }
    urdf = blueprint.urdf.moved(spec.moves(values))
    poses = closed_poses(mechanism)
    return msgspec.structs.replace(spec, parameters=parameters, poses=poses), urdf


def as_built(mechanism: Mechanism, machine: PlainMachine, path: Path) -> tuple[MechanismSpec, Urdf]:
    """Return a model file's contents and a URDF for a machine.

    Parameters
    ----------
    mechanism : Mechanism
    machine : PlainMachine
        The same, taken apart.
    path : Path
        Where the URDF will be.
    """
    machine = with_single_steps(machine, _in_one_joint)
    tree = UrdfTree(machine, path.parent, "floating", FromZero())
    names = {joint.name for joint in machine.joints}
    passive = mechanism.spec.passive
    spec = msgspec.structs.replace(
        mechanism.spec,
        actuated=motor_joints(machine),
        passive=passive if passive and set(passive) <= names else None,
        loops=machine.loops,
        spherical=tuple(step.name for step in machine.steps if step.kind == "ball"),
        helical={joint.name: joint.pitch for joint in machine.joints if joint.kind == "helical"},
        armature={step.name: step.armature for step in machine.steps if step.armature},
        locked={},
        parameters={},
        poses={pose: _pose_values(machine, values) for pose, values in machine.poses.items()},
    )
    return spec, Urdf.of(tree.urdf.robot, str(path))


def _in_one_joint(joint: PlainJoint) -> bool:
    return joint.kind in ("planar", "helical")


def _pose_values(
    machine: PlainMachine, values: Mapping[str, tuple[float, ...]]
) -> dict[str, JointValue]:
    """Return joint values as a model file has them: of a screw the turn alone."""
    found: dict[str, JointValue] = {}
    for joint in machine.joints:
        steps = joint.steps[:1] if joint.kind == "helical" else joint.steps
        numbers = tuple(number for step in steps for number in values[step.name])
        found[joint.name] = numbers[0] if len(numbers) == 1 else numbers
    return found
