"""Drawing blocks in a terminal, a pipe or a file, in whatever encoding it has."""

from __future__ import annotations

import contextlib
import errno
import io
import itertools
import os
import re
import sys
import unicodedata
from collections.abc import Iterable, Sequence
from typing import TextIO, assert_never

import rich.box
import rich.table
from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from pmjac_pin.words.blocks import Block, Heading, Paragraph, Table, Verbatim

_BLANKS = 3  # blanks between columns
_NARROWEST, _USUAL, _WIDEST_LINE = 20, 80, 10_000  # characters of a line
_NARROWEST_WORDS = 12  # characters: to which columns of words are folded before a table is
_WIDEST_NAME = 24  # longer column names are folded in wide tables

# Headings underlined, nothing else: a box that needs no Unicode, and one that does.
_RULE = rich.box.Box("    \n    \n ── \n    \n    \n    \n    \n    \n")
_ASCII_RULE = rich.box.Box("    \n    \n -- \n    \n    \n    \n    \n    \n", ascii=True)

# For terminals without Unicode; what is not here loses its accents, or becomes a "?".
_ASCII = {
    "∂": "d ",
    "η": "eta",
    "θ": "theta",
    "φ": "phi",
    "Φ": "Phi",
    "ω": "w",
    "σ": "sigma",
    "ᵀ": "^T",
    "∞": "inf",
    "−": "-",
    "–": "-",
    "—": "-",
    "×": "x",
    "·": "*",
    "√": "sqrt",
    "’": "'",
    "“": '"',
    "”": '"',
    "Δ": "Delta ",
    "═": "=",
    "→": "->",
}
_LOWERED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def new_console() -> Console:
    """Return a console that draws plain text unless on a terminal, and if NO_COLOR is set."""
    plain = bool(os.environ.get("NO_COLOR"))
    console = Console(
        markup=False, highlight=False, emoji=False, color_system=None if plain else "auto"
    )
    # Of `COLUMNS`, rich takes any number as it is: with 0 it would print nothing.
    console.width = min(max(console.width, _NARROWEST), _WIDEST_LINE) if console.width else _USUAL
    return console


def draw(console: Console, blocks: Iterable[Block]) -> None:
    """Print blocks, no line wider than the console."""
    for index, block in enumerate(blocks):
        if index:
            console.print()
        match block:
            case Heading():
                _draw_heading(console, block.text)
            case Paragraph():
                console.print(_plain_text(console, block.text))
            case Verbatim():
                console.print(Text(one_line(block.text)), soft_wrap=True)
            case Table():
                _draw_table(console, block)
            case _:
                assert_never(block)


def plain_text(blocks: Iterable[Block], width: int) -> str:
    """Return blocks as text without colours, in lines of that width."""
    console = Console(
        file=io.StringIO(), width=width, markup=False, highlight=False, color_system=None
    )
    with console.capture() as capture:
        draw(console, blocks)
    return re.sub(r"[ ]+$", "", capture.get(), flags=re.MULTILINE).rstrip("\n")


def one_line(text: str) -> str:
    """Return text without line breaks and control characters."""
    joined = " ".join(map(str.strip, text.splitlines()))
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in joined)


def write(text: str) -> None:
    """Write to standard output what its encoding can hold, without blanks at line ends.

    Raises
    ------
    OSError
        The device is full; standard output is closed.
    """
    if sys.stdout is None:
        raise OSError(errno.EBADF, os.strerror(errno.EBADF), "standard output")
    _write(sys.stdout, re.sub(r"[ ]+$", "", text, flags=re.MULTILINE))


def complain(text: str) -> None:
    """Write to standard error, where that can be written to."""
    if sys.stderr is not None:
        with contextlib.suppress(OSError):  # the exit status says it, too
            _write(sys.stderr, text)


def _write(stream: TextIO, text: str) -> None:
    encoding = stream.encoding or "utf-8"
    try:
        stream.write(text.encode(encoding, "backslashreplace").decode(encoding))
        stream.flush()
    except OSError:
        # What is left in the buffer would fail again, with a traceback, when Python exits.
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        raise


def to_ascii(text: str) -> str:
    """Return text in ASCII, as readable as that allows.

    Examples
    --------
    >>> to_ascii("K* = ∂η/∂φ [m²/rad], naïve")
    'K* = d eta/d phi [m^2/rad], naive'
    """
    for symbol, replacement in _ASCII.items():
        text = text.replace(symbol, replacement)
    text = re.sub("[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+", lambda match: "^" + match[0].translate(_LOWERED), text)
    decomposed = unicodedata.normalize("NFKD", text)
    bare = "".join(c for c in decomposed if not unicodedata.combining(c))
    return bare.encode("ascii", "replace").decode()


