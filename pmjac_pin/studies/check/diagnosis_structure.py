"""What a mechanism is made of, for its diagnosis: bodies, degrees of freedom, loops and counts.

None of this needs closed loops.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from pmjac_pin.closing.closure_problem import LoopEquations
from pmjac_pin.closing.damped_closure import assemble, motor_weights
from pmjac_pin.closing.held_motors import shaken
from pmjac_pin.closing.machine_size import Size
from pmjac_pin.closing.nearby_poses import FARTHEST
from pmjac_pin.closing.pose_assembly import FOLDS
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.joint_kinds import kind_of
from pmjac_pin.model.loop_spec import JointLoop, Loop
from pmjac_pin.rates.redundancy import LoopRank
from pmjac_pin.studies.check.diagnosis_parts import BodyEntry, FreedomEntry, LoopEntry, Mobility
from pmjac_pin.studies.check.loop_motion import LoopMotion, loop_motions
from pmjac_pin.studies.check.machine import CheckedMachine
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class Structure:
    """A mechanism, assembled or not, and how its loops move.

    Attributes
    ----------
    machine : Machine
    home : ndarray, shape (nq,)
        Its home pose; the file's where that does not assemble.
    given : ndarray, shape (nq,)
        The file's home pose.
    motions : tuple of LoopMotion
    """

    machine: CheckedMachine
    home: Array
    given: Array
    motions: tuple[LoopMotion, ...]

    @classmethod
    def of(cls, machine: CheckedMachine, home: Array) -> Structure:
        """Look at the loops in this home pose."""
        given = machine.coordinates.q(machine.spec.poses["home"])
        return cls(machine, home, given, loop_motions(machine, home))

    @property
    def loop_names(self) -> tuple[str, ...]:
        """What each loop joins."""
        return tuple("-".join(loop.ends) for loop in self.machine.spec.loops)

    def names_along(self, joint: str) -> tuple[str, ...]:
        """Return the loops that a joint is part of."""
        named = zip(self.loop_names, self.motions, strict=True)
        return tuple(name for name, motion in named if joint in motion.joints)


def bodies(structure: Structure) -> tuple[BodyEntry, ...]:
    """Return the ground and the body that each joint carries."""
    model, spec = structure.machine.kinematics.model, structure.machine.spec
    on: dict[int, list[str]] = {}
    for name, loop in zip(structure.loop_names, spec.loops, strict=True):
        for body in _end_bodies(model, loop):
            on.setdefault(body, []).append(name)
    tools = {find_frame(model, name).joint for name in spec.tool.names}
    names = body_names(model)
    return tuple(
        BodyEntry(
            names[body],
            _links(model, body),
            model.names[body] if body else None,
            tuple(on.get(body, ())),
            body in tools,
        )
        for body in range(model.njoints)
    )


def body_names(model: pin.Model) -> tuple[str, ...]:
    """Return a name for what each of Pinocchio's joints carries: its first link."""
    return tuple(
        (*_links(model, body), model.names[body] if body else "ground")[0]
        for body in range(model.njoints)
    )


def freedoms(structure: Structure, moved: Mapping[str, float] | None) -> tuple[FreedomEntry, ...]:
    """Return every degree of freedom, motors first; with how far each moved where that is known."""
    machine, model = structure.machine, structure.machine.kinematics.model
    coordinates, partition = machine.coordinates, machine.problem.partition
    given, home = coordinates.values(structure.given), coordinates.values(structure.home)
    joints = {coordinates.columns([name])[k]: name
              for name in coordinates.names
              for k in range(coordinates.degrees_of_freedom(name))}  # fmt: skip
    return tuple(
        FreedomEntry(
            name=name,
            joint=joints[column],
            kind=_joint_kind(model, joints[column]),
            role="actuated" if column in partition.actuated else "passive",
            unit="rad" if coordinates.rotational[column] else "m",
            lower=_finite(coordinates.lower[column]),
            upper=_finite(coordinates.upper[column]),
            given=float(given[column]),
            home=None if moved is None else float(home[column]),
            moved=None if moved is None else moved[name],
            loops=structure.names_along(joints[column]),
        )
        for name, column in partition.columns.items()
    )


