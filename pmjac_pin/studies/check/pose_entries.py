"""Entries of a Diagnosis: the poses of a model file, and where the model stands."""

from __future__ import annotations

import numpy as np

from pmjac_pin.errors import ClosureError, LimitError, PmjacError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.check.diagnosis import Failure, PoseEntry
from pmjac_pin.studies.check.diagnosis_structure import loop_gaps
from pmjac_pin.studies.check.machine import CheckedMachine
from pmjac_pin.values.arrays import Array


def pose_entry(mechanism: Mechanism, name: str) -> PoseEntry:
    """Return what is known of a named pose, once it is closed, or why it cannot be."""
    gap = gap_given(mechanism, mechanism.home.q, name)
    try:
        closed, moved = mechanism.pose(name), mechanism.moved(name)
        singularity = closed.singularity()
    except PmjacError as error:
        return PoseEntry(name, gap, None, None, None, None, failure_of(error))
    smallest, condition = singularity.smallest, singularity.condition
    beyond = {joint: one.words for joint, one in closed.limits_violated.items()}
    return PoseEntry(name, gap, dict(moved), singularity.kind, smallest, condition, None, beyond)


def gap_given(machine: CheckedMachine, home: Array, pose: str) -> float:
    """Return how far the loops are open where the model file has a pose, m."""
    q = machine.coordinates.q(machine.spec.poses[pose], None if pose == "home" else home)
    return float(np.linalg.norm(loop_gaps(machine, q)))


def failure_of(error: PmjacError) -> Failure:
    """Return an error as an entry: open, outside limits, or not built at all."""
    if isinstance(error, ClosureError) and error.loop:
        return Failure("open", str(error), error.loop, float(error.residual_norm))
    if isinstance(error, ClosureError | LimitError):
        return Failure("outside-limits", str(error))
    return Failure("not-built", str(error))


def far_from_origin(machine: CheckedMachine) -> float | None:
    """Return how far a mechanism stands from the origin where that decides what is closed."""
    decides = machine.problem.tolerance == machine.problem.rounding and machine.place.any()
    closes = bool(machine.kinematics.loops.row_names)
    return float(np.linalg.norm(machine.place)) if closes and decides else None
