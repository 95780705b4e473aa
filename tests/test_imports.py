"""Imports run one way: from the mathematics to the pictures, and never back."""

from __future__ import annotations

import ast
import importlib.util
import os
import re
import subprocess
import sys

import draw_architecture
import pytest
from draw_architecture import IMPORTS, PACKAGE, imported

import pmjac_pin


def reached(module):
    return draw_architecture.reached(module, IMPORTS)


# Lowest first. What stands in one line may not import each other, except within a folder, and the
# one pair that knows each other's type with what makes one of the other.
ORDER = (
    ("errors",),
    ("values",),
    ("algebra",),
    ("model",),
    ("files", "kinematics"),
    ("rates",),
    ("closing",),
    (
        "configuration mechanism mechanism_siblings mechanism_value direct_kinematics "
        "pose_of_configuration",
    ),
    ("loading", "batches", "builders"),
    ("studies",),
    ("words", "adapters"),
    ("pictures",),
    ("viewer",),
    ("cli __main__",),
)
PLACES = {
    name: (level, group)
    for level, line in enumerate(ORDER)
    for group in line
    for name in group.split()
}


FOLDERS = ("pmjac_pin", "tests", "benchmarks", "docs", "scripts")


def examples(path):
    """Return the lines of code that a file shows: in fences of a page, after >>> elsewhere."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        return "\n".join(re.findall(r"```python\n(.*?)```", text, re.DOTALL)).splitlines()
    return re.findall(r"^ *(?:>>>|\.\.\.) (.*)$", text, re.MULTILINE)


def place(module):
    """Return the level and the group of a module."""
    return PLACES[module.split(".")[1]]


def imported_modules(module):
    return [name for name in IMPORTS[module] if name in IMPORTS and name != "pmjac_pin"]


@pytest.mark.parametrize("module", sorted(IMPORTS))
def test_imports_go_down_the_order(module):
    """Those of types alone, and those within functions, too."""
    if module == "pmjac_pin":
        return
    level, group = place(module)
    for name in imported_modules(module):
        below, other = place(name)
        assert below < level or other == group, f"{module} imports {name}"


def test_no_module_imports_itself_by_way_of_others():
    """But for configuration and mechanism, with the two that make the one for the other."""
    circular = {module for module in IMPORTS if module in reached(module)}
    names = "configuration mechanism direct_kinematics pose_of_configuration"
    assert circular == {f"pmjac_pin.{name}" for name in names.split()}


def of_parts(path):
    """Return whether a file asks for what a mechanism is made of: `Parts`, or `_parts` of one."""
    text = path.read_text(encoding="utf-8")
    if "parts" not in text:
        return False
    asked = any(
        isinstance(node, ast.Attribute) and node.attr == "_parts"
        for node in ast.walk(ast.parse(text))
    )
    return asked or any(name.startswith("pmjac_pin.closing.parts") for name in imported(path))


def test_what_a_mechanism_is_made_of_is_known_in_its_own_room_only():
    folders = (PACKAGE, PACKAGE / "closing")
    room = [path for folder in folders for path in folder.glob("*.py")]
    root = PACKAGE.parent
    files = [path for name in FOLDERS for path in (root / name).rglob("*.py")]
    assert len(files) > len(room)
    assert [path for path in files if path not in room and of_parts(path)] == []


def test_no_documentation_asks_for_a_private_name():
    """In the examples of docstrings and of pages, code is run as a user would write it."""
    root = PACKAGE.parent
    lines = [
        line
        for path in (*PACKAGE.rglob("*.py"), root / "README.md", *(root / "docs").rglob("*.md"))
        for line in examples(path)
    ]
    assert len(lines) > 100
    assert [line for line in lines if re.search(r"[\w)\]]\._[a-z]|import .*\b_[a-z]", line)] == []


def test_few_modules_are_in_no_folder():
    assert len(list(PACKAGE.glob("*.py"))) <= 10


@pytest.mark.parametrize("folder", ["values", "algebra", "rates"])
def test_linear_algebra_knows_no_pinocchio(folder):
    inside = [name for name in IMPORTS if name.startswith(f"pmjac_pin.{folder}.")]
    assert inside
    for module in inside:
        assert "pinocchio" not in {name.partition(".")[0] for name in reached(module)}, module


def test_the_spec_knows_no_pinocchio():
    assert "pinocchio" not in reached("pmjac_pin.model.spec")


def test_the_package_shows_its_interface():
    code = (
        "import pmjac_pin as pj, sys;"
        "assert not [name for name in sys.modules if name.startswith('pmjac_pin.')];"
        "assert set(pj.__all__) <= set(dir(pj));"
        "assert all(hasattr(pj, name) for name in pj.__all__);"
        "from pmjac_pin import *; assert Mechanism is pj.Mechanism"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=PACKAGE.parent)
    assert not hasattr(pmjac_pin, "nope")


def test_what_is_not_asked_for_is_not_imported():
    """A load, a pose and a Jacobian need no proof, search, picture or page."""
    code = (
        "import pmjac_pin as pj, sys; pj.load('four_bar').close([1.0]).jacobian();"
        "found = {'flint', 'matplotlib', 'meshcat', 'tornado'} & set(sys.modules);"
        "assert not found, found;"
        "found = [name for name in sys.modules if name.startswith(('pmjac_pin.studies',"
        " 'pmjac_pin.words', 'pmjac_pin.pictures', 'pmjac_pin.viewer', 'pmjac_pin.cli'))];"
        "assert not found, found"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=PACKAGE.parent)


@pytest.mark.parametrize(
    "code",
    [
        "import pmjac_pin as pj; pj.load('four_bar')",
        "from pmjac_pin.cli.running import import_commands; import_commands(['list'])",
    ],
)
def test_starting_up_imports_little(code):
    """SciPy takes as long as Pinocchio; most models are of our own format."""
    code += (
        ";import sys;"
        "found = {'scipy', 'yaml', 'mujoco', 'email', 'pmjac_pin.studies'} & set(sys.modules);"
        "found |= {name for name in sys.modules if name.startswith('pmjac_pin.files.mjcf')};"
        "assert not found, found"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=PACKAGE.parent)


def test_many_poses_import_little():
    """Of SciPy what single poses need as well, and what calls a compiler when that is asked for."""
    code = (
        "import sys, pmjac_pin as pj; home = pj.load('three_rps').home;"
        "many = pj.batch(home.mechanism);"
        "many.measures(many.close([home.actuated]).q);"
        "found = {'scipy.spatial', 'scipy.optimize', 'pmjac_pin.algebra.compiled_programs'};"
        "found &= set(sys.modules);"
        "assert not found, found"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=PACKAGE.parent)


ADAPTED = ("casadi", "crocoddyl", "jax", "mink", "pink", "tsid")
# Imports each of these modules in a process of its own, where others' packages are there already.
IN_FORKS = """
import importlib, os, sys, traceback
import flint, matplotlib.figure, meshcat, msgspec, numpy, pinocchio, rich.table
import scipy.linalg, scipy.optimize, scipy.spatial.transform
for name in sys.argv[1:]:
    if not (child := os.fork()):
        try:
            importlib.import_module(name)
        except BaseException:
            print(name, traceback.format_exc(), flush=True)
        os._exit(0)
    os.waitpid(child, 0)
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_each_module_can_be_imported_first():
    """Those of libraries that are not installed, as TSID, which has no wheel, left out."""
    missing = tuple(
        f"pmjac_pin.adapters.{library}"
        for library in ADAPTED
        if not importlib.util.find_spec(library)
    )
    names = sorted(name for name in IMPORTS if not name.startswith(missing or " "))
    command = [sys.executable, "-c", IN_FORKS, *names]
    done = subprocess.run(command, check=True, cwd=PACKAGE.parent, capture_output=True, text=True)
    assert done.stdout == ""
