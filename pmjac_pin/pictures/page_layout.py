"""How many drawings of one shape share pages: large enough to read, and no page a ribbon."""

from __future__ import annotations

import math
from dataclasses import dataclass

# Inches: the width of a drawing, the height of what stands above it, and of all on a page.
_PANEL, _CAPTION, _HIGHEST = 2.6, 0.5, 12.0
_PAGE, _TALLEST_PAGE = 0.75, 1.4  # height over width: as wished, and at most
_MOST_COLUMNS = 4
_UNUSED, _ANOTHER_PAGE = 2.0, 0.3  # what unused places cost, as a share, and a page too many


@dataclass(frozen=True)
class PageLayout:
    """How drawings stand on pages that are all alike.

    Attributes
    ----------
    columns, rows : int
        Of a page.
    most : int
        Drawings on a page.
    height : float
        Of a drawing, in its widths.
    """

    columns: int
    rows: int
    most: int
    height: float

    @classmethod
    def of(cls, count: int, height: float) -> PageLayout:
        """Return pages on which drawings, as high over wide as said, have room."""
        height = min(max(height, 0.3), 2.0)
        rows = max(1, int(_HIGHEST / (_PANEL * height + _CAPTION)))
        fewest = -(-count // (_MOST_COLUMNS * rows))

        def cost(shape: tuple[int, int]) -> tuple[bool, float]:
            pages, columns = shape
            rows = _on_each(_on_each(count, pages), columns)
            unused = _UNUSED * (pages * rows * columns - count) / count
            page = rows * (height + _CAPTION / _PANEL) / columns
            more = _ANOTHER_PAGE * (pages - fewest)
            return page > _TALLEST_PAGE, abs(math.log(page / _PAGE)) + unused + more

        # One page more may leave no place unused.
        numbers = range(fewest, fewest + 1 + (fewest > 1))
        shapes = [
            (pages, columns)
            for pages in numbers
            for columns in range(
                min(_on_each(count, pages), 2), min(_on_each(count, pages), _MOST_COLUMNS) + 1
            )
        ]
        pages, columns = min(shapes, key=cost)
        most = _on_each(count, pages)
        return cls(columns, _on_each(most, columns), most, height)

    def pages(self, count: int) -> list[slice]:
        """Return which drawings each page has."""
        return [slice(first, first + self.most) for first in range(0, count, self.most)]

    def size(self, room: float) -> tuple[float, float]:
        """Return width and height of a page, with this room for title and footer."""
        width = max(self.columns, 2) * _PANEL
        row = self.height * width / self.columns + _CAPTION
        return width, min(self.rows * row + room, _TALLEST_PAGE * width)


def _on_each(count: int, pages: int) -> int:
    """Return how many go on each of so many pages or columns."""
    return -(-count // pages)
