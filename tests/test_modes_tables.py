"""The assembly modes as tables."""

from __future__ import annotations

import mechanisms
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.words.blocks import Heading, Paragraph, Table
from pmjac_pin.words.modes_report import make_modes_report
from pmjac_pin.words.modes_tables import modes_blocks


def blocks_of(mechanism, theta, **options):
    modes = pj.assembly_modes(mechanism, theta, rng=0, **options)
    report = make_modes_report(mechanism, theta, modes, limits=options.get("limits", True))
    return list(modes_blocks(report))


def texts(blocks):
    return [block.text for block in blocks if isinstance(block, Heading | Paragraph)]


def test_one_row_a_mode():
    blocks = blocks_of(loaded("four_bar"), [0.9])
    first, second = (block for block in blocks if isinstance(block, Table))
    assert [row[0] for row in first.rows] == [row[0] for row in second.rows] == ["1", "2"]
    assert [row[3] for row in first.rows] == ["-", "+"]
    assert [row[-1] for row in first.rows] == ["", "home"]
    assert second.rows[1][1:4] == ("1.5452", "1.9653", "0.0000")
    assert second.rows[1][4:] == ("0.0000", "0.0000", "0.9075")


def test_the_last_word_is_on_completeness():
    blocks = blocks_of(loaded("four_bar"), [0.9])
    assert texts(blocks)[-1].startswith(
        "That there are no more rests on proof: exactly 2, by interval"
    )


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        (True, "2 assembly modes within the limits of the joints."),
        (False, "2 assembly modes with limits left aside."),
    ],
)
def test_how_many_and_whether_within_limits(limits, expected):
    assert expected in texts(blocks_of(loaded("four_bar"), [0.9], limits=limits))


def test_none_are_none():
    blocks = blocks_of(mechanisms.rocker_rocker(), [2.5])
    assert "No assembly modes within the limits of the joints." in texts(blocks)
    assert not [block for block in blocks if isinstance(block, Table)]
