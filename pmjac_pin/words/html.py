"""Blocks as HTML, for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import assert_never

from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table, Verbatim

_SIDES = {"<": "left", ">": "right"}


def html(blocks: Iterable[Block]) -> str:
    """Return blocks as HTML.

    Examples
    --------
    >>> html([Heading("K*"), Paragraph("1 < 2")])
    '<h3>K*</h3><p>1 &lt; 2</p>'
    """
    return "".join(map(_block_html, blocks))


def _block_html(block: Block) -> str:
    match block:
        case Heading():
            return f"<h3>{_escaped_text(block.text)}</h3>"
        case Paragraph():
            return f"<p>{_escaped_text(block.text)}</p>"
        case Verbatim():
            return f"<pre>{escape(block.text)}</pre>"
        case Table():
            return "".join(_table_html(block))
        case _:
            assert_never(block)


def _table_html(table: Table) -> Iterator[str]:
    yield "<table>"
    if table.title:
        yield f'<caption style="text-align:left">{_escaped_text(table.title)}</caption>'
    if any(table.header):
        yield _row_html("th", table.header, table.align)
    for row in table.rows:
        yield _row_html("td", row, table.align)
    yield "</table>"


def _row_html(tag: str, cells: Sequence[str], align: str) -> str:
    made = (
        f'<{tag} style="text-align:{_SIDES[side]}">{_escaped_text(cell)}</{tag}>'
        for cell, side in zip(cells, align, strict=True)
    )
    return f"<tr>{''.join(made)}</tr>"


def _escaped_text(text: str) -> str:
    return escape(text).replace("\n", "<br>")