def loops(
    structure: Structure, ranks: Sequence[LoopRank] | None, best: Array | None = None
) -> tuple[LoopEntry, ...]:
    """Return every loop; without ranks, home does not assemble, and each is tried alone.

    `best` is then the pose of the smallest gap that was found, if any.
    """
    machine, spec = structure.machine, structure.machine.spec
    system, gaps = machine.kinematics.loops, loop_gaps(machine, structure.given)
    turns = machine.coordinates.rotational
    sizes = Size(machine.kinematics, spec, turns, structure.home).arms
    return tuple(
        LoopEntry(
            name=name,
            kind=str(loop.__struct_config__.tag),
            joints=motion.joints,
            equations=system.row_names[rows],
            units=system.row_units[rows],
            group=motion.group,
            group_rows=motion.rows,
            rank=ranks[k].rank if ranks else None,
            needed=ranks[k].needed if ranks else None,
            size=sizes[k],
            gap_given=gaps[k],
            gap_alone=None if ranks else _gap_alone(structure, rows, best),
        )
        for k, (name, loop, motion, rows) in enumerate(
            zip(structure.loop_names, spec.loops, structure.motions, system.slices, strict=True)
        )
    )


def mobility(structure: Structure, rank: int | None) -> Mobility:
    """Return the mobility, by rank where that is known, and as Grübler-Kutzbach count it."""
    kinematics, reach = structure.machine.kinematics, structure.machine.problem.partition.reach
    freedom, rows = kinematics.model.nv, len(kinematics.loops.row_names)
    in_groups = sum(motion.rows for motion in structure.motions)
    return Mobility(
        freedoms=freedom,
        rows=rows,
        gruebler=freedom - rows,
        group_rows=in_groups,
        gruebler_in_groups=freedom - in_groups,
        rank=rank,
        mobility=None if rank is None else freedom - rank,
        reach=reach if 0.0 < reach < FARTHEST else None,
    )


def loop_gaps(machine: CheckedMachine, q: Array) -> tuple[float, ...]:
    """Return how open each loop is at q, m."""
    partition, slices = machine.problem.partition, machine.kinematics.loops.slices
    gaps = machine.problem.evaluate(q)[0] * partition.row_scale
    sizes = np.array(partition.loop_sizes) / partition.length
    return tuple(
        float(size * np.linalg.norm(gaps[rows])) for rows, size in zip(slices, sizes, strict=True)
    )


def _gap_alone(structure: Structure, rows: slice, best: Array | None) -> float:
    """Return the smallest gap that one loop reaches, all joints free and the others left open."""
    problem, least = structure.machine.problem, math.inf
    partition = replace(problem.partition, row_scale=problem.partition.row_scale[rows])
    alone = replace(problem, loops=_OneLoop(problem.loops, rows), partition=partition)
    weights, room = motor_weights(problem, 1.0), structure.machine.coordinates.room
    known = [structure.home] if best is None else [structure.home, best]
    for start in (*known, *shaken(problem, structure.home, FOLDS, weights)):
        least = min(least, assemble(alone, start, weights, room=room).gap)
        if least <= problem.tolerance:
            break
    return least


@dataclass(frozen=True)
class _OneLoop:
    """The equations of one loop of many: their rows."""

    loops: LoopEquations
    rows: slice

    def closure(self, q: Array) -> tuple[Array, Array]:
        residual, jacobian = self.loops.closure(q)
        return residual[self.rows], jacobian[self.rows]

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        residual, jacobian = self.loops.evaluate(q)
        return residual[self.rows], jacobian[self.rows]


def _end_bodies(model: pin.Model, loop: Loop) -> set[int]:
    if isinstance(loop, JointLoop):
        return set()
    return {find_frame(model, name).joint for name in loop.frames}


def _links(model: pin.Model, body: int) -> tuple[str, ...]:
    return tuple(
        frame.name
        for frame in model.frames
        if frame.parentJoint == body and frame.type == pin.FrameType.BODY
    )


def _joint_kind(model: pin.Model, name: str) -> str:
    joint = model.joints[model.getJointId(name)]
    if (kind := kind_of(joint)) is None:
        return str(joint.shortname().removeprefix("JointModel"))
    return kind.title or kind.name


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
