"""Findings: what the facts of a diagnosis mean, in words, and what to do about it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pmjac_pin.closing.closure_problem import LARGEST_SHARE
from pmjac_pin.model.joint_kinds import JOINT_KINDS
from pmjac_pin.model.rounded_numbers import wider_tolerance
from pmjac_pin.studies.check.actuation_findings import (
    forbidden_findings,
    free_findings,
    listed_in_words,
    tool_row_findings,
)
from pmjac_pin.studies.check.diagnosis import Diagnosis, Finding, PoseEntry, Severity
from pmjac_pin.studies.check.diagnosis_parts import FreedomEntry
from pmjac_pin.studies.check.mobility_findings import count_findings, redundancy_findings
from pmjac_pin.studies.check.number_findings import all_digits, number_findings
from pmjac_pin.values.brief import brief

_ORDER = ("error", "warning", "note", "ok")
WIDE_OPEN = 0.1  # of the characteristic length: beyond, which assembly mode is found is chance
NEAR_SINGULAR = 1e-3  # of the size of [K K*]: passive rates a thousand times the motors'
_MOVED = 1e-9  # m or rad
_AT_LIMIT = 1e-6  # m or rad


def find(diagnosis: Diagnosis) -> tuple[Finding, ...]:
    """Return what there is to say about a diagnosis, the worst first."""
    rules = (
        _failure_findings,
        _assembly,
        _limit_findings,
        forbidden_findings,
        free_findings,
        tool_row_findings,
        _conditioning,
        redundancy_findings,
        count_findings,
        number_findings,
        _reader,
    )
    return in_order([finding for rule in rules for finding in rule(diagnosis)])


def in_order(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return findings, the worst first."""
    return tuple(sorted(findings, key=lambda finding: _ORDER.index(finding.severity)))


def _failure_findings(diagnosis: Diagnosis) -> Iterator[Finding]:
    failure = diagnosis.failure
    if failure is None:
        return
    if failure.code != "open":
        advice = "Correct the pose or the joint's limits; what follows is the file's pose, open."
        code = "home-outside-limits" if failure.code == "outside-limits" else failure.code
        yield Finding("error", code, failure.message, advice)
        return
    worst = next(loop for loop in diagnosis.loops if loop.name == failure.loop)
    message = (
        f"The home pose does not assemble: its loops stay open by {brief(failure.gap or 0.0)} m "
        f"at best, most at {worst.name!r}, which is open by {brief(worst.gap_given)} m in the file."
    )
    yield Finding("error", "home-open", message, _what_to_try(diagnosis))


def _what_to_try(diagnosis: Diagnosis) -> str:
    least = 1e-9 * diagnosis.characteristic_length
    stuck = [loop.name for loop in diagnosis.loops if (loop.gap_alone or 0.0) > least]
    failure = diagnosis.failure
    if stuck:
        plural = "s" if len(stuck) > 1 else ""
        cause = (
            f"The loop{plural} {listed_in_words(stuck)} did not close from here or around even "
            "alone, all joints free: check its frames, the lengths along it and its joints' limits."
        )
    else:
        cause = (
            "Each loop closes alone, all together did not: check the lengths that they share, or "
            "give joint values nearer to a closed pose."
        )
    most = LARGEST_SHARE * diagnosis.characteristic_length
    if failure and failure.gap is not None and failure.gap <= most:
        cause += f" Or give {wider_tolerance(failure.gap)}."
    return cause


def _assembly(diagnosis: Diagnosis) -> Iterator[Finding]:
    if diagnosis.failure:
        return
    for pose in diagnosis.poses:
        yield from _one_pose(diagnosis, pose)
    if not diagnosis.loops:
        yield Finding("note", "no-loops", "There are no loops: an open chain, J_eq = J.")
    elif all(pose.failure is None for pose in diagnosis.poses):
        poses = diagnosis.poses
        which = f"All {len(poses)} poses close" if len(poses) > 1 else "The home pose closes"
        most = " at most" if len(poses) > 1 else ""
        gap = brief(max(pose.gap_given for pose in poses))
        yield Finding("ok", "assembles", f"{which}; open by {gap} m{most} as the file has it.")


def _one_pose(diagnosis: Diagnosis, pose: PoseEntry) -> Iterator[Finding]:
    what = f"The pose {pose.name!r}"
    if pose.failure:
        advice = "Give joint values nearer to a closed pose, or remove it."
        code = "pose-open" if pose.failure.code == "open" else "pose-outside-limits"
        yield Finding("error", code, pose.failure.message, advice)
        return
    moved = pose.moved or {}
    if pose.gap_given > WIDE_OPEN * diagnosis.characteristic_length:
        farthest = max(moved, key=lambda name: abs(moved[name]))
        move = _value_with_unit(diagnosis, farthest, moved[farthest])
        message = (
            f"{what} is open by {brief(pose.gap_given)} m in the file"
            f"{_most_open(diagnosis, pose)}; to close it, {farthest!r} moved by {move}."
        )
        advice = (
            "Which assembly mode a wide open pose ends on is chance: look at it (pmjac view), then "
            "write the closed values (pmjac report --json has all digits) into the file."
        )
        yield Finding("warning", "wide-open", message, advice)
    if pose.beyond:
        told = "; ".join(f"{name!r} = {words}" for name, words in pose.beyond.items())
        advice = "Give values within the limits, widen them, or choose another assembly mode."
        yield Finding("warning", "beyond-limits", f"{what} closes where {told}.", advice)
    motors = [freedom.name for freedom in diagnosis.freedoms if freedom.role == "actuated"]
    if forced := [name for name in motors if abs(moved.get(name, 0.0)) > _MOVED]:
        moves = ", ".join(
            f"{name!r} by {_value_with_unit(diagnosis, name, moved[name])}" for name in forced
        )
        sought = "was not found to close with its motors where the file puts them"
        message = f"{what} {sought}; moved: {moves}."
        advice = "Give motor values that can be reached, or check the lengths."
        yield Finding("warning", "motors-moved", message, advice)


