"""A diagnosis as one page: findings first, then the facts that they rest on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pmjac_pin.studies.check.diagnosis import Diagnosis, FreeMotion
from pmjac_pin.studies.check.diagnosis_parts import Mobility
from pmjac_pin.values.brief import brief
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table

_DASH = "–"
_NO_MOTION = 1e-12  # m or rad
_DIAGNOSIS_LEGEND = (
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
    loops, failed = diagnosis.loops, diagnosis.failure is not None
    columns = {
        "loop": [loop.name for loop in loops],
        "kind": [loop.kind for loop in loops],
        "its joints\nmove": [loop.group or _DASH for loop in loops],
        "rows": [str(len(loop.equations)) for loop in loops],
    }
    if not failed:
        columns["rank"] = [_count_text(loop.rank) for loop in loops]
        columns["needed"] = [_count_text(loop.needed) for loop in loops]
    columns["open by\n[m]"] = [brief(loop.gap_given) for loop in loops]
    if failed:
        columns["alone\n[m]"] = [_brief_text(loop.gap_alone) for loop in loops]
    yield Table.of("", "<<<" + ">" * (len(columns) - 3), columns)
    yield Paragraph(_FAILED_LEGEND if failed else _DIAGNOSIS_LEGEND)


def _mobility(found: Mobility) -> Table:
    rows = [
        ("degrees of freedom of the tree's joints", str(found.freedoms)),
        ("loop equations", str(found.rows)),
        ("independent ones, the rank of [K K*]", _count_text(found.rank)),
        ("mobility, by rank", _count_text(found.mobility)),
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
    poses = diagnosis.poses
    columns = {
        "pose": [pose.name for pose in poses],
        "open by\n[m]": [brief(pose.gap_given) for pose in poses],
        "moved most\n[m or rad]": [_moved_most(pose.moved or {}) for pose in poses],
        "kind": [
            pose.kind or ("open" if diagnosis.failure or pose.failure else _DASH) for pose in poses
        ],
        "σ_min\nof K*": [_brief_text(pose.smallest) for pose in poses],
        "condition": [_brief_text(pose.condition) for pose in poses],
    }
    return Table.of("", "<><<>>", columns)


def _moved_most(moved: Mapping[str, float]) -> str:
    name = max(moved, key=lambda one: (abs(moved[one]), one), default="")
    return f"{name} {moved[name]:+.3g}" if name and abs(moved[name]) > _NO_MOTION else _DASH


def _freedom_table(diagnosis: Diagnosis) -> Table:
    freedoms = diagnosis.freedoms
    columns = {
        "joint": [f"{freedom.name} [{freedom.unit}]" for freedom in freedoms],
        "kind": [freedom.kind for freedom in freedoms],
        "role": ["motor" if one.role == "actuated" else one.role for one in freedoms],
    }
    values = {"file": "given"} if diagnosis.failure else {"home": "home", "moved": "moved"}
    for heading, name in {"lower": "lower", "upper": "upper", **values}.items():
        columns[heading] = [_shown_value(getattr(freedom, name)) for freedom in freedoms]
    return Table.of("Degrees of freedom", "<<<" + ">" * (len(columns) - 3), columns)


def _bodies(diagnosis: Diagnosis) -> Table:
    bodies = diagnosis.bodies
    columns = {
        "body": [body.name for body in bodies],
        "carried by": [body.joint or "ground" for body in bodies],
        "loops that end on it": ["\n".join(body.loops) or _DASH for body in bodies],
        "tool": ["tool" if body.tool else "" for body in bodies],
    }
    tool = ", ".join(diagnosis.tool)
    return Table.of(f"Bodies (tool: {tool}, judged on {diagnosis.judged})", "<<<<", columns)


def _count_text(value: int | None) -> str:
    return _DASH if value is None else str(value)


def _brief_text(value: float | None) -> str:
    return _DASH if value is None else brief(value)


def _shown_value(value: float | None) -> str:
    if value is None:
        return _DASH
    return f"{value:.4g}" if abs(value) > _NO_MOTION else "0"
