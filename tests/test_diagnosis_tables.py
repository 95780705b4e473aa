"""The page of `pmjac check`: nothing too wide, nothing lost, of whole and broken mechanisms."""

from __future__ import annotations

import io

import mechanisms
import pytest
from rich.cells import cell_len
from rich.console import Console

import pmjac_pin as pj
from pmjac_pin.words.diagnosis_tables import diagnosis_blocks
from pmjac_pin.words.terminal import draw


def drawn(diagnosis, width, encoding="utf-8"):
    file = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    console = Console(file=file, width=width, markup=False, highlight=False, emoji=False)
    with console.capture() as capture:
        draw(console, diagnosis_blocks(diagnosis))
    return capture.get()


def broken():
    return pj.check("four_bar", parameters={"l1": 100.0})


MADE = {
    "broken": broken,
    "rssr": lambda: pj.check(mechanisms.rssr("rod_side")),
    "over_actuated": lambda: pj.check(mechanisms.over_actuated_four_bar()),
    "three_rps": lambda: pj.check("three_rps"),
    "ur5": lambda: pj.check("ur5"),
}


@pytest.fixture(scope="module", params=MADE)
def diagnosis(request):
    return MADE[request.param]()


@pytest.mark.parametrize("width", [60, 80, 120])
def test_no_line_is_too_long(diagnosis, width):
    text = drawn(diagnosis, width)
    assert max(cell_len(line) for line in text.splitlines()) <= width
    assert "…" not in text


def test_everything_is_on_the_page(diagnosis):
    text = " ".join(drawn(diagnosis, 300).split())
    for finding in diagnosis.findings:
        assert f"{finding.severity} {finding.message}" in text
        assert f"→ {finding.advice}" in text or not finding.advice
    for item in (*diagnosis.loops, *diagnosis.freedoms, *diagnosis.bodies, *diagnosis.poses):
        assert item.name in text


def test_ascii_loses_nothing(diagnosis):
    assert "?" not in drawn(diagnosis, 80, "ascii")


def test_the_title_counts_what_is_wrong():
    assert drawn(broken(), 80).startswith("four_bar: 1 error, 1 note\n")
    assert drawn(pj.check("three_rps"), 80).startswith("three_rps: 1 note\n")
    assert drawn(pj.check(mechanisms.rssr("rod_side")), 80).startswith("test: 1 error, 1 warning\n")


def test_what_needs_closed_loops_is_not_shown_where_they_are_open():
    text = drawn(broken(), 80)
    assert "Actuation" not in text
    assert "alone" in text
    assert "needed" not in text
