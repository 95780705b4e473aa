"""The Diagnosis of a mechanism that could be built."""

from __future__ import annotations

import msgspec
import numpy as np
import pinocchio as pin

from pmjac_pin.closing.damped_closure import assemble, motor_weights
from pmjac_pin.closing.nearby_poses import nearby
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.actuation import analyse_actuation
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.rates.partition import Partition
from pmjac_pin.rates.redundancy import LoopRank, dependent_rows, loop_ranks
from pmjac_pin.rates.singularity import Singularity, analyse_singularity
from pmjac_pin.studies.check.diagnosis import (
    ActuationEntry,
    DependentRow,
    Diagnosis,
    FreeMotion,
    Rates,
    Redundancy,
)
from pmjac_pin.studies.check.diagnosis_structure import (
    Structure,
    bodies,
    body_names,
    freedoms,
    loops,
    mobility,
)
from pmjac_pin.studies.check.findings import find
from pmjac_pin.studies.check.pose_entries import far_from_origin, pose_entry
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.encodable import encodable

_ROUNDING_STRIDE = 0.1  # rad or share of the length, from home to where rounding is looked for
_FORBIDDEN_RATES = 1e-3  # of the size of [K K*]: rates that loops of rounded numbers forbid
_ROUNDED_GAP = 1e-5  # of the length: the gap of a structure is a hundred times as large there


def of_mechanism(mechanism: Mechanism) -> Diagnosis:
    """Return what is known of a mechanism, and what is wrong with it."""
    structure, partition = Structure.of(mechanism, mechanism.home.q), mechanism.problem.partition
    q = regular_pose(mechanism)
    scaled = partition.scaled(mechanism.kinematics.snapshot(q).constraint_jacobian)
    ranks = loop_ranks(scaled, mechanism.kinematics.loops.slices, partition)
    diagnosis = Diagnosis(
        mechanism=encodable(mechanism.name),
        description=mechanism.spec.description,
        failure=None,
        bodies=bodies(structure),
        freedoms=freedoms(structure, mechanism.moved()),
        tool=mechanism.spec.tool.names,
        tool_rows=partition.tool_rows.names,
        tool_axes=partition.tool_rows.axes,
        tool_rank=partition.tool_rank,
        loops=loops(structure, ranks),
        mobility=mobility(structure, None if partition.isolated else partition.constraint_rank),
        evidence=_mobility_evidence(partition),
        redundancy=_redundancy(scaled, ranks, mechanism),
        actuation=None
        if partition.isolated
        else _actuation(mechanism, q, mechanism.home.singularity().gained),
        poses=tuple(pose_entry(mechanism, name) for name in mechanism.poses),
        characteristic_length=partition.length,
        tolerance=mechanism.spec.tolerance,
        far=far_from_origin(mechanism),
        closed=mechanism.problem.tolerance,
        rounding=_rounding(mechanism),
        notes=tuple(map(encodable, mechanism.notes)),
        unread=tuple(map(encodable, mechanism.unread)),
    )
    return msgspec.structs.replace(diagnosis, findings=find(diagnosis))


def _mobility_evidence(partition: Partition) -> Evidence:
    if partition.isolated:
        return Evidence("nothing", "no pose near home closes")
    zero = f"singular values up to {partition.rank_tolerance:.2g} of the size of [K K*]"
    return Evidence("tolerance", f"at home and near it, {zero} count as zero")


def _redundancy(scaled: Array, ranks: tuple[LoopRank, ...], mechanism: Mechanism) -> Redundancy:
    names, inside = mechanism.rows, sum(loop.redundant_inside for loop in ranks)
    dependent = dependent_rows(scaled, mechanism.problem.partition)
    return Redundancy(
        rows=len(dependent),
        inside=inside,
        between=len(dependent) - inside,
        dependent=tuple(
            DependentRow(names[row], tuple(names[k] for k in others))
            for row, others in dependent.items()
        ),
    )


