"""Findings: what the facts of a diagnosis mean, in words, and what to do about it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from pmjac_pin.model.joint_kinds import JOINT_KINDS
from pmjac_pin.model.rounded_numbers import wider_tolerance
from pmjac_pin.model.spec import LARGEST_TOLERANCE
from pmjac_pin.studies.check.diagnosis import Diagnosis, Finding, FreeMotion, PoseEntry, Severity
from pmjac_pin.studies.check.diagnosis_parts import Freedom
from pmjac_pin.studies.check.mobility_findings import count_findings, redundancy_findings
from pmjac_pin.studies.check.number_findings import all_digits, number_findings
from pmjac_pin.values.brief import brief

_ORDER = ("error", "warning", "note", "ok")
WIDE_OPEN = 0.1  # of the characteristic length: beyond, which assembly mode is found is chance
NEAR_SINGULAR = 1e-3  # of the size of [K K*]: passive rates a thousand times the motors'
_MOVED = 1e-9  # m or rad
_AT_LIMIT = 1e-6  # m or rad
_MOST_NAMES = 6  # listed in one sentence


def find(diagnosis: Diagnosis) -> tuple[Finding, ...]:
    """Return what there is to say about a diagnosis, the worst first."""
    rules = (
        _failure,
        _assembly,
        _limits,
        _forbidden,
        _free,
        _tool_rows,
        _conditioning,
        redundancy_findings,
        count_findings,
        number_findings,
        _reader,
    )
    findings = [finding for rule in rules for finding in rule(diagnosis)]
    return tuple(sorted(findings, key=lambda finding: _ORDER.index(finding.severity)))


def in_words(rates: Mapping[str, float]) -> str:
    """Say a direction of rates in words, leaving out what is below a hundredth of the largest.

    Examples
    --------
    >>> in_words({"a": 0.8, "b": -0.6, "c": 0.0})
    "'a' against 'b'"
    >>> in_words({"a": 0.8, "b": 0.6}), in_words({"a": 1.0})
    ("'a' together with 'b'", "'a'")
    """
    largest = max(map(abs, rates.values()))
    moving = {name: rate for name, rate in rates.items() if abs(rate) > 1e-2 * largest}
    ahead = [name for name, rate in moving.items() if rate > 0.0]
    back = [name for name, rate in moving.items() if rate < 0.0]
    if not (ahead and back):
        first, *others = ahead or back
        return f"{first!r} together with {listed(others)}" if others else repr(first)
    return f"{listed(ahead)} against {listed(back)}"


def listed(names: Sequence[str]) -> str:
    """Return names in quotes, joined by commas and an "and"; long lists are cut."""
    quoted = list(map(repr, names[:_MOST_NAMES]))
    if len(names) > _MOST_NAMES:
        quoted.append(f"{len(names) - _MOST_NAMES} more")
    return " and ".join(filter(None, (", ".join(quoted[:-1]), quoted[-1])))


def _failure(diagnosis: Diagnosis) -> Iterator[Finding]:
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
            f"The loop{plural} {listed(stuck)} did not close from here or around even alone, all "
            "joints free: "
            "check its frames, the lengths along it and its joints' limits."
        )
    else:
        cause = (
            "Each loop closes alone, all together did not: check the lengths that they share, or "
            "give joint values nearer to a closed pose."
        )
    if failure and failure.gap is not None and failure.gap <= LARGEST_TOLERANCE:
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
        move = _value(diagnosis, farthest, moved[farthest])
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
        moves = ", ".join(f"{name!r} by {_value(diagnosis, name, moved[name])}" for name in forced)
        sought = "was not found to close with its motors where the file puts them"
        message = f"{what} {sought}; moved: {moves}."
        advice = "Give motor values that can be reached, or check the lengths."
        yield Finding("warning", "motors-moved", message, advice)


def _most_open(diagnosis: Diagnosis, pose: PoseEntry) -> str:
    if pose.name != "home" or len(diagnosis.loops) < 2:
        return ""
    worst = max(diagnosis.loops, key=lambda loop: loop.gap_given)
    return f", most at {worst.name!r} ({brief(worst.gap_given)} m)"


def _value(diagnosis: Diagnosis, name: str, value: float) -> str:
    unit = next(freedom.unit for freedom in diagnosis.freedoms if freedom.name == name)
    return f"{value:.3g} {unit}"


def _limits(diagnosis: Diagnosis) -> Iterator[Finding]:
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
        message = f"The motor{'s' * (len(endless) > 1)} {listed(endless)} has no limits."
        message = message.replace("has", "have") if len(endless) > 1 else message
        yield Finding("note", "no-limits", message, advice)


def _lacks_limits(freedom: Freedom) -> bool:
    unlimited = freedom.lower is None or freedom.upper is None
    kind = JOINT_KINDS.get(freedom.kind)
    return freedom.role == "actuated" and kind is not None and kind.nq == 1 and unlimited


def _forbidden(diagnosis: Diagnosis) -> Iterator[Finding]:
    actuation = diagnosis.actuation
    if actuation is None:
        return
    count, allowed = len(actuation.forbidden_rates), len(actuation.allowed_rates)
    if not count:
        if not actuation.felt:
            motors = "The motor commands" if actuation.motors == 1 else "The motors command"
            message = f"{motors} every motion of the tool, and no loop forbids one."
            yield Finding("ok", "actuation", message)
        return
    words = "; ".join(f"{in_words(rates)} ({_rates(rates)})" for rates in actuation.forbidden_rates)
    message = f"Over-actuated by {count}: the loops forbid {words}"
    if allowed:
        rates = "; or ".join(_rates(rates) for rates in actuation.allowed_rates)
        message += f". What they allow is spanned by {rates}"
        enough = f": {listed(actuation.sufficient)} determine the others"
        enough = enough.replace("determine", "determines") if allowed == 1 else enough
    else:
        message += ". No motor can move: it is a structure"
        enough = ""
    advice = f"Declare {count} of the {actuation.motors} motors passive{enough}; no J_eq till then."
    yield Finding("error", "over-actuated", f"{message}.", advice)


def _rates(rates: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {rate:+.3g}" for name, rate in rates.items() if rate)


def _free(diagnosis: Diagnosis) -> Iterator[Finding]:
    actuation = diagnosis.actuation
    if actuation is None:
        return
    alone = {freedom.name for freedom in diagnosis.freedoms if not freedom.loops}
    for motion in actuation.free_motions:
        joints = [name for name, rate in motion.rates.items() if rate]
        if set(joints) <= alone:
            yield _loose(joints, motion)
        else:
            yield _idle(joints, motion)


def _loose(joints: Sequence[str], motion: FreeMotion) -> Finding:
    message = f"{listed(joints)} is passive and in no loop: nothing holds it"
    if motion.felt:
        advice = "Name it under `actuated`, or close a loop over it; no J_eq till then."
        return Finding("error", "free-joint", f"{message}, and the tool moves with it.", advice)
    advice = "Name it under `actuated`, close a loop over it, or make it fixed."
    return Finding("warning", "free-joint", f"{message}; the tool does not feel it.", advice)


def _idle(joints: Sequence[str], motion: FreeMotion) -> Finding:
    moving = f"{listed(joints)} turn or slide freely with all motors locked"
    what = f"{moving}, moving {listed(motion.bodies)}"
    if motion.felt:
        largest = max(motion.rates, key=lambda name: abs(motion.rates[name]))
        message = f"Under-actuated: {what}, and the tool feels it."
        advice = (
            f"Make one of them a motor ({largest!r}, for instance), or put the tool on a body that "
            "stays at rest; no J_eq till then."
        )
        return Finding("error", "under-actuated", message, advice)
    advice = "Harmless for J_eq, as for a rod that spins between two ball joints."
    return Finding("note", "idle-motion", f"Idle: {what}; the tool does not feel it.", advice)


_NO_NEIGHBOUR = (
    "No pose near home closes: a structure, or a singular home, in whole or in part. Rates that "
    "the loops seem to allow there lead nowhere; mobility and generic ranks are not known."
)
_LOOSEN = "Give a home pose from which the machine can move, or check the lengths."


def _tool_rows(diagnosis: Diagnosis) -> Iterator[Finding]:
    """Say where the judged rows move in fewer ways than they could: others may be meant."""
    actuation, rows = diagnosis.actuation, diagnosis.judged
    if actuation is None or diagnosis.tool_rank is None or rows.is_whole:
        return
    most = min(len(rows.names), len(actuation.allowed_rates))
    if diagnosis.tool_rank < most:
        ways = f"{diagnosis.tool_rank or 'no'} way{'s' * (diagnosis.tool_rank > 1)}"
        message = f"Judged on {rows}, the tool moves in {ways}, where {most} would be possible."
        advice = "Are these the rows that it is there to move, and in these axes?"
        severity: Severity = "note" if diagnosis.tool_rank else "warning"
        yield Finding(severity, "tool-rows", message, advice)


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
