"""From a Pinocchio model and a spec to the parts of a Mechanism: the loops assembled at home."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.closure import ClosureProblem, assemble
from pmjac_pin.coordinates import JointCoordinates
from pmjac_pin.errors import ArgumentError, ClosureError, unknown_name
from pmjac_pin.factorisation import factorise, norm
from pmjac_pin.kinematics import Kinematics
from pmjac_pin.loops import LoopSystem
from pmjac_pin.partition import Partition
from pmjac_pin.spec import MechanismSpec
from pmjac_pin.tool import tool_kinematics

Array = NDArray[np.float64]

# How easily the motors move, beside the passive joints, to assemble a pose: not at all, then
# reluctantly, then like the others.
_MOTOR_WEIGHTS = (0.0, 0.1, 1.0)
_PROBES = 2  # times three closed poses near home at which the generic ranks are looked for
_PROBE_DISTANCE = 0.05  # rad, or share of the characteristic length


@dataclass(frozen=True, slots=True, eq=False)
class Parts:
    """What a Mechanism is made of; nothing of it ever changes."""

    model: pin.Model
    spec: MechanismSpec
    values: Mapping[str, float]
    coordinates: JointCoordinates
    kinematics: Kinematics
    problem: ClosureProblem
    home_q: Array


def build_parts(model: pin.Model, spec: MechanismSpec, values: Mapping[str, float]) -> Parts:
    """Resolve all names, assemble the home pose and find the generic ranks there.

    Raises
    ------
    UnknownNameError
        A joint or frame that the model does not have.
    ArgumentError
        The actuated and passive joints are not a partition of the joints that move.
    ClosureError
        The home pose does not assemble.
    """
    coordinates = JointCoordinates(model)
    kinematics = Kinematics(
        model, LoopSystem(model, spec.loops, values), tool_kinematics(model, spec.tool)
    )
    start = coordinates.q(spec.poses["home"])
    partition = _partition(spec, coordinates, kinematics.loops, _length(model, start))
    problem = _problem(kinematics, partition)
    home_q = assemble_pose(problem, kinematics.loops, start, f"{spec.name}: the pose 'home'")
    nearby = [home_q, *_nearby(problem, home_q)]
    snapshots = [kinematics.snapshot(q) for q in nearby]
    ranked = partition.with_ranks_of(
        [(snapshot.constraint_jacobian, snapshot.tool_jacobian) for snapshot in snapshots]
    )
    return Parts(model, spec, values, coordinates, kinematics, _problem(kinematics, ranked), home_q)


def assemble_pose(problem: ClosureProblem, loops: LoopSystem, q: Array, what: str) -> Array:
    """Close the loops near q: the motors stay where they are, or move as little as it takes.

    Raises
    ------
    ClosureError
        With the smallest gap found and the loop that stays open.
    """
    found = []
    for motor_weight in _MOTOR_WEIGHTS:
        weights = np.ones(problem.partition.column_scale.size)
        weights[problem.partition.actuated] = motor_weight
        found.append(assemble(problem, q, weights))
        if found[-1].gap <= problem.tolerance:
            return found[-1].q
    best = min(found, key=lambda pose: pose.gap)
    residual = np.abs(problem.evaluate(best.q)[0] * loops.row_scale)
    row = loops.row_names[int(np.argmax(residual))]
    message = (
        f"{what} does not assemble: the loops stay open by {best.gap:.3g} m at best, "
        f"most at {row!r}; give joint values nearer to a closed pose, or other lengths"
    )
    raise ClosureError(message, residual_norm=best.gap, q=best.q)


def _problem(kinematics: Kinematics, partition: Partition) -> ClosureProblem:
    model = kinematics.model
    return ClosureProblem(kinematics.evaluate, lambda q, v: pin.integrate(model, q, v), partition)


def _partition(
    spec: MechanismSpec, coordinates: JointCoordinates, loops: LoopSystem, length: float
) -> Partition:
    for name in spec.actuated:
        if (count := coordinates.degrees_of_freedom(name)) != 1:
            message = f"a motor moves one degree of freedom; joint {name!r} has {count}"
            raise ArgumentError(message)
    others = tuple(name for name in coordinates.names if name not in spec.actuated)
    passive = others if spec.passive is None else spec.passive
    for name in passive:
        if name not in coordinates.names:
            raise unknown_name("joint", name, coordinates.names)
    if forgotten := [name for name in others if name not in passive]:
        message = f"joint {forgotten[0]!r} moves and is neither actuated nor passive"
        raise ArgumentError(message)
    return Partition(
        actuated=coordinates.columns(spec.actuated),
        passive=coordinates.columns(passive),
        actuated_names=coordinates.dof_names(spec.actuated),
        passive_names=coordinates.dof_names(passive),
        length=length,
        row_scale=loops.row_scale,
        column_scale=np.where(coordinates.rotational, 1.0 / length, 1.0),
    )


def _length(model: pin.Model, q: Array) -> float:
    """Return the root mean square distance of all frames from their middle, or 1 m for none."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    points = np.array([placement.translation for placement in data.oMf])
    spread = float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))
    return spread or 1.0


def _nearby(problem: ClosureProblem, home_q: Array) -> list[Array]:
    """Return closed poses near home, in seeded random directions.

    First along motions that the loops allow, all joints free to close them again; then with
    the motors displaced and kept there. From a home pose where branches meet, the first may
    well fall back to where they came from, and from one at the end of a motor's range half of
    the second have nowhere to go.
    """
    rng = np.random.default_rng(0)
    partition = problem.partition
    scaled = partition.scaled(problem.evaluate(home_q)[1])
    allowed = factorise(scaled, norm(scaled)).null_space
    free, motors_kept = np.ones(scaled.shape[1]), np.zeros(scaled.shape[1])
    motors_kept[partition.passive] = 1.0
    starts = []
    for _ in range(_PROBES):
        starts.append((allowed @ rng.normal(size=allowed.shape[1]), free))
        motors = np.zeros(scaled.shape[1])
        motors[partition.actuated] = rng.normal(size=partition.actuated.size)
        starts += [(motors, motors_kept), (-motors, motors_kept)]
    found = []
    for direction, weights in starts:
        stride = _PROBE_DISTANCE * partition.length / (norm(direction) or 1.0)
        q = problem.integrate(home_q, stride * partition.column_scale * direction)
        pose = assemble(problem, q, weights, limit=50)
        if pose.gap <= problem.tolerance:
            found.append(pose.q)
    return found
