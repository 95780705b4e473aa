"""Draw the rooms of the package and which imports which, from the imports themselves."""

from __future__ import annotations

import ast
import itertools
import textwrap
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape

PACKAGE = Path(__file__).resolve().parent.parent / "pmjac_pin"
DRAWING = Path(__file__).with_name("architecture.svg")

# Pixels; but letters are counted.
WIDTH, MARGIN = 760, 14
BESIDE = 22
LINE, PAD = 16, 9
BETWEEN = 30
PER_LETTER = 6.0  # of small text, and of what surrounds it
STYLE = """
  text { font-family: Helvetica, Arial, 'Liberation Sans', sans-serif; text-anchor: middle; }
  .name { font-size: 14.5px; font-weight: bold; fill: #1a1a1a; }
  .what { font-size: 11.5px; fill: #333; }
  .folders { font-size: 11.5px; font-style: italic; fill: #555; }
  rect { fill: #fff; stroke: #444; }
  .numbers { fill: #e4f0e2; }
  path { fill: none; stroke: #444; stroke-width: 1.3; marker-end: url(#tip); }
"""
TIP = """<defs><marker id="tip" viewBox="0 0 8 8" refX="7.5" refY="4" markerWidth="7"
 markerHeight="7" orient="auto"><path d="M0 0L8 4L0 8z" style="fill:#444;stroke:none"/></marker>
</defs>
<rect width="100%" height="100%" style="stroke:none"/>"""
Graph = Mapping[str, set[str]]


