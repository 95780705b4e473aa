"""The pages say of the code what is true: the map, the index, the table of loops."""

from __future__ import annotations

import ast
import inspect
import re
from collections import defaultdict
from pathlib import Path

import pytest
from draw_architecture import DRAWING, IMPORTS, PACKAGE, direct, drawing, levels, rooms

import pmjac_pin as pj
from pmjac_pin.model.loop_spec import LOOP_KINDS, JointLoop

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
MAP = (DOCS / "architecture.md").read_text(encoding="utf-8")


def found(name):
    places = [ROOT / name, PACKAGE / name, ROOT / "tests" / name]
    return [place for place in places if place.exists()]


def defined(path):
    """Return the names that a module defines for itself: classes, functions, constants."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        match node:
            case ast.ClassDef() | ast.FunctionDef():
                yield node.name
            case ast.Assign():
                yield from (name.id for name in node.targets if isinstance(name, ast.Name))
            case ast.AnnAssign(target=ast.Name(id=name)):
                yield name


def test_hardly_a_name_stands_for_two_things():
    """But for what files have by their kind (`_logger`), or what is the same for two of a kind."""
    files = defaultdict(set)
    for path in PACKAGE.rglob("*.py"):
        for name in defined(path):
            files[name].add(path.relative_to(PACKAGE).as_posix())
    shared = {name: sorted(where) for name, where in files.items() if len(where) > 1}
    assert len(shared) <= 25, shared


def test_the_drawing_is_that_of_today():
    """`python docs/draw_architecture.py` draws it."""
    assert DRAWING.read_text(encoding="utf-8") == drawing()


def test_all_imports_go_down_and_follow_from_the_arrows():
    below = rooms(IMPORTS)
    level = {room: number for number, row in enumerate(levels(below)) for room in row}
    arrows = direct(below)

    def led_to(room):
        return arrows[room].union(*map(led_to, arrows[room]))

    for room, others in below.items():
        assert all(level[room] < level[other] for other in others)
        assert led_to(room) >= others


def test_every_folder_is_on_the_map():
    folders = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    assert {folder for folder in folders if f"| `{folder}/` |" not in MAP} == set()


@pytest.mark.parametrize("name", sorted(set(re.findall(r"`([\w/]+\.(?:pyi?|toml))`", MAP))))
def test_what_the_map_names_exists(name):
    assert found(name)


@pytest.mark.parametrize(
    ("table", "name"), sorted(set(re.findall(r"`([A-Z]+)`\s+of\s+`([\w/]+\.py)`", MAP)))
)
def test_the_tables_that_the_map_names_exist(table, name):
    (path,) = found(name)
    assert re.search(rf"^{table}\b.* = ", path.read_text(encoding="utf-8"), re.MULTILINE)


def test_every_page_is_in_the_index():
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    linked = set(re.findall(r"\]\((\w+\.md)", index))
    assert linked == {page.name for page in DOCS.glob("*.md")} - {"index.md"}
    assert "(docs/index.md)" in (ROOT / "README.md").read_text(encoding="utf-8")


LOOPS = re.findall(
    r"^\| `(\w+)`(?: or `(\w+)`)? \| (\d) \| .* \| (.*) \|$",
    (DOCS / "model_files.md").read_text(encoding="utf-8"),
    re.MULTILINE,
)


def test_the_table_of_loops_has_every_kind():
    assert {kind for row in LOOPS for kind in row[:2] if kind} == {*LOOP_KINDS}


@pytest.mark.parametrize("row", LOOPS, ids=lambda row: row[0])
def test_the_table_of_loops_has_their_rows_and_keys(row):
    given = {"frames": ("a", "b"), "joints": ("a", "b"), "length": 1.0}
    for kind in filter(None, row[:2]):
        fields = LOOP_KINDS[kind].__struct_fields__
        assert re.findall(r"`(\w+)`", row[3]) == list(fields)
        loop = LOOP_KINDS[kind](**{name: given[name] for name in fields if name in given})
        blocks = [] if isinstance(loop, JointLoop) else loop.rows({})
        assert sum(len(block.names) for block in blocks) == int(row[2]) - (not blocks)


def test_what_is_random_takes_rng_and_none_by_default():
    """As in SciPy: a seed makes a generator, and none takes one that differs every time."""
    public = [getattr(pj, name) for name in pj.__all__]
    functions = [one for one in public if inspect.isfunction(one)]
    methods = [way for one in public if isinstance(one, type) for way in vars(one).values()]
    defaults = [
        given["rng"].default
        for one in [*functions, *filter(inspect.isfunction, methods)]
        if "rng" in (given := inspect.signature(one).parameters)
    ]
    assert len(defaults) > 3
    assert set(defaults) == {None}
