"""Tables in Markdown: cells stay cells."""

from __future__ import annotations

import re

import pytest

from pmjac_pin.words.blocks import Table
from pmjac_pin.words.markdown import markdown_table


def test_numbers_stand_to_the_right():
    table = Table("not shown", ("name", "degrees\nof freedom"), (("a", "1"), ("b", "2")), "<>")
    assert markdown_table(table).splitlines() == [
        "| name | degrees of freedom |",
        "| --- | ---: |",
        "| a | 1 |",
        "| b | 2 |",
    ]


@pytest.mark.parametrize(
    "text", ["a|b", "K* and J*", r"back\slash", "<b>", "[x](y)", "`c`", "a\nb"]
)
def test_markup_in_a_cell_is_text(text):
    [_, _, row] = markdown_table(Table("", ("x",), ((text,),), "<")).splitlines()
    cell = row.removeprefix("| ").removesuffix(" |")
    assert re.sub(r"\\(.)", r"\1", cell) == text.replace("\n", " ")
    assert not re.search(r"(?<!\\)(?:\\\\)*[|*`<\[]", cell)
