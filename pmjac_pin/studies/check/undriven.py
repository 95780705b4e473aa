"""What is known of a machine whose file does not say which joints are its motors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import msgspec
import numpy as np

from pmjac_pin.errors import enumerated
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.actuation import analyse_actuation
from pmjac_pin.studies.check.diagnosis import Diagnosis, Finding, PoseEntry
from pmjac_pin.studies.check.findings import find, in_order
from pmjac_pin.values.arrays import Array

_UNTOLD = (
    "The file does not say which joints are motors; what is said here holds whichever they are."
)
_MOVES = 1e-9  # of the largest rate


def undriven(
    diagnosis: Diagnosis, candidates: Sequence[str], suggestion: Sequence[str]
) -> Diagnosis:
    """Return what of a diagnosis does not depend on the motors, and say which there could be.

    Parameters
    ----------
    diagnosis : Diagnosis
        With one of the candidates as the motor.
    candidates : sequence of str
        Joints that may be motors.
    suggestion : sequence of str
        Those of them that command all that the loops allow, if that is known.
    """
    freedoms = tuple(msgspec.structs.replace(one, role="unknown") for one in diagnosis.freedoms)
    known = msgspec.structs.replace(
        diagnosis,
        freedoms=freedoms,
        actuation=None,
        tool_rank=None,
        poses=tuple(map(_of_any_motors, diagnosis.poses)),
    )
    of_tool = [finding for finding in diagnosis.findings if finding.code == "no-tool"]
    untold = Finding("error", "no-motors", _UNTOLD, _what_to_give(candidates, suggestion))
    return msgspec.structs.replace(known, findings=in_order([untold, *of_tool, *find(known)]))


def commanding(
    mechanism: Mechanism, q: Array, candidates: Sequence[str]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the candidates that can move, and those of them that determine the others' rates.

    The latter are none where joints of several degrees of freedom would be too many.
    """
    partition, snapshot = mechanism.problem.partition, mechanism.kinematics.snapshot(q)
    joints = [name for name in candidates for _ in mechanism.coordinates.columns([name])]
    columns = mechanism.coordinates.columns(candidates)
    others = np.setdiff1d(np.arange(partition.column_scale.size), columns)
    driven = replace(partition, actuated=columns, passive=others)
    found = analyse_actuation(snapshot.constraint_jacobian, snapshot.tool_jacobian, driven)
    moving = np.flatnonzero(np.abs(found.allowed).max(axis=1, initial=0.0) > _MOVES).tolist()
    enough = _named(joints, found.sufficient.tolist())
    alone = mechanism.coordinates.columns(enough).size == found.sufficient.size
    return _named(joints, moving), enough if alone else ()


def _named(joints: Sequence[str], columns: Sequence[int]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(joints[k] for k in columns))


def _of_any_motors(pose: PoseEntry) -> PoseEntry:
    kind = pose.kind if pose.kind == "isolated" else None
    return msgspec.structs.replace(pose, kind=kind, smallest=None, condition=None)


def _what_to_give(candidates: Sequence[str], suggestion: Sequence[str]) -> str:
    listed = enumerated(candidates)
    if not suggestion:
        return f"Name motors with `actuated` (`--actuated`), of: {listed}."
    count, option = len(suggestion), f"`--actuated {','.join(suggestion)}`"
    many = f"Name {count} motor{'s' * (count > 1)} with `actuated`"
    if count == len(candidates):
        return f"{many}: {option}."
    determine = "determines" if count == 1 else "determine"
    return f"{many}, of: {listed}; such as {option}, which {determine} all others."
