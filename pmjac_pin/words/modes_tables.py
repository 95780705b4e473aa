"""The assembly modes as headings, paragraphs and tables."""

from __future__ import annotations

from collections.abc import Iterator

from scipy.spatial.transform import Rotation

from pmjac_pin.studies.certificates.certificate import Certificate
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.homotopy.complex_modes import ComplexModes
from pmjac_pin.studies.homotopy.operation_modes import OperationModes
from pmjac_pin.values.brief import brief
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table
from pmjac_pin.words.modes_report import ModeReport, ModesReport
from pmjac_pin.words.numbers import matrix_numbers
from pmjac_pin.words.tables import motor_line

_ORIENTATION_SIGNS = {1: "+", -1: "-", 0: "0", None: ""}

MODES_LEGEND = (
    "σ is the smallest singular value of K*, relative to the size of [K K*]; share, of the random "
    "starts that led here; proven, that an exact solution is no farther away than this: of all "
    "rows but the dependent ones, which hold to the residual."
)


def modes_blocks(report: ModesReport) -> Iterator[Block]:
    """Show all modes, and what their completeness rests on."""
    yield Heading(modes_title(report))
    if description := report.mechanism.spec.description:
        yield Paragraph(description)
    yield Paragraph(count(report))
    if report.modes:
        yield _modes_table(report)
        yield Paragraph(_legend(report))
        yield _tools(report)
    evidence = report.found.evidence
    yield Paragraph(no_more(evidence))
    if report.solutions is not None:
        yield _solutions(report.solutions, evidence)
    if report.operation_modes:
        yield _operation_modes(report.operation_modes)


def modes_title(report: ModesReport) -> str:
    """Return what is shown: the mechanism and its motor values."""
    return f"Assembly modes of {report.name} at {motor_line(report.motors)}"


def count(report: ModesReport) -> str:
    """Say in a sentence how many modes there are.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> from pmjac_pin.words.modes_report import make_modes_report
    >>> mechanism = pj.load("four_bar")
    >>> modes = pj.assembly_modes(mechanism, [0.9], rng=0)
    >>> count(make_modes_report(mechanism, [0.9], modes))
    '2 assembly modes within the limits of the joints.'
    """
    found = len(report.modes)
    within = "within the limits of the joints" if report.limits else "with limits left aside"
    poses = sum(mode.ways for mode in report.modes)
    turned = f"; {poses} poses, bodies turned over or not" if poses > found else ""
    return f"{found or 'No'} assembly mode{'s' * (found != 1)} {within}{turned}."


def no_more(evidence: Evidence) -> str:
    """Say in a sentence what it rests on that no mode is missing."""
    return f"That there are no more rests on {evidence}."


def _legend(report: ModesReport) -> str:
    if all(mode.ways == 1 for mode in report.modes):
        return MODES_LEGEND
    return f"{MODES_LEGEND[:-1]}; ways, in how many its bodies fit: some turn over unseen."


def _solutions(found: ComplexModes, of_modes: Evidence) -> Paragraph:
    """Say how many solutions there are over the complex numbers."""
    many = "is 1 solution" if found.count == 1 else f"are {found.count} solutions"
    text = f"Over the complex numbers there {many}; {len(found.real)} real, limits left aside; "
    text += f"{found.certified} proven to be there"
    # Where it settles the modes, its evidence has just been told.
    return Paragraph(text + ("." if found.evidence == of_modes else f" ({found.evidence})."))


def _operation_modes(found: OperationModes) -> Paragraph:
    """Say how the solutions hang together."""
    return Paragraph(
        "Operation modes, by how many of the solutions at almost all motor values they have: "
        f"{', '.join(map(str, found.sizes))} ({found.evidence})."
    )


def _modes_table(report: ModesReport) -> Table:
    modes = report.modes
    columns = {
        "mode": [str(mode.number) for mode in modes],
        "residual\n[m]": [f"{mode.configuration.residual_norm:.1e}" for mode in modes],
        "σ": [brief(mode.singularity.smallest) for mode in modes],
        "sign of\ndet K*": [_ORIENTATION_SIGNS[mode.sign] for mode in modes],
        "share\n[%]": [f"{100.0 * mode.share:.2f}" for mode in modes],
        "mirror\nimage": [str(mode.mirror_image or "") for mode in modes],
        "proven\n[rad]": [_existence(mode.certificate) for mode in modes],
    }
    if any(mode.operation_mode for mode in modes):
        columns["oper-\nation\nmode"] = [str(mode.operation_mode or "") for mode in modes]
    if any(mode.ways > 1 for mode in modes):
        columns["ways"] = [str(mode.ways) for mode in modes]
    numbers, columns["which is"] = len(columns), list(map(_mode_names, modes))
    return Table.of("", ">" * numbers + "<", columns)


def _existence(certificate: Certificate) -> str:
    return f"{certificate.existence_radius:.0e}" if certificate else "no"


def _mode_names(mode: ModeReport) -> str:
    kind, found = mode.singularity.kind, mode.configuration.limits_violated
    singular = () if kind == "regular" else (f"singular ({kind})",)
    beyond = tuple(f"{name} beyond its limits" for name in found)
    return ", ".join((*mode.poses, *singular, *beyond))


def _tools(report: ModesReport) -> Table:
    tools = [mode.configuration.tool_pose() for mode in report.modes]
    rotations = Rotation.from_matrix([tool.rotation for tool in tools])
    length = report.mechanism.characteristic_length
    places = matrix_numbers([tool.translation for tool in tools], size=length)
    turns = matrix_numbers(rotations.as_rotvec(), size=1.0)
    rows = zip(report.modes, places, turns, strict=True)
    return Table(
        "Tool in the world: its place, and the turn from the world's axes (angle times axis)",
        ("mode", "position [m]\nx", "\ny", "\nz", "turn [rad]\nx", "\ny", "\nz"),
        tuple((str(mode.number), *place, *turn) for mode, place, turn in rows),
        "<>>>>>>",
    )