def name_of(path: Path) -> str:
    """Return a file's name as a module."""
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(path: Path) -> set[str]:
    """Return the names of all modules that a file imports, in functions and for types too."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            found.add(module)
            found.update(f"{module}.{alias.name}" for alias in node.names)
    return found


def reached(module: str, imports: Graph) -> set[str]:
    """Return all that a module imports, directly or through others."""
    found: set[str] = set()
    ahead = [module]
    while ahead:
        new = imports.get(ahead.pop(), set()) - found
        found |= new
        ahead += new
    return found


IMPORTS: Graph = {name_of(path): imported(path) for path in sorted(PACKAGE.rglob("*.py"))}


@dataclass(frozen=True)
class Room:
    """A folder, or files in no folder that belong together.

    Attributes
    ----------
    names : tuple of str
    what : str
        From its docstring.
    folders : tuple of str
        Within it.
    pinocchio : bool
        It knows Pinocchio, itself or by what it imports.
    """

    names: tuple[str, ...]
    what: str
    folders: tuple[str, ...]
    pinocchio: bool

    def lines(self, width: float) -> list[tuple[str, str]]:
        """Return what is written in its box, each line with its style."""
        letters = int(width / PER_LETTER)
        texts = {"what": self.what, "folders": ", ".join(self.folders)}
        wrapped = [(kind, line) for kind in texts for line in textwrap.wrap(texts[kind], letters)]
        return [("name", ", ".join(self.names)), *wrapped]


def first_floor(imports: Graph) -> dict[str, set[str]]:
    """Return what each folder, and each file in no folder, imports of the others."""
    found: dict[str, set[str]] = {}
    for module, names in imports.items():
        inside = {name.split(".")[1] for name in names if name in imports and "." in name}
        if "." in module and not module.endswith("__main__"):
            own = module.split(".")[1]
            found.setdefault(own, set()).update(inside - {own})
    return found


def belonging(below: Graph) -> dict[str, frozenset[str]]:
    """Return the names that share a room with each name.

    Those that import each other do, and files in no folder with other such files that alone
    import them.
    """
    far = {name: reached(name, below) for name in below}
    together = {
        name: frozenset({name, *(other for other in far[name] if name in far[other])})
        for name in below
    }
    for room in sorted(set(together.values()), key=sorted):
        above = {together[name] for name in below if below[name] & room} - {room}
        if len(above) == 1 and not any((PACKAGE / name).is_dir() for name in room.union(*above)):
            whole = room.union(*above)
            together.update(dict.fromkeys(whole, whole))
    return together


def rooms(imports: Graph) -> dict[Room, set[Room]]:
    """Return all rooms, each with those that it imports."""
    below = first_floor(imports)
    together = belonging(below)
    made = {names: _room(names, imports) for names in set(together.values())}
    return {
        made[names]: {made[together[other]] for name in names for other in below[name] - names}
        for names in sorted(made, key=sorted)
    }


def _room(names: frozenset[str], imports: Graph) -> Room:
    listed = tuple(sorted(names))
    inside = [module for module in imports if {*module.split(".")[1:2]} & names]
    knows = any("pinocchio" in reached(module, imports) for module in inside)
    folders = {module.split(".")[2] for module in inside if module.count(".") == 3}
    what = _what(listed[0]) if len(listed) == 1 else "In no folder: they know each other"
    return Room(listed, what, tuple(sorted(folders)), knows)


def _what(name: str) -> str:
    path = PACKAGE / name
    path = path / "__init__.py" if path.is_dir() else path.with_suffix(".py")
    line = (ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").split("\n")[0]
    line = line.replace("`", "").rstrip(".")
    start, _, rest = line.partition(": ")
    what = rest if start.lower().removeprefix("the ") == name else line
    return what[0].upper() + what[1:]


def direct(below: Mapping[Room, set[Room]]) -> dict[Room, set[Room]]:
    """Return the imports to which no longer way leads."""

    def far(room: Room) -> set[Room]:
        return below[room].union(*(far(other) for other in below[room]))

    return {
        room: {other for other in others if not any(other in far(one) for one in others)}
        for room, others in below.items()
    }


def levels(below: Mapping[Room, set[Room]]) -> list[list[Room]]:
    """Return the rooms by level, the highest first, each right under the lowest that imports it."""

    def depth(room: Room) -> int:
        return max((1 + depth(other) for other in below if room in below[other]), default=0)

    depths = {room: depth(room) for room in below}
    return [
        [room for room in below if depths[room] == level]
        for level in range(1 + max(depths.values()))
    ]


def middles(rows: Iterable[tuple[Room, ...]]) -> dict[Room, float]:
    """Return the middle of each room across the drawing, in shares of its width."""
    return {room: (k + 0.5) / len(row) for row in rows for k, room in enumerate(row)}


def arranged(rows: list[list[Room]], arrows: Mapping[Room, set[Room]]) -> list[tuple[Room, ...]]:
    """Return the levels with each in the order that makes the arrows cross least, then shortest."""

    def cost(order: tuple[tuple[Room, ...], ...]) -> tuple[int, float]:
        at = middles(order)
        level = {room: k for k, row in enumerate(order) for room in row}
        pairs = [(room, other) for room in at for other in at if other in arrows[room]]
        crossings = sum(
            level[a] == level[c] and (at[a] - at[c]) * (at[b] - at[d]) < 0
            for (a, b), (c, d) in itertools.combinations(pairs, 2)
        )
        return crossings, round(sum(abs(at[a] - at[b]) for a, b in pairs), 6)

    return list(min(itertools.product(*map(itertools.permutations, rows)), key=cost))


@dataclass(frozen=True)
class Box:
    """Where a room is drawn."""

    middle: float
    top: float
    width: float
    height: float
    lines: list[tuple[str, str]]

    def nearest(self, across: float) -> float:
        """Return where an arrow that comes from there, or goes there, meets the box."""
        reach = 0.42 * self.width
        return max(self.middle - reach, min(self.middle + reach, across))


def boxes(order: Iterable[tuple[Room, ...]]) -> dict[Room, Box]:
    """Return the boxes of all rooms; those of a level are as high as the highest of them."""
    top, found = float(MARGIN), {}
    for row in order:
        apart = (WIDTH - 2 * MARGIN + BESIDE) / len(row)
        width, middle = apart - BESIDE, MARGIN + 0.5 * (apart - BESIDE)
        lines = {room: room.lines(width) for room in row}
        height = LINE * max(map(len, lines.values())) + 2 * PAD
        for k, room in enumerate(row):
            found[room] = Box(middle + k * apart, top, width, height, lines[room])
        top += height + BETWEEN
    return found


def drawing(imports: Graph = IMPORTS) -> str:
    """Return the drawing as SVG."""
    below = rooms(imports)
    arrows = direct(below)
    drawn = boxes(arranged(levels(below), arrows))
    lines = [
        _arrow(drawn[room], drawn[other])
        for room in below
        for other in sorted(arrows[room], key=lambda other: drawn[other].middle)
    ]
    texts = [_box(box, room.pinocchio) for room, box in drawn.items()]
    bottom = max(box.top + box.height for box in drawn.values()) + MARGIN
    size = f'width="{WIDTH}" height="{bottom:.0f}" viewBox="0 0 {WIDTH} {bottom:.0f}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size}>\n<style>{STYLE}</style>\n{TIP}'
    return "\n".join([head, *lines, *texts, "</svg>\n"])


def _arrow(upper: Box, lower: Box) -> str:
    """Return an arrow, upright where the boxes are above each other."""
    start = upper.nearest(lower.middle)
    end = lower.nearest(start)
    return f'<path d="M{start:.0f} {upper.top + upper.height:.0f}L{end:.0f} {lower.top:.0f}"/>'


def _box(box: Box, pinocchio: bool) -> str:
    left, y = box.middle - 0.5 * box.width, box.top + 0.5 * (box.height - LINE * len(box.lines)) - 4
    place = f'x="{left:.0f}" y="{box.top:.0f}" width="{box.width:.0f}" height="{box.height:.0f}"'
    style = "" if pinocchio else ' class="numbers"'
    texts = [
        f'<text class="{kind}" x="{box.middle:.0f}" y="{y + LINE * k:.0f}">{escape(line)}</text>'
        for k, (kind, line) in enumerate(box.lines, start=1)
    ]
    return "\n".join([f'<rect {place} rx="5"{style}/>', *texts])


if __name__ == "__main__":
    DRAWING.write_text(drawing(), encoding="utf-8")
    print(DRAWING)
