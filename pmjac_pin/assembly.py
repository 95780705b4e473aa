"""From a Pinocchio model and a spec to the parts of a Mechanism: the loops assembled at home."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.closure import closed_point
from pmjac_pin.closure_problem import ClosureProblem
from pmjac_pin.coordinates import JointCoordinates
from pmjac_pin.damped_closure import assemble
from pmjac_pin.errors import ArgumentError, ClosureError, PmjacError, unknown_name
from pmjac_pin.factorisation import RANK_TOLERANCE, norm
from pmjac_pin.kinematics import Kinematics
from pmjac_pin.loops import LoopSystem
from pmjac_pin.partition import Partition
from pmjac_pin.parts import Parts
from pmjac_pin.pose_assembly import assemble_pose, check_motors, motor_weights
from pmjac_pin.spec import MechanismSpec
from pmjac_pin.tool import tool_kinematics
from pmjac_pin.urdf import Urdf

Array = NDArray[np.float64]

# Numbers that are off by a share of the mechanism's length are off by that in K*, and more.
_RANK_ROOM = 10.0
_PROBES = 2  # times three closed poses near home at which the generic ranks are looked for
_PROBE_DISTANCES = (0.05, 0.005, 0.0005)  # rad or share of the characteristic length

_logger = logging.getLogger(__name__)


def build_parts(
    model: pin.Model,
    spec: MechanismSpec,
    values: Mapping[str, float],
    urdf: Urdf | None = None,
    start: Array | None = None,
) -> Parts:
    """Resolve all names, assemble the home pose and find the generic ranks there.

    Parameters
    ----------
    model, spec, values, urdf
        What the mechanism is made of.
    start : ndarray, shape (nq,), optional
        Where to start assembling the home pose; the spec's values when None.

    Raises
    ------
    UnknownNameError
        A joint or frame that the model does not have.
    ArgumentError
        The actuated and passive joints are not a partition of the joints that move; a pose
        that does not fit the joints, or is outside the motors' limits.
    ClosureError
        The home pose does not assemble.
    """
    parts = _unassembled(model, spec, values, urdf)
    try:
        return _ranked(_assembled(parts, start))
    except PmjacError as error:
        error.parts = parts
        raise


def _ranked(parts: Parts) -> Parts:
    problem, kinematics = parts.problem, parts.kinematics
    snapshots = [kinematics.snapshot(q) for q in (parts.home_q, *nearby(problem, parts.home_q))]
    ranked = problem.partition.with_ranks_of(
        [(snapshot.constraint_jacobian, snapshot.tool_jacobian) for snapshot in snapshots]
    )
    return replace(parts, problem=_problem(kinematics, ranked, parts.spec.tolerance))


def home_pose(
    model: pin.Model,
    spec: MechanismSpec,
    values: Mapping[str, float],
    start: Array | None,
    least: float,
) -> tuple[Array, float]:
    """Return the home pose at parameters on the way to others, and its relative σ_min of K*.

    Raises
    ------
    ClosureError
        With the motors where they are, the loops stay open, or σ_min is below `least`.
    """
    parts = _unassembled(model, spec, values, None)
    problem, q = parts.problem, parts.home_q if start is None else start
    found = assemble(problem, q, motor_weights(problem, 0.0))
    factors = closed_point(problem, found.q).factors
    smallest = factors.singular_values[: factors.rank].min(initial=np.inf) / (factors.size or 1.0)
    if found.gap > problem.tolerance or smallest < least:
        raise ClosureError(f"{spec.name}: no home pose here", residual_norm=found.gap, q=found.q)
    return found.q, float(smallest)


def _assembled(parts: Parts, start: Array | None) -> Parts:
    spec, coordinates, given = parts.spec, parts.coordinates, parts.home_q
    for name, pose in spec.poses.items():
        check_motors(coordinates, coordinates.q(pose, given), spec, f"the pose {name!r} has")
    return replace(parts, home_q=assemble_pose(parts, given if start is None else start, "home"))


def _unassembled(
    model: pin.Model, spec: MechanismSpec, values: Mapping[str, float], urdf: Urdf | None
) -> Parts:
    coordinates = JointCoordinates(model)
    loops = LoopSystem(model, spec.loops, values)
    kinematics = Kinematics(model, loops, tool_kinematics(model, spec.tool))
    given = coordinates.q(spec.poses["home"])
    partition = _partition(spec, coordinates, loops, _length(model, given))
    problem = _problem(kinematics, partition, spec.tolerance)
    return Parts(model, spec, values, coordinates, kinematics, problem, given, urdf)


def _problem(kinematics: Kinematics, partition: Partition, given: float | None) -> ClosureProblem:
    model = kinematics.model
    return ClosureProblem(
        kinematics.evaluate, lambda q, v: pin.integrate(model, q, v), partition, given
    )


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
        row_scale=loops.row_scale(length),
        column_scale=np.where(coordinates.rotational, 1.0 / length, 1.0),
        rank_tolerance=max(RANK_TOLERANCE, _RANK_ROOM * (spec.tolerance or 0.0) / length),
    )


def _length(model: pin.Model, q: Array) -> float:
    """Return the root mean square distance of all frames from their middle, or 1 m for none."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    points = np.array([placement.translation for placement in data.oMf])
    spread = float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))
    return spread or 1.0


def nearby(problem: ClosureProblem, home_q: Array) -> list[Array]:
    """Return closed poses near home, in seeded random directions.

    First along motions that the loops allow, all joints free to close them again; then with
    the motors displaced and kept there. From a home pose where branches meet, the first may
    well fall back to where they came from, and from one at the end of a motor's range half of
    the second have nowhere to go.
    """
    rng = np.random.default_rng(0)
    partition = problem.partition
    scaled = partition.scaled(problem.evaluate(home_q)[1])
    allowed = partition.factorise(scaled, norm(scaled)).null_space
    free, motors_kept = np.ones(scaled.shape[1]), np.zeros(scaled.shape[1])
    motors_kept[partition.passive] = 1.0
    starts = []
    for _ in range(_PROBES):
        starts.append((allowed @ rng.normal(size=allowed.shape[1]), free))
        motors = np.zeros(scaled.shape[1])
        motors[partition.actuated] = rng.normal(size=partition.actuated.size)
        starts += [(motors, motors_kept), (-motors, motors_kept)]
    found = []
    for distance in _PROBE_DISTANCES:
        for direction, weights in starts:
            stride = distance * partition.length / (norm(direction) or 1.0)
            q = problem.integrate(home_q, stride * partition.column_scale * direction)
            pose = assemble(problem, q, weights, limit=50)
            if pose.gap <= problem.tolerance:
                found.append(pose.q)
        if found:
            break
    return found
