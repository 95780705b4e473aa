"""A diagnosis as one page: findings first, then the facts that they rest on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pmjac_pin.studies.check.diagnosis import Diagnosis, FreeMotion
from pmjac_pin.studies.check.diagnosis_parts import Mobility
from pmjac_pin.values.brief import brief
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table

_DASH = "–"
_NO_MOTION = 1e-12  # m or rad
_LEGEND = (
    "rank: of the loop's own rows; needed: what the rank of all loses without it; open by: as the "
    "file has home."
)
_FAILED_LEGEND = "open by: as the file has home; alone: at best, with the other loops left open."


def diagnosis_blocks(diagnosis: Diagnosis) -> Iterator[Block]:
    """Show all of a diagnosis."""
    yield Heading(f"{diagnosis.mechanism}: {_verdict(diagnosis)}")
    if diagnosis.description:
        yield Paragraph(diagnosis.description)
    yield _findings(diagnosis)
    yield Heading("Loops")
    yield from _loop_blocks(diagnosis)
    yield _mobility(diagnosis.mobility)
    yield Paragraph(f"Mobility and ranks rest on {diagnosis.evidence}.")
    yield from _dependent(diagnosis)
    yield from _actuation_blocks(diagnosis)
    yield Heading("Poses and joints")
    yield _poses(diagnosis)
    yield _freedom_table(diagnosis)
    yield _bodies(diagnosis)


def _verdict(diagnosis: Diagnosis) -> str:
    counts = []
    for severity in ("error", "warning", "note"):
        count = sum(finding.severity == severity for finding in diagnosis.findings)
        if count:
            counts.append(f"{count} {severity}{'s' * (count > 1)}")
    return ", ".join(counts) or "ok"


def _findings(diagnosis: Diagnosis) -> Table:
    rows: list[tuple[str, ...]] = []
    for finding in diagnosis.findings:
        rows.append((finding.severity, finding.message))
        if finding.advice:
            rows.append(("", f"→ {finding.advice}"))
    return Table("", ("", ""), tuple(rows), "<<")


def _loop_blocks(diagnosis: Diagnosis) -> Iterator[Block]:
    if not diagnosis.loops:
        yield Paragraph("None.")
        return
    failed = diagnosis.failure is not None
    columns = ("open by\n[m]", "alone\n[m]") if failed else ("rank", "needed", "open by\n[m]")
    rows = []
    for loop in diagnosis.loops:
        alone = [] if loop.gap_alone is None else [brief(loop.gap_alone)]
        ranks = [] if failed else [_count(loop.rank), _count(loop.needed)]
        sizes = (str(len(loop.equations)), *ranks, brief(loop.gap_given), *alone)
        rows.append((loop.name, loop.kind, loop.group or _DASH, *sizes))
    header = ("loop", "kind", "its joints\nmove", "rows", *columns)
    yield Table("", header, tuple(rows), "<<<>" + ">" * len(columns))
    yield Paragraph(_FAILED_LEGEND if failed else _LEGEND)


def _mobility(found: Mobility) -> Table:
    rows = [
        ("degrees of freedom of the tree's joints", str(found.freedoms)),
        ("loop equations", str(found.rows)),
        ("independent ones, the rank of [K K*]", _count(found.rank)),
        ("mobility, by rank", _count(found.mobility)),
        ("Grübler–Kutzbach in space", str(found.gruebler)),
        ("with each loop in its joints' own group", str(found.gruebler_in_groups)),
    ]
    return Table("Mobility", ("", ""), tuple(rows), "<>")


def _dependent(diagnosis: Diagnosis) -> Iterator[Block]:
    if diagnosis.redundancy and diagnosis.redundancy.rows:
        rows = tuple(
            (entry.row, ", ".join(entry.follows_from) or "nothing: it is zero")
            for entry in diagnosis.redundancy.dependent
        )
        yield Table("Rows that follow from others (one choice)", ("row", "from"), rows, "<<")


def _actuation_blocks(diagnosis: Diagnosis) -> Iterator[Block]:
    found = diagnosis.actuation
    if found is None:
        return
    rows = [
        ("motors", str(found.motors)),
        ("independent motor rates that the loops allow", str(len(found.allowed_rates))),
        ("idle passive motions", str(found.idle)),
        ("passive motions that come free at home only", str(found.gained)),
        ("dimension of what the tool feels of these", str(found.felt)),
    ]
    yield Table("Actuation", ("", ""), tuple(rows), "<>")
    if found.free_motions:
        heading = "Passive motions that are free with all motors locked (largest rate 1)"
        columns = ("rates", "bodies that move", "tool")
        motions = tuple(map(_motion_row, found.free_motions))
        yield Table(heading, columns, motions, "<<<")


def _motion_row(motion: FreeMotion) -> tuple[str, ...]:
    rates = (f"{name} {rate:+.3g}" for name, rate in motion.rates.items() if rate)
    moves = f"{brief(motion.tool_linear)} m/s\n{brief(motion.tool_angular)} rad/s"
    return "\n".join(rates), "\n".join(motion.bodies), moves if motion.felt else "rests"


def _poses(diagnosis: Diagnosis) -> Table:
    rows = []
    for pose in diagnosis.poses:
        moved, farthest = max(
            ((abs(by), f"{name} {by:+.3g}") for name, by in (pose.moved or {}).items()),
            default=(0.0, _DASH),
        )
        failed = "open" if diagnosis.failure or pose.failure else _DASH
        rows.append(
            (
                pose.name,
                brief(pose.gap_given),
                farthest if moved > _NO_MOTION else _DASH,
                pose.kind or failed,
                _DASH if pose.smallest is None else brief(pose.smallest),
                _DASH if pose.condition is None else brief(pose.condition),
            )
        )
    header = ("pose", "open by\n[m]", "moved most\n[m or rad]", "kind", "σ_min\nof K*", "condition")
    return Table("", header, tuple(rows), "<><<>>")


def _freedom_table(diagnosis: Diagnosis) -> Table:
    failed = diagnosis.failure is not None
    columns = ("file",) if failed else ("home", "moved")
    rows = []
    for freedom in diagnosis.freedoms:
        values = (freedom.given,) if failed else (freedom.home, freedom.moved)
        rows.append(
            (
                f"{freedom.name} [{freedom.unit}]",
                freedom.kind,
                "motor" if freedom.role == "actuated" else freedom.role,
                *map(_shown_value, (freedom.lower, freedom.upper, *values)),
            )
        )
    header = ("joint", "kind", "role", "lower", "upper", *columns)
    return Table("Degrees of freedom", header, tuple(rows), "<<<>>" + ">" * len(columns))


def _bodies(diagnosis: Diagnosis) -> Table:
    tool = ", ".join(diagnosis.tool)
    return Table(
        f"Bodies (tool: {tool}, judged on {diagnosis.judged})",
        ("body", "carried by", "loops that end on it", "tool"),
        tuple(
            (
                body.name,
                body.joint or "ground",
                _on_lines(body.loops),
                "tool" if body.tool else "",
            )
            for body in diagnosis.bodies
        ),
        "<<<<",
    )


def _on_lines(names: Sequence[str]) -> str:
    return "\n".join(names) or _DASH


def _count(value: int | None) -> str:
    return _DASH if value is None else str(value)


def _shown_value(value: float | None) -> str:
    if value is None:
        return _DASH
    return f"{value:.4g}" if abs(value) > _NO_MOTION else "0"
