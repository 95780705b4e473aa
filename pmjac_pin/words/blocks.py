"""What is shown, before it is drawn: headings, paragraphs and tables of text."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class Heading:
    """The title of a part."""

    text: str


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Running text."""

    text: str


@dataclass(frozen=True, slots=True)
class Verbatim:
    """A line that is never wrapped or rewritten: a path."""

    text: str


@dataclass(frozen=True, slots=True)
class Table:
    """A table of text.

    Attributes
    ----------
    title : str
    header : tuple of str
        One for each column; may hold several lines.
    rows : tuple of tuple of str
    align : str
        "<" or ">" for each column: words to the left, numbers to the right.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    align: str

    @classmethod
    def of(cls, title: str, align: str, columns: Mapping[str, Iterable[str]]) -> Table:
        """Return a table of columns, each under its name."""
        return cls(title, tuple(columns), tuple(zip(*columns.values(), strict=True)), align)


Block: TypeAlias = Heading | Paragraph | Verbatim | Table
