"""Findings about what the motors command: rates that are forbidden, motions that are free."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from pmjac_pin.rates.factorisation import RANK_TOLERANCE
from pmjac_pin.studies.check.diagnosis import Diagnosis, Finding, FreeMotion, Severity
from pmjac_pin.values.brief import brief

_MOST_LISTED = 6  # listed in one sentence
_FELT_BY_ROUNDING = 1e-12  # m or rad
#: Joints of several degrees of freedom that `locked` holds.
_LOCKABLE = ("floating", "planar", "spherical")


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
        return f"{first!r} together with {listed_in_words(others)}" if others else repr(first)
    return f"{listed_in_words(ahead)} against {listed_in_words(back)}"


def listed_in_words(names: Sequence[str]) -> str:
    """Return names in quotes, joined by commas and an "and"; long lists are cut."""
    quoted = list(map(repr, names[:_MOST_LISTED]))
    if len(names) > _MOST_LISTED:
        quoted.append(f"{len(names) - _MOST_LISTED} more")
    return " and ".join(filter(None, (", ".join(quoted[:-1]), quoted[-1])))


def forbidden_findings(diagnosis: Diagnosis) -> Iterator[Finding]:
    """Say which motor rates the loops forbid, and which motors are too many."""
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
        enough = f": {listed_in_words(actuation.sufficient)} determine the others"
        enough = enough.replace("determine", "determines") if allowed == 1 else enough
        motors = f"{count} of the {actuation.motors} motors"
        advice = (
            f"Declare {motors} passive{enough}; no J_eq of all rates till then. "
            "`configuration.allowed_jacobian()` is that of the rates that fit."
        )
    else:
        message += ". No motor can move: it is a structure"
        advice = "Check its lengths and axes, or make a loop's joint free; no J_eq till then."
    yield Finding("error", "over-actuated", f"{message}.", advice)


def _rates(rates: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {rate:+.3g}" for name, rate in rates.items() if rate)


def free_findings(diagnosis: Diagnosis) -> Iterator[Finding]:
    """Say what moves freely with all motors locked."""
    actuation = diagnosis.actuation
    if actuation is None:
        return
    alone = {freedom.name: freedom for freedom in diagnosis.freedoms if not freedom.loops}
    loose: dict[tuple[str, ...], bool] = {}  # whether the tool feels it, by what is loose
    for motion in actuation.free_motions:
        moving = [name for name, rate in motion.rates.items() if rate]
        if set(moving) <= alone.keys():
            names = tuple(dict.fromkeys(alone[name].joint for name in moving))
            loose[names] = loose.get(names, False) or motion.felt
        else:
            units = {freedom.name: freedom.unit for freedom in diagnosis.freedoms}
            yield _idle(moving, motion, units)
    kinds = Counter((freedom.joint, freedom.kind) for freedom in diagnosis.freedoms)
    several = {joint: (kind, count) for (joint, kind), count in kinds.items() if count > 1}
    for names, felt in loose.items():
        yield _loose(names, felt, [several[name] for name in names if name in several])


def _loose(joints: Sequence[str], felt: bool, several: Sequence[tuple[str, int]]) -> Finding:
    what = "".join(f" ({kind}, {count} degrees of freedom)" for kind, count in several)
    message = f"{listed_in_words(joints)}{what} is passive and in no loop: nothing holds it"
    advice = _holding_advice(joints, several)
    if felt:
        advice += "; no J_eq till then."
        return Finding("error", "free-joint", f"{message}, and the tool moves with it.", advice)
    advice += "." if several else ", or make it fixed."
    return Finding("warning", "free-joint", f"{message}; the tool does not feel it.", advice)


def _holding_advice(joints: Sequence[str], several: Sequence[tuple[str, int]]) -> str:
    """Say how to hold what is loose, or what makes its motion an input."""
    if not several:
        return "Name it under `actuated`, or close a loop over it"
    if all(kind in _LOCKABLE for kind, _ in several):
        listed = ", ".join(f'"{name}"' for name in joints)
        line = f"`--locked {','.join(joints)}` (`locked=[{listed}]` of `load`)"
        inputs = "name it under `actuated`, so that its velocities are inputs"
        return f"Hold it where it stands with {line}, {inputs}, or close a loop over it"
    return "Close a loop over it, or make it fixed"


def _idle(joints: Sequence[str], motion: FreeMotion, units: Mapping[str, str]) -> Finding:
    move = "turns or slides" if len(joints) == 1 else "turn or slide"
    moving = f"{listed_in_words(joints)} {move} freely with all motors locked"
    what = f"{moving}, moving {listed_in_words(motion.bodies)}"
    largest = max(motion.rates, key=lambda name: abs(motion.rates[name]))
    size = (
        f"{brief(motion.tool_linear)} m and {brief(motion.tool_angular)} rad for each "
        f"{units[largest]} of {largest!r}"
    )
    if motion.felt:
        message = f"Under-actuated: {what}, and the tool feels it: {size}."
        one = f"one of them a motor ({largest!r}, for instance)" if joints[1:] else "it a motor"
        advice = f"Make {one}, or put the tool on a body that stays at rest; no J_eq till then."
        return Finding("error", "under-actuated", message, advice)
    advice = "Harmless for J_eq, as for a rod that spins between two ball joints."
    hardly = max(motion.tool_linear, motion.tool_angular) > _FELT_BY_ROUNDING
    felt = f"the tool hardly feels it: {size}" if hardly else "the tool does not feel it"
    return Finding("note", "idle-motion", f"Idle: {what}; {felt}.", advice)


def tool_row_findings(diagnosis: Diagnosis) -> Iterator[Finding]:
    """Say where the tool moves in fewer ways than it could: other rows may be meant, or bodies."""
    actuation, rows = diagnosis.actuation, diagnosis.judged
    if actuation is None or diagnosis.tool_rank is None:
        return
    if rows.is_whole:
        if not diagnosis.tool_rank and actuation.allowed_rates:
            message = (
                f"What the loops allow moves the tool by less than {RANK_TOLERANCE:g} of the "
                "machine's size, if at all: it counts as at rest."
            )
            yield Finding("warning", "tool-rests", message, "Is this the body that is to move?")
        return
    most = min(len(rows.names), len(actuation.allowed_rates))
    if diagnosis.tool_rank < most:
        ways = f"{diagnosis.tool_rank or 'no'} way{'s' * (diagnosis.tool_rank > 1)}"
        message = f"Judged on {rows}, the tool moves in {ways}, where {most} would be possible."
        advice = "Are these the rows that it is there to move, and in these axes?"
        severity: Severity = "note" if diagnosis.tool_rank else "warning"
        yield Finding(severity, "tool-rows", message, advice)
