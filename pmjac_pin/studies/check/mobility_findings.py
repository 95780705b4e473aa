"""Findings about redundant loop equations and the count of the mobility."""

from __future__ import annotations

from collections.abc import Iterator

from pmjac_pin.studies.check.diagnosis import Diagnosis, Finding
from pmjac_pin.studies.check.diagnosis_parts import LoopEntry
from pmjac_pin.values.brief import brief


def redundancy_findings(diagnosis: Diagnosis) -> Iterator[Finding]:
    """Say which rows follow from others, and from which loop they come."""
    found = diagnosis.redundancy
    if found is None or not diagnosis.loops:
        return
    for loop in diagnosis.loops:
        if loop.rank == 0:
            message = f"The loop {loop.name!r} closes nothing: its ends cannot move apart."
            advice = "Check which frames it joins; it may repeat what a joint does already."
            yield Finding("warning", "loop-without-effect", message, advice)
    if not found.rows:
        rank = diagnosis.mobility.rank
        message = f"The {rank} loop equations are independent."
        message = "There is one loop equation." if rank == 1 else message
        yield Finding("ok", "independent-rows", message)
        return
    parts = [
        f"{_redundant_inside(loop)} of {loop.name!r}"
        for loop in diagnosis.loops
        if _redundant_inside(loop)
    ]
    sources = [f"inside loops: {', '.join(parts)}"] if parts else []
    if found.between:
        shared = ", ".join(repr(loop.name) for loop in diagnosis.loops if _implied(loop))
        sources.append(f"between loops: {found.between}, shared by {shared}")
    count = f"{found.rows} of {diagnosis.mobility.rows} rows"
    verb = "is" if found.rows == 1 else "are"
    message = f"{count} {verb} redundant; {'; '.join(sources)}."
    advice = "Nothing to do: J_eq rests on all rows, K and K* show independent ones."
    yield Finding("note", "redundant-rows", message, advice)


def count_findings(diagnosis: Diagnosis) -> Iterator[Finding]:
    """Compare the mobility with Grübler-Kutzbach's counts."""
    found = diagnosis.mobility
    if found.mobility is None or not diagnosis.loops:
        return
    yield from _near_home_only(diagnosis)
    if found.gruebler == found.mobility:
        message = f"Mobility {found.mobility} by rank, and as Grübler–Kutzbach count it."
        yield Finding("ok", "mobility", message)
        return
    message = f"Mobility {found.mobility} by rank, where Grübler–Kutzbach count {found.gruebler}"
    if found.gruebler_in_groups == found.mobility:
        groups = sorted({loop.group or "" for loop in diagnosis.loops} - {"spatial", ""})
        message += f"; with the equations that {' and '.join(groups)} loops have, they agree."
        advice = "The formula in space does not know that a loop's axes share a direction or point."
        yield Finding("note", "mobility", message, advice)
        return
    if found.gruebler_in_groups != found.gruebler:
        message += f" in space and {found.gruebler_in_groups} with each loop in its own group"
    if twice := _joined_twice(diagnosis):
        message += f": {' and '.join(map(repr, twice))} join the same two bodies."
        advice = "One loop of another kind (frame, revolute, ...) in their place counts right."
    else:
        message += ": it moves by its special dimensions."
        advice = (
            "True while these lengths and axes are exact; a machine built with tolerances needs "
            "clearance, or jams."
        )
    yield Finding("note", "mobility", message, advice)


def _near_home_only(diagnosis: Diagnosis) -> Iterator[Finding]:
    """Say that ranks rest on poses so near home that loops which part slowly are closed there."""
    found = diagnosis.mobility
    if found.reach is None:
        return
    far = f"{brief(found.reach * diagnosis.characteristic_length)} m"
    if any(freedom.unit == "rad" for freedom in diagnosis.freedoms):
        far = f"{found.reach:g} rad or {far}"
    message = (
        f"Mobility {found.mobility} and all generic ranks rest on poses no further than "
        f"{far} from home: with a joint displaced ten times as far, "
        "the loops stay open."
    )
    advice = (
        "It may be a structure whose loops part very slowly, or home may be at the very end of a "
        "motion, or a rod that is as short may end it: move home, and check the lengths; till then "
        "J_eq may be that of a structure."
    )
    yield Finding("warning", "near-home-only", message, advice)


def _joined_twice(diagnosis: Diagnosis) -> list[str]:
    """Return loops that join the same two bodies as another."""
    pairs = {
        loop.name: frozenset(body.name for body in diagnosis.bodies if loop.name in body.loops)
        for loop in diagnosis.loops
        if loop.group is not None
    }
    known = list(pairs.values())
    return [name for name, pair in pairs.items() if known.count(pair) > 1]


def _redundant_inside(loop: LoopEntry) -> int:
    return 0 if loop.rank is None else len(loop.equations) - loop.rank


def _implied(loop: LoopEntry) -> int:
    return 0 if loop.rank is None or loop.needed is None else loop.rank - loop.needed