def _most_open(diagnosis: Diagnosis, pose: PoseEntry) -> str:
    if pose.name != "home" or len(diagnosis.loops) < 2:
        return ""
    worst = max(diagnosis.loops, key=lambda loop: loop.gap_given)
    return f", most at {worst.name!r} ({brief(worst.gap_given)} m)"


def _value_with_unit(diagnosis: Diagnosis, name: str, value: float) -> str:
    unit = next(freedom.unit for freedom in diagnosis.freedoms if freedom.name == name)
    return f"{value:.3g} {unit}"


def _limit_findings(diagnosis: Diagnosis) -> Iterator[Finding]:
    for freedom in diagnosis.freedoms:
        lower = float("-inf") if freedom.lower is None else freedom.lower
        upper = float("inf") if freedom.upper is None else freedom.upper
        limits = f"[{lower:g}, {upper:g}] {freedom.unit}"
        outside = not lower - _MOVED <= freedom.given <= upper + _MOVED
        if outside and freedom.role == "passive":
            message = f"The home pose gives {freedom.name!r} = {freedom.given:g}, outside {limits}."
            advice = "Give a value within the limits, or widen them."
            yield Finding("warning", "given-outside-limits", message, advice)
        if freedom.home is not None and min(freedom.home - lower, upper - freedom.home) < _AT_LIMIT:
            message = f"{freedom.name!r} is at its limit at home: {freedom.home:g} of {limits}."
            advice = "A home pose inside all limits can be left in every direction."
            yield Finding("note", "at-limit", message, advice)
    endless = [freedom.name for freedom in diagnosis.freedoms if _lacks_limits(freedom)]
    if endless:
        advice = "Sliders and checks then reach as far as numbers do; give limits in the URDF."
        message = f"The motor{'s' * (len(endless) > 1)} {listed_in_words(endless)} has no limits."
        message = message.replace("has", "have") if len(endless) > 1 else message
        yield Finding("note", "no-limits", message, advice)


def _lacks_limits(freedom: FreedomEntry) -> bool:
    unlimited = freedom.lower is None or freedom.upper is None
    kind = JOINT_KINDS.get(freedom.kind)
    return freedom.role == "actuated" and kind is not None and kind.nq == 1 and unlimited


_NO_NEIGHBOUR = (
    "No pose near home closes: a structure, or a singular home, in whole or in part. Rates that "
    "the loops seem to allow there lead nowhere; mobility and generic ranks are not known."
)
_LOOSEN = "Give a home pose from which the machine can move, or check the lengths."


def _isolated(diagnosis: Diagnosis) -> Finding:
    gap = diagnosis.rounding
    if gap is None:
        return Finding("error", "isolated", _NO_NEIGHBOUR, _LOOSEN)
    message = (
        f"No pose near home closes: the loops stay open there by {brief(gap)} m, as rounded "
        "numbers leave them. Mobility and generic ranks are not known."
    )
    return Finding("error", "rounded-numbers", message, all_digits(gap))


def _conditioning(diagnosis: Diagnosis) -> Iterator[Finding]:
    for pose in diagnosis.poses:
        if pose.kind is None or pose.smallest is None or pose.condition is None:
            continue
        home = pose.name == "home"
        severity: Severity = "warning" if home else "note"
        sizes = f"σ_min = {brief(pose.smallest)}, condition {brief(pose.condition)}"
        if pose.kind == "loss":
            message = f"At {pose.name!r} the tool loses a motion, judged on {diagnosis.judged}."
            advice = "J_eq exists, with lower rank in these rows."
            yield Finding("note", "singular-pose", message, advice)
        elif pose.kind == "isolated":
            if home:
                yield _isolated(diagnosis)
        elif pose.kind != "regular":
            message = f"The pose {pose.name!r} is singular, of kind {pose.kind} (K*: {sizes})."
            advice = "Start from a pose off it; pmjac report shows the motion that comes free."
            yield Finding(severity, "singular-pose", message, advice)
        elif pose.smallest < NEAR_SINGULAR:
            message = f"The pose {pose.name!r} is nearly singular (K*: {sizes})."
            advice = "Passive rates are large there, and digits are lost; choose a pose off it."
            yield Finding(severity, "near-singular", message, advice)
        elif home and diagnosis.loops:
            yield Finding("ok", "conditioning", f"K* is regular at home: {sizes}.")


def _reader(diagnosis: Diagnosis) -> Iterator[Finding]:
    for note in diagnosis.notes:
        if note in diagnosis.unread:
            yield Finding("warning", "unread", f"{note}.", _IF_IT_TIES)
        else:
            yield Finding("note", "reader", note)


_IF_IT_TIES = (
    "If it ties bodies together, the machine is another: declare it as a loop that is read."
)
