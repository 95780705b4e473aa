"""Findings about a model's numbers: their rounding, the gap that counts as closed, small loops."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pmjac_pin.closing.machine_size import SMALL, SPHERICAL
from pmjac_pin.model.rounded_numbers import wider_tolerance
from pmjac_pin.studies.check.actuation_findings import listed_in_words
from pmjac_pin.studies.check.diagnosis import Diagnosis, Finding
from pmjac_pin.studies.check.diagnosis_parts import FreedomEntry
from pmjac_pin.values.brief import brief

_MANY_TURNS = 4.0 * math.pi  # rad: few joints that turn have limits beyond
_MOST_DEGREES = 720.0
_NO_LIMIT = 100.0  # rad, either way: what people write for none


def number_findings(diagnosis: Diagnosis) -> Iterator[Finding]:
    """Say what the model's numbers cost, which look odd, and which loops have their own size."""
    yield from _tolerance(diagnosis)
    yield from _far_findings(diagnosis)
    yield from _loop_sizes(diagnosis)
    yield from _limits_in_degrees(diagnosis)


def all_digits(gap: float) -> str:
    """Return the advice where numbers were rounded and loops stay open by `gap`, m."""
    return f"Write the model's numbers with all their digits, or give {wider_tolerance(gap)}."


def _tolerance(diagnosis: Diagnosis) -> Iterator[Finding]:
    if diagnosis.tolerance is not None:
        message = f"The file lets loops count as closed that are open by {diagnosis.tolerance:g} m."
        advice = "Numbers are good to that, no better; write the model's with all their digits."
        yield Finding("note", "tolerance", message, advice)
    gap, isolated = diagnosis.rounding, any(pose.kind == "isolated" for pose in diagnosis.poses)
    if gap is not None and not isolated:
        message = f"Away from home the loops stay open by up to {brief(gap)} m."
        yield Finding("warning", "rounded-numbers", message, all_digits(gap))


def _far_findings(diagnosis: Diagnosis) -> Iterator[Finding]:
    if diagnosis.far is not None:
        message = (
            f"It stands {brief(diagnosis.far)} m from the world's origin, where coordinates are "
            f"rounded: loops count as closed up to {brief(diagnosis.closed)} m."
        )
        advice = "Put the origin near the machine for more digits."
        yield Finding("note", "far-from-origin", message, advice)


def _loop_sizes(diagnosis: Diagnosis) -> Iterator[Finding]:
    length = diagnosis.characteristic_length
    for loop in diagnosis.loops:
        what = f"The lever arms of loop {loop.name!r} are {brief(loop.size)} m"
        if 0.0 < loop.size <= SPHERICAL * length:
            message = (
                f"{what}, beside the machine's {brief(length)} m: they are taken for rounding, and "
                "the axes of its joints for meeting in a point."
            )
            advice = "If they do not, its rank is wrong: make it a mechanism of its own."
            yield Finding("warning", "loop-without-size", message, advice)
        elif 0.0 < loop.size < SMALL * length:
            message = (
                f"{what}, much shorter than the machine's {brief(length)} m: ranks and closure "
                "judge it by its own size."
            )
            yield Finding("note", "small-loop", message)


def _limits_in_degrees(diagnosis: Diagnosis) -> Iterator[Finding]:
    if not (odd := [freedom for freedom in diagnosis.freedoms if _like_degrees(freedom)]):
        return
    first = odd[0]
    given, meant = _interval(first, 1.0), _interval(first, math.pi / 180.0)
    message = (
        f"The limits of {listed_in_words([freedom.name for freedom in odd])} look like degrees: "
        f"{first.name!r} may turn within {given} rad."
    )
    yield Finding("note", "limits-in-degrees", message, f"If so, write {meant} rad, for instance.")


def _like_degrees(freedom: FreedomEntry) -> bool:
    """Whether limits are whole numbers of rad that are many turns."""
    ends = [abs(end) for end in (freedom.lower, freedom.upper) if end is not None]
    if freedom.unit != "rad" or not all(end.is_integer() for end in ends):
        return False
    return {*ends} != {_NO_LIMIT} and _MANY_TURNS < max(ends, default=0.0) <= _MOST_DEGREES


def _interval(freedom: FreedomEntry, factor: float) -> str:
    ends = ("-∞" if freedom.lower is None else f"{freedom.lower * factor:.4g}",
            "∞" if freedom.upper is None else f"{freedom.upper * factor:.4g}")  # fmt: skip
    return f"[{', '.join(ends)}]"
