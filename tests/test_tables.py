"""Tables: numbers never cut, lines never too long, and readable without Unicode."""

from __future__ import annotations

import io
import math
import re

import mechanisms
import pytest
from mechanisms import loaded
from rich.cells import cell_len
from rich.console import Console

import pmjac_pin as pj
from pmjac_pin.values.brief import brief
from pmjac_pin.words.blocks import Heading, Paragraph, Table, Verbatim
from pmjac_pin.words.numbers import matrix_numbers, number
from pmjac_pin.words.tables import (
    TITLES,
    ellipsoid_table,
    matrix_blocks,
    report_blocks,
    singular_values_table,
)
from pmjac_pin.words.terminal import draw, new_console, one_line, to_ascii, write

LONG = "the_joint_that_somebody_gave_a_name_of_far_more_than_eighty_characters_in_one_word_alone_99"


def drawn(blocks, width=80, encoding="utf-8"):
    file = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    console = Console(file=file, width=width, markup=False, highlight=False, emoji=False)
    with console.capture() as capture:
        draw(console, blocks)
    return capture.get()


def table(count, width_of_name=4, rows=3):
    names = tuple(f"{'j' * width_of_name}{k}\n[rad]" for k in range(count))
    cells = tuple((f"row {i}", *(f"{i}.{k:04d}" for k in range(count))) for i in range(rows))
    return Table("A title", ("", *names), cells, "<" + ">" * count)


@pytest.fixture(scope="module")
def reports():
    return {name: pj.report(loaded(name).home, pose="home") for name in mechanisms.CATALOGUE}


@pytest.mark.parametrize("width", [24, 30, 40, 60, 80, 120])
def test_every_column_of_numbers_and_words_is_there(width):
    """Where a terminal is narrow, a table is told in parts: no column, no entry is left out."""
    names = ("mode", "share\n[%]", "kind", "smallest", "which is")
    rows = tuple((str(k), f"{k}1.5", "regular", f"0.{k}25", f"home{k}") for k in (1, 2, 3))
    text = drawn([Table("", names, rows, ">><><")], width)
    assert max(cell_len(line) for line in text.splitlines()) <= width
    words = set(text.split())
    assert {word for name in names for word in name.split()} <= words
    assert {entry for row in rows for entry in row} <= words


@pytest.mark.parametrize("width", mechanisms.mostly_slow([30, 60, 80, 120, 200], (30, 80)))
@pytest.mark.parametrize("name", mechanisms.mostly_slow(mechanisms.CATALOGUE))
def test_no_line_is_too_long_and_no_number_is_cut(reports, name, width):
    report = reports[name]
    text = drawn(report_blocks(report), width)
    assert max(cell_len(line) for line in text.splitlines()) <= width
    assert "…" not in text
    for key in ("K", "K_star", "Jv", "Jv_star"):
        matrix = report.matrices[key]
        if matrix.rows and matrix.columns:
            shown = sorted(
                entry for row in matrix_numbers(matrix.values, matrix.size) for entry in row
            )
            [block] = [b for b in matrix_blocks(report, (key,)) if isinstance(b, Table)]
            alone = drawn([block], width)
            found = re.findall(r"-?\d\.\d{3,4}(?:e-\d\d)?\b|(?<=\s)0(?=\s)", alone)
            assert sorted(found) == shown


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_rounding_is_shown_as_zero(reports, name):
    report = reports[name]
    keys = [key for key in TITLES if report.matrices[key] is not None]
    blocks = [*matrix_blocks(report, tuple(keys)), singular_values_table(report)]
    blocks += [block for block in report_blocks(report) if "Tool" in getattr(block, "title", "")]
    assert not re.search(r"e-[1-9]\d", drawn(blocks))


@pytest.mark.parametrize("name", mechanisms.mostly_slow(mechanisms.CATALOGUE))
def test_ascii_tables_lose_nothing(reports, name):
    text = drawn(report_blocks(reports[name]), encoding="ascii")
    assert text.isascii()
    assert "?" not in text
    assert max(map(len, text.splitlines())) <= 80


def test_columns_are_aligned(reports):
    [block] = matrix_blocks(reports["three_rps_ss"], ("Jv_eq",))
    _title, names, units, _rule, *rows = drawn([block]).rstrip().splitlines()
    ends = [match.end() for match in re.finditer(r"\S+", names)]
    assert [match.end() for match in re.finditer(r"\S+", units)] == ends
    for row in rows:
        assert [match.end() for match in re.finditer(r"\S+", row)][2:] == ends


def test_a_matrix_says_its_name_rows_columns_and_units(reports):
    [block] = matrix_blocks(reports["three_rps_ss"], ("Jw_eq",))
    text = drawn([block])
    assert text.startswith(TITLES["Jw_eq"])
    assert re.search(r"l1 +l2 +l3\s*\n +\[m/s\] +\[m/s\] +\[m/s\]", text)
    assert "ω_x [rad/s]    0.0000   1.3333   -1.3333" in text


def test_wide_matrices_are_folded_evenly():
    text = drawn([table(9, 10)])
    assert [len(re.findall("j+", line)) for line in text.splitlines() if "jj" in line] == [4, 5]
    assert text.count("row 0") == 2


def test_very_long_names_are_folded_not_cut():
    names = tuple(f"{LONG}{k}\n[rad]" for k in range(6))
    wide = Table("", ("", *names), ((LONG, *["-0.1234"] * 6),), "<" + ">" * 6)
    text = drawn([wide])
    assert max(map(len, text.splitlines())) <= 80
    assert text.count("-0.1234") == 6


