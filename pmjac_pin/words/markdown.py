"""Blocks as Markdown, for pages on the web."""

from __future__ import annotations

from collections.abc import Sequence

from pmjac_pin.words.blocks import Table

_ALIGNMENTS = {"<": "---", ">": "---:"}


def markdown_table(table: Table) -> str:
    r"""Return a table in GitHub's Markdown, without its title.

    Examples
    --------
    >>> from pmjac_pin.words.blocks import Table
    >>> print(markdown_table(Table("", ("name", "loops\n(rows)"), (("a|b", "1 (3)"),), "<>")))
    | name | loops (rows) |
    | --- | ---: |
    | a\|b | 1 (3) |
    """
    rules = [_ALIGNMENTS[side] for side in table.align]
    return "\n".join(
        map(_markdown_row, [_escaped_cells(table.header), rules, *map(_escaped_cells, table.rows)])
    )


def _markdown_row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def _escaped_cells(cells: Sequence[str]) -> list[str]:
    """Escape what Markdown would take for markup, such as the star of K*."""
    marks = str.maketrans({mark: f"\\{mark}" for mark in "\\|*`<["})
    return [" ".join(cell.split()).translate(marks) for cell in cells]