def _plain_text(console: Console, text: str) -> Text:
    lines = "\n".join(map(one_line, text.split("\n")))
    return Text(to_ascii(lines) if console.options.ascii_only else lines)


def _draw_heading(console: Console, text: str) -> None:
    heading = _plain_text(console, text)
    width = min(heading.cell_len, console.width)
    console.print(heading, style="bold cyan")
    console.print(_plain_text(console, "═" * width), style="cyan")


def _draw_table(console: Console, table: Table) -> None:
    header = [_plain_text(console, cell) for cell in table.header]
    rows = [[_plain_text(console, cell) for cell in row] for row in table.rows]
    if table.title:
        console.print(_plain_text(console, table.title), style="bold")
    widths = _natural_widths(header, rows)
    numbers = "<" not in table.align[1:]
    least = [
        width if side == ">" or numbers else min(width, _NARROWEST_WORDS)
        for width, side in zip(widths, table.align, strict=True)
    ]
    if sum(least) + _BLANKS * (len(widths) - 1) <= console.width:
        parts = [list(range(len(widths)))]
    elif numbers:
        digits = _natural_widths([Text()] * len(header), rows)
        parts, widths = _numbers_in_parts(console.width, widths, digits)
    else:
        parts, widths = _words_in_parts(console.width, [widths[0], *least[1:]])
    for number, columns in enumerate(parts):
        if number:
            console.print()
        _draw_grid(
            console,
            [header[k] for k in columns],
            [[row[k] for k in columns] for row in rows],
            "".join(table.align[k] for k in columns),
            [widths[k] for k in columns],
        )


def _numbers_in_parts(
    width: int, widths: Sequence[int], digits: Sequence[int]
) -> tuple[list[list[int]], list[int]]:
    """Return which columns of a wide table of numbers stand side by side, and their widths.

    Each part has the first column, of labels; the others are alike.
    """
    label, count = min(widths[0], width // 2), len(widths) - 1
    column = max(*digits[1:], min(max(widths[1:]), _WIDEST_NAME, width - label - _BLANKS))
    fitting = max(1, (width - label) // (_BLANKS + column))
    parts = -(-count // fitting)
    ends = [1 + part * count // parts for part in range(parts + 1)]
    return [[0, *range(*pair)] for pair in itertools.pairwise(ends)], [label] + [column] * count


def _words_in_parts(width: int, widths: Sequence[int]) -> tuple[list[list[int]], list[int]]:
    """Return the same of a wide table of numbers and words."""
    label = min(widths[0], width // 2)
    parts, room = [[0]], width - label
    for k, wide in enumerate(widths[1:], start=1):
        if len(parts[-1]) > 1 and room < _BLANKS + wide:
            parts.append([0])
            room = width - label
        parts[-1].append(k)
        room -= _BLANKS + wide
    most = width - label - _BLANKS
    return parts, [label, *(min(wide, most) for wide in widths[1:])]


def _draw_grid(
    console: Console,
    header: Sequence[Text],
    rows: Sequence[Sequence[Text]],
    align: str,
    widths: Sequence[int],
) -> None:
    grid = rich.table.Table(
        box=_ASCII_RULE if console.options.ascii_only else _RULE,
        show_edge=False,
        pad_edge=False,
        header_style="",
        show_header=any(text.plain for text in header),
    )
    longest = _natural_widths(header, rows)[0]
    names_stay_whole = longest <= min(widths[0], console.width // 3)
    for k, (text, side, width) in enumerate(zip(header, align, widths, strict=True)):
        number = side == ">"
        grid.add_column(
            text,
            justify="right" if number else "left",
            vertical="top",
            overflow="fold",
            no_wrap=k == 0 and names_stay_whole,
            min_width=width if number else None,
            max_width=width,
        )
    for row in rows:
        grid.add_row(*row)
    console.print(grid)


def _natural_widths(header: Sequence[Text], rows: Sequence[Sequence[Text]]) -> list[int]:
    cells = [header, *rows]
    return [
        max(cell_len(line) for row in cells for line in row[k].plain.split("\n"))
        for k in range(len(header))
    ]
