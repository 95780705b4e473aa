"""Pages: what a value shows of itself, as blocks, as text and as HTML."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from pmjac_pin.configuration import Configuration
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.rates.singularity import Singularity
from pmjac_pin.rates.split import SplitJacobian
from pmjac_pin.studies.check.diagnosis import Diagnosis
from pmjac_pin.studies.modes.assembly_modes import AssemblyModes
from pmjac_pin.studies.reach.reached import Reached
from pmjac_pin.studies.reach.working_modes import WorkingModes
from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table
from pmjac_pin.words.diagnosis_tables import diagnosis_blocks
from pmjac_pin.words.html import html
from pmjac_pin.words.labelled_matrix import LabelledMatrix
from pmjac_pin.words.mechanism_page import mechanism_blocks
from pmjac_pin.words.modes_tables import no_more
from pmjac_pin.words.numbers import matrix_numbers
from pmjac_pin.words.rate_blocks import jacobian_blocks, principal_blocks, rank_blocks
from pmjac_pin.words.reach_tables import reached_blocks, working_modes_blocks
from pmjac_pin.words.report import Report, report
from pmjac_pin.words.tables import joints_table, matrix_blocks, report_blocks, title
from pmjac_pin.words.terminal import plain_text

_PAGE_WIDTH = 100  # characters of a line where a page is printed


def text_page(value: object) -> str:
    """Return a value's page as text."""
    return plain_text(blocks_of(value), _PAGE_WIDTH)


def html_page(value: object) -> str:
    """Return a value's page as HTML."""
    return html(blocks_of(value))


def blocks_of(value: object) -> Iterable[Block]:
    """Return what a value shows of itself.

    Raises
    ------
    TypeError
        It has no page.
    """
    for kind, blocks in _PAGE_BLOCKS.items():
        if isinstance(value, kind):
            return blocks(value)
    raise TypeError(f"no page shows a {type(value).__name__}")


def _pose_page(found: Report) -> Iterator[Block]:
    yield Heading(title(found))
    yield joints_table(found)
    if found.refusal:
        yield Paragraph(f"J_eq does not exist here: {found.refusal}")
    yield from matrix_blocks(found, ("Jv_eq", "Jw_eq"))


def _modes_page(modes: AssemblyModes) -> Iterator[Block]:
    yield Heading(f"{len(modes)} assembly mode{'s' * (len(modes) != 1)}")
    if modes:
        yield _table_of_modes(modes)
    yield Paragraph(no_more(modes.evidence))


def _table_of_modes(modes: AssemblyModes) -> Table:
    mechanism, of_tool = modes[0].mechanism, tuple[str, ...]()
    places: list[list[str]] = [[] for _ in modes]
    if not mechanism.spec.tool.is_none:
        found = [mode.tool_pose().translation for mode in modes]
        places = matrix_numbers(found, mechanism.characteristic_length)
        of_tool = ("tool x\n[m]", "y\n[m]", "z\n[m]")
    rows = tuple(
        (str(number), *place, mode.singularity().kind, f"{100.0 * share:.3g}", str(ways))
        for number, (mode, place, share, ways) in enumerate(
            zip(modes, places, modes.shares, modes.ways, strict=True), start=1
        )
    )
    header = ("mode", *of_tool, "kind", "share\n[%]", "ways")
    return Table("", header, rows, ">" * (1 + len(of_tool)) + "<>>")


_PAGE_BLOCKS: Mapping[type, Callable[[Any], Iterable[Block]]] = {
    Diagnosis: diagnosis_blocks,
    Report: report_blocks,
    Configuration: lambda configuration: _pose_page(report(configuration)),
    AssemblyModes: _modes_page,
    WorkingModes: working_modes_blocks,
    Reached: reached_blocks,
    LabelledMatrix: lambda matrix: [matrix.block()],
    Mechanism: mechanism_blocks,
    SplitJacobian: jacobian_blocks,
    Ellipsoid: principal_blocks,
    Singularity: rank_blocks,
}
