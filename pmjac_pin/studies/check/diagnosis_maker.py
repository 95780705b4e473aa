"""From a mechanism, or as much of it as could be built, to its Diagnosis."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pinocchio as pin

from pmjac_pin.closing.assembly import unassembled
from pmjac_pin.closing.damped_closure import assemble
from pmjac_pin.closing.nearby_poses import nearby
from pmjac_pin.closing.pose_assembly import motor_weights
from pmjac_pin.errors import ClosureError, LimitError, NoMotorsError, PmjacError
from pmjac_pin.files.foreign_model import links_from_the_ends
from pmjac_pin.files.source import Source
from pmjac_pin.loading import load
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
    Failure,
    Finding,
    FreeMotion,
    PoseEntry,
    Rates,
    Redundancy,
)
from pmjac_pin.studies.check.diagnosis_structure import (
    Structure,
    bodies,
    body_names,
    freedoms,
    loop_gaps,
    loops,
    mobility,
)
from pmjac_pin.studies.check.findings import find, in_order
from pmjac_pin.studies.check.machine import CheckedMachine
from pmjac_pin.studies.check.undriven import commanding, undriven
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.encodable import encodable

_ROUNDING_STRIDE = 0.1  # rad or share of the length, from home to where rounding is looked for
_FORBIDDEN_RATES = 1e-3  # of the size of [K K*]: rates that loops of rounded numbers forbid
_ROUNDED_GAP = 1e-5  # of the length: the gap of a structure is a hundred times as large there


def check(source: str | Path | Mechanism | PmjacError, **options: Any) -> Diagnosis:
    """Check a model: what it is made of, what its loops do, and what is wrong with it.

    Parameters
    ----------
    source : str, Path, Mechanism or PmjacError
        A name or a path as `load` takes it; a mechanism; or the error that `load` or
        `Mechanism.from_pinocchio` raised because the mechanism could not be built.
    **options
        Of `load`, where `source` is a name or a path.

    Returns
    -------
    Diagnosis
        `findings`, the worst first, and the facts that they rest on. Also where the home pose
        does not assemble, or nobody names motors, which are findings then.

    Raises
    ------
    ModelFileError, UnknownNameError, ArgumentError
        There is nothing to check: a file that cannot be read, names that do not exist.
    NoToolError
        The mechanism has no tool, and its model no link that could be one.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> diagnosis = pj.check("four_bar")
    >>> diagnosis.severity, diagnosis.mobility.mobility, diagnosis.mobility.gruebler
    ('note', 1, 0)
    >>> [finding.code for finding in pj.check("four_bar", parameters={"l1": 100}).findings][0]
    'home-open'
    """
    if isinstance(source, Mechanism):
        return _diagnosed(source)
    if isinstance(source, PmjacError):
        return _of_error(source)
    try:
        mechanism = load(source, **options)
    except NoMotorsError as error:
        return _undriven(source, error.candidates, options)
    except PmjacError as error:
        if error.source is not None and error.source.spec.tool.is_none:
            tool = links_from_the_ends(error.source.urdf)[0]
            return _without_tool(check(source, **{**options, "tool": tool}))
        return _of_error(error)
    return _diagnosed(mechanism)


def _undriven(
    source: str | Path, candidates: tuple[str, ...], options: dict[str, Any]
) -> Diagnosis:
    """Return what is known whichever of these joints are motors: one of them stands for all."""
    given = {**options, "actuated": candidates[:1]}
    try:
        mechanism = load(source, **given)
    except PmjacError:
        return undriven(check(source, **given), candidates, ())
    if mechanism.problem.partition.isolated:
        return undriven(_diagnosed(mechanism), candidates, ())
    return undriven(_diagnosed(mechanism), *commanding(mechanism, _regular(mechanism), candidates))


def _diagnosed(mechanism: Mechanism) -> Diagnosis:
    """Return the diagnosis, by the end of the longest chain where no frame is the tool."""
    if not mechanism.spec.tool.is_none:
        return _of_mechanism(mechanism)
    if not mechanism.possible_tools:
        mechanism.need_tool()
    tool = mechanism.possible_tools[0]
    return _without_tool(_of_mechanism(mechanism.with_tool(tool)))


def _without_tool(diagnosis: Diagnosis) -> Diagnosis:
    """Say of a diagnosis that nobody has named the tool that it takes."""
    [tool] = diagnosis.tool
    message = f"No frame is named as the tool; what is said of one here is of {tool!r}."
    advice = "Name it with `tool`: that link ends the longest chain."
    untold = Finding("warning", "no-tool", message, advice)
    return msgspec.structs.replace(diagnosis, findings=in_order([untold, *diagnosis.findings]))


def _of_mechanism(mechanism: Mechanism) -> Diagnosis:
    structure, partition = Structure.of(mechanism, mechanism.home.q), mechanism.problem.partition
    q = _regular(mechanism)
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
        poses=tuple(_pose_entry(mechanism, name) for name in mechanism.poses),
        characteristic_length=partition.length,
        tolerance=mechanism.spec.tolerance,
        far=_far(mechanism),
        closed=mechanism.problem.tolerance,
        rounding=_rounding(mechanism),
        notes=tuple(map(encodable, mechanism.notes)),
        unread=tuple(map(encodable, mechanism.unread)),
    )
    return msgspec.structs.replace(diagnosis, findings=find(diagnosis))


def _of_error(error: PmjacError) -> Diagnosis:
    """Show what was known when the mechanism could not be built, or raise the error again."""
    cause = error.__cause__ if error.built_of is None else error
    if not isinstance(cause, PmjacError) or cause.built_of is None:
        raise error
    machine = unassembled(*cause.built_of)
    source: Source | None = error.source
    structure = Structure.of(machine, machine.home_q)
    diagnosis = Diagnosis(
        mechanism=encodable(machine.spec.name),
        description=machine.spec.description,
        failure=_failure(cause),
        bodies=bodies(structure),
        freedoms=freedoms(structure, None),
        tool=machine.spec.tool.names,
        tool_rows=machine.spec.tool.judged.names,
        tool_axes=machine.spec.tool.judged.axes,
        tool_rank=None,
        loops=loops(structure, None, getattr(cause, "q", None)),
        mobility=mobility(structure, None),
        evidence=Evidence("nothing", "the home pose could not be built"),
        redundancy=None,
        actuation=None,
        poses=tuple(
            PoseEntry(name, _gap_given(machine, machine.home_q, name), None, None, None, None, None)
            for name in machine.spec.poses
        ),
        characteristic_length=machine.problem.partition.length,
        tolerance=machine.spec.tolerance,
        far=_far(machine),
        closed=machine.problem.tolerance,
        notes=tuple(map(encodable, source.all_notes)) if source else (),
        unread=tuple(map(encodable, source.unread)) if source else (),
    )
    return msgspec.structs.replace(diagnosis, findings=find(diagnosis))


def _mobility_evidence(partition: Partition) -> Evidence:
    if partition.isolated:
        return Evidence("nothing", "no pose near home closes")
    zero = f"singular values up to {partition.rank_tolerance:.2g} of the size of [K K*]"
    return Evidence("tolerance", f"at home and near it, {zero} count as zero")


def _far(machine: CheckedMachine) -> float | None:
    """Return how far a mechanism stands from the origin where that decides what is closed."""
    decides = machine.problem.tolerance == machine.problem.rounding and machine.place.any()
    closes = bool(machine.kinematics.loops.row_names)
    return float(np.linalg.norm(machine.place)) if closes and decides else None


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


def _regular(mechanism: Mechanism) -> Array:
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


def _pose_entry(mechanism: Mechanism, name: str) -> PoseEntry:
    gap = _gap_given(mechanism, mechanism.home.q, name)
    try:
        closed, moved = mechanism.pose(name), mechanism.moved(name)
        singularity = closed.singularity()
    except PmjacError as error:
        return PoseEntry(name, gap, None, None, None, None, _failure(error))
    smallest, condition = singularity.smallest, singularity.condition
    beyond = {joint: one.words for joint, one in closed.limits_violated.items()}
    return PoseEntry(name, gap, dict(moved), singularity.kind, smallest, condition, None, beyond)


def _gap_given(machine: CheckedMachine, home: Array, pose: str) -> float:
    q = machine.coordinates.q(machine.spec.poses[pose], None if pose == "home" else home)
    return float(np.linalg.norm(loop_gaps(machine, q)))


def _failure(error: PmjacError) -> Failure:
    if isinstance(error, ClosureError) and error.loop:
        return Failure("open", str(error), error.loop, float(error.residual_norm))
    if isinstance(error, ClosureError | LimitError):
        return Failure("outside-limits", str(error))
    return Failure("not-built", str(error))


def _by_name(names: tuple[str, ...], rates: Array) -> Rates:
    return dict(zip(names, map(float, rates), strict=True))