def regular_pose(mechanism: Mechanism) -> Array:
    """Return the home pose or, where that is singular, one near it that is less so."""
    partition = mechanism.problem.partition
    generic = (partition.constraint_rank, partition.passive_rank)

    def ranks(q: Array) -> tuple[int, int]:
        found = _singularity(mechanism, q)
        return found.constraint_rank, found.rank

    if ranks(mechanism.home.q) == generic:
        return mechanism.home.q
    return max((mechanism.home.q, *nearby(mechanism.problem, mechanism.home.q)), key=ranks)


def _singularity(mechanism: Mechanism, q: Array) -> Singularity:
    snapshot, partition = mechanism.kinematics.snapshot(q), mechanism.problem.partition
    judged = snapshot.judged_jacobian(partition.tool_rows)
    return analyse_singularity(snapshot.constraint_jacobian, judged, partition)


def _actuation(mechanism: Mechanism, q: Array, gained: int) -> ActuationEntry:
    partition, snapshot = mechanism.problem.partition, mechanism.kinematics.snapshot(q)
    motors, passive = partition.actuated_names, partition.passive_names
    found = analyse_actuation(snapshot.constraint_jacobian, snapshot.tool_jacobian, partition)
    singularity = _singularity(mechanism, q)
    moving = _moving_bodies(mechanism, q, found.free)
    twists = snapshot.tool_jacobian[:, partition.passive] @ found.free
    return ActuationEntry(
        motors=len(motors),
        allowed_rates=tuple(_by_name(motors, rates) for rates in found.allowed.T),
        forbidden_rates=tuple(_by_name(motors, rates) for rates in singularity.forbidden_rates.T),
        sufficient=tuple(motors[k] for k in found.sufficient),
        idle=singularity.idle,
        gained=gained,
        free_motions=tuple(
            FreeMotion(
                _by_name(passive, rates), names, bool(felt), norm(twist[:3]), norm(twist[3:])
            )
            for rates, names, felt, twist in zip(
                found.free.T, moving, found.felt, twists.T, strict=True
            )
        ),
        felt=found.felt_rank,
    )


def _moving_bodies(mechanism: Mechanism, q: Array, free: Array) -> list[tuple[str, ...]]:
    """Return the bodies that each passive motion moves."""
    model, partition = mechanism.kinematics.model, mechanism.problem.partition
    data, names = model.createData(), body_names(model)
    pin.computeJointJacobians(model, data, q)
    rates = np.zeros((model.nv, free.shape[1]))
    rates[partition.passive] = free / partition.column_scale[partition.passive, None]
    moving: list[list[str]] = [[] for _ in range(free.shape[1])]
    for body in range(1, model.njoints):
        jacobian = pin.getJointJacobian(model, data, body, pin.LOCAL_WORLD_ALIGNED).reshape(6, -1)
        scaled = partition.scaled_tool(jacobian) @ rates
        threshold = partition.rank_tolerance * np.abs(rates).max(axis=0)
        for motion in np.flatnonzero(np.linalg.norm(scaled, axis=0) > threshold):
            moving[motion].append(names[body])
    return list(map(tuple, moving))


def _rounding(mechanism: Mechanism) -> float | None:
    """Return the gap that stays a little away from home, where rounded numbers are its cause."""
    problem, q = mechanism.problem, mechanism.home.q
    partition = problem.partition
    scaled = partition.scaled(mechanism.kinematics.snapshot(q).constraint_jacobian)
    # Rounded axes take away what should be allowed: to no more than their rounding.
    allowed = factorise(scaled, partition.size_of(scaled), _FORBIDDEN_RATES).null_space
    gaps = []
    for direction in (*allowed.T, *-allowed.T):
        stride = _ROUNDING_STRIDE * partition.length * partition.column_scale * direction
        weights = motor_weights(problem, 0.0 if stride[partition.actuated].any() else 1.0)
        gaps.append(assemble(problem, problem.integrate(q, stride), weights).gap)
    if not gaps or max(gaps) <= problem.tolerance or max(gaps) > _ROUNDED_GAP * partition.length:
        return None
    return max(gaps)


def _by_name(names: tuple[str, ...], rates: Array) -> Rates:
    return dict(zip(names, map(float, rates), strict=True))