@pytest.mark.parametrize("width", [24, 30, 40, 50, 60, 80])
@pytest.mark.parametrize("words", [0, 1, 3])
def test_names_that_begin_alike_stay_distinct(width, words):
    """In each part of a table every name is whole, folded or not."""
    names = [f"stewart_gough{end}" for end in ("", "_dietmaier", "_dietmaier_2", "_of_points")]
    header = ("name", "freedom", "motors", "loops\n(rows)", *["what it is"] * words)
    rows = tuple((name, "6", "6", "6 (18)", *["a platform on legs"] * words) for name in names)
    text = drawn([Table("", header, rows, "<>>>" + "<" * words)], width)
    for part in text.split("\n\n"):
        _, _, below = part.rpartition("──\n")
        assert "".join(re.findall(r"^\S+", below, re.MULTILINE)) == "".join(names)


def test_words_are_wrapped_in_their_own_column():
    words = Table("", ("name", "meaning"), (("a", "many words " * 20),), "<<")
    lines = drawn([words], 40).splitlines()
    assert max(map(len, lines)) <= 40
    assert len(lines) > 6
    assert all(line.startswith("       many") for line in lines[3:])


def test_open_chains_have_no_empty_tables(reports):
    text = drawn(report_blocks(reports["serial_2r"]))
    assert "K*" not in text.split("Loop closure")[1].split("Equivalent")[0]
    assert "Nothing is passive: [J_v]eq = J_v and [J_ω]eq = J_ω." in text


def test_a_singular_pose_says_why_and_what_is_free():
    home = mechanisms.over_actuated_four_bar().home
    text = drawn(report_blocks(pj.report(home)))
    assert "J_eq does not exist here: the loops forbid the motor rates" in text
    assert "Motor rates that the loops forbid" in text
    assert "Φ = " not in text


def test_free_motions_have_largest_rate_one():
    text = drawn(report_blocks(pj.report(mechanisms.rssr().home)))
    rates = re.findall(r"^(?:psi|rx|ry|rz) \[rad/s\] +(\S+)$", text, re.MULTILINE)
    assert max(abs(float(rate)) for rate in rates) == 1.0
    assert "K* is 3 × 4, not square: it has no determinant." in text


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ([1.0, -2.34567], ["1.0000", "-2.3457"]),
        ([1.0, 1e-17, -0.0], ["1.0000", "0.0000", "0.0000"]),
        ([1.0, -4e-5], ["1.0000", "-4.000e-05"]),
        ([1.0, 5e-5], ["1.0000", "0.0001"]),
        ([1e-6, 2e-7, 0.0], ["1.000e-06", "2.000e-07", "0"]),
        ([1e6, 1.0], ["1.000e+06", "1.000e+00"]),
        ([0.0, 0.0], ["0.0000", "0.0000"]),
        ([math.inf, 1.0, -math.inf, math.nan], ["∞", "1.0000", "-∞", "nan"]),
        ([], []),
    ],
)
def test_numbers(given, expected):
    assert matrix_numbers([given]) == [expected]


def test_single_numbers():
    assert number(1e-17) == "1.000e-17"
    assert (brief(0.0), brief(math.inf), brief(1.23456e-9)) == ("0", "∞", "1.23e-09")


def test_text_of_others_can_do_no_harm():
    blocks = [Heading("a\x1b[31m"), Paragraph("[bold]b[/bold] :smile:\ttab"), Verbatim("c\x07")]
    text = drawn(blocks)
    assert all(character.isprintable() for character in text.replace("\n", ""))
    assert "[bold]b[/bold] :smile:" in text


def test_verbatim_is_not_wrapped():
    path = "/a b/" + "x" * 200 + "é.png"
    assert drawn([Verbatim(path)]).rstrip("\n") == path


def test_one_line():
    assert one_line("a\n  b\r\nc\x1b") == "a b c\\x1b"


def test_to_ascii():
    assert (
        to_ascii("Φ = −K*⁻¹ K, m⁶/rad³, 3 × 3, ∞, 机") == "Phi = -K*^-1 K, m^6/rad^3, 3 x 3, inf, ?"
    )


def test_write_drops_blanks_at_line_ends(capsys):
    write("a  \n b \n")
    assert capsys.readouterr().out == "a\n b\n"


def test_write_survives_what_the_encoding_cannot_hold(monkeypatch):
    stream = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr("sys.stdout", stream)
    write("é\udcff\n")
    assert stream.buffer.getvalue() == b"\\xe9\\udcff\n"


def test_without_standard_output_nothing_is_written(monkeypatch):
    monkeypatch.setattr("sys.stdout", None)
    with pytest.raises(OSError, match="standard output"):
        write("a")


@pytest.mark.parametrize(("no_color", "colored"), [("", True), ("1", False)])
def test_no_color(monkeypatch, no_color, colored):
    monkeypatch.setenv("NO_COLOR", no_color)
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm-256color")
    console = new_console()
    with console.capture() as capture:
        draw(console, [Heading("title"), table(2)])
    assert ("\x1b[" in capture.get()) is colored


def test_directions_that_are_any_are_not_shown():
    """A Delta's plate never turns: three radii are zero, and have no directions."""
    home = loaded("delta").home
    table = ellipsoid_table("turning", pj.report(home).ellipsoids["angular"])
    assert [row[2:] for row in table.rows] == [("-", "-", "-")] * 3
    velocity = ellipsoid_table("moving", pj.report(home).ellipsoids["velocity"])
    assert all("-" not in row[2:] for row in velocity.rows)
