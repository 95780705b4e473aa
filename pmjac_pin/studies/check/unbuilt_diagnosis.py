"""The Diagnosis of as much of a mechanism as could be built."""

from __future__ import annotations

import msgspec

from pmjac_pin.closing.assembly import unassembled
from pmjac_pin.errors import PmjacError
from pmjac_pin.files.source import Source
from pmjac_pin.studies.check.diagnosis import Diagnosis, PoseEntry
from pmjac_pin.studies.check.diagnosis_structure import Structure, bodies, freedoms, loops, mobility
from pmjac_pin.studies.check.findings import find
from pmjac_pin.studies.check.pose_entries import failure_of, far_from_origin, gap_given
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.values.encodable import encodable


def of_error(error: PmjacError) -> Diagnosis:
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
        failure=failure_of(cause),
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
            PoseEntry(name, gap_given(machine, machine.home_q, name), None, None, None, None, None)
            for name in machine.spec.poses
        ),
        characteristic_length=machine.problem.partition.length,
        tolerance=machine.spec.tolerance,
        far=far_from_origin(machine),
        closed=machine.problem.tolerance,
        notes=tuple(map(encodable, source.all_notes)) if source else (),
        unread=tuple(map(encodable, source.unread)) if source else (),
    )
    return msgspec.structs.replace(diagnosis, findings=find(diagnosis))
