"""Blocks as HTML, for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape

from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table, Verbatim

_SIDES = {"<": "left", ">": "right"}


def html(blocks: Iterable[Block]) -> str:
    """Return blocks as HTML.

    Examples
    --------
    >>> html([Heading("K*"), Paragraph("1 < 2")])
    '<h3>K*</h3><p>1 &lt; 2</p>'
    """
    return "".join(map(_block, blocks))


def _block(block: Block) -> str:
    match block:
        case Heading():
            return f"<h3>{_text(block.text)}</h3>"
        case Paragraph():
            return f"<p>{_text(block.text)}</p>"
        case Verbatim():
            return f"<pre>{escape(block.text)}</pre>"
        case Table():
            return "".join(_table(block))


def _table(table: Table) -> Iterator[str]:
    yield "<table>"
    if table.title:
        yield f'<caption style="text-align:left">{_text(table.title)}</caption>'
    if any(table.header):
        yield _row("th", table.header, table.align)
    for row in table.rows:
        yield _row("td", row, table.align)
    yield "</table>"


def _row(tag: str, cells: Sequence[str], align: str) -> str:
    made = (
        f'<{tag} style="text-align:{_SIDES[side]}">{_text(cell)}</{tag}>'
        for cell, side in zip(cells, align, strict=True)
    )
    return f"<tr>{''.join(made)}</tr>"


def _text(text: str) -> str:
    return escape(text).replace("\n", "<br>")
