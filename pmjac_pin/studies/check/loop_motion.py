"""The motion of each loop at one q: the joints along it, and the group that they move in."""

from __future__ import annotations

from dataclasses import dataclass

import pinocchio as pin

from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.loop_spec import JointLoop, Loop
from pmjac_pin.rates.screw_group import generated_algebra, group_name
from pmjac_pin.studies.check.machine import CheckedMachine
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True)
class LoopMotion:
    """What the tree's joints along a loop can do.

    Attributes
    ----------
    joints : tuple of str
        The joints of the tree between the loop's two ends.
    group : str or None
        Of their relative displacements: "planar", "spherical", "spatial", ...; None where a loop
        couples joint values.
    rows : int
        The loop's independent rows for displacements in that group.
    """

    joints: tuple[str, ...]
    group: str | None
    rows: int


def loop_motions(machine: CheckedMachine, q: Array) -> tuple[LoopMotion, ...]:
    """Return the motion of every loop; q need not be closed."""
    model = machine.kinematics.model
    data = model.createData()
    twists = pin.computeJointJacobians(model, data, q).reshape(6, -1)
    return tuple(
        _coupled_motion(loop)
        if isinstance(loop, JointLoop)
        else _motion_between(machine, data, twists, k, loop)
        for k, loop in enumerate(machine.spec.loops)
    )


def _coupled_motion(loop: JointLoop) -> LoopMotion:
    return LoopMotion(loop.joints, None, 1)


def _motion_between(
    machine: CheckedMachine, data: pin.Data, twists: Array, index: int, loop: Loop
) -> LoopMotion:
    model, partition = machine.kinematics.model, machine.problem.partition
    first, second = (find_frame(model, name) for name in loop.ends)
    one, other = (set(model.supports[end.joint]) for end in (first, second))
    joints = sorted(one ^ other)
    columns = machine.coordinates.columns(model.names[joint] for joint in joints)
    point = (data.oMi[first.joint] * first.placement).translation
    relative = twists[:, columns].copy()
    relative[:3] -= pin.skew(point) @ relative[3:]  # at the first frame's origin
    relative[:3] /= partition.length
    tolerance = partition.rank_tolerance
    algebra = generated_algebra(relative, tolerance)
    metres = algebra.copy()
    metres[:3] *= partition.length
    rows = machine.kinematics.loops.rows_by_twists(model, data, index, metres)
    scaled = rows * partition.row_scale[machine.kinematics.loops.slices[index], None]
    scaled /= partition.length
    names = tuple(model.names[joint] for joint in joints)
    return LoopMotion(names, group_name(algebra, tolerance), partition.factorise(scaled, 1.0).rank)
