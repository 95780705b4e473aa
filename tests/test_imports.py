"""Imports run one way: from the mathematics to the pictures, and never back."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import pmjac_pin

PACKAGE = Path(__file__).resolve().parent.parent / "pmjac_pin"


def name_of(path):
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported(path):
    """Return the names of all modules that a file imports, in functions too."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            found.add(node.module)
            found.update(f"{node.module}.{alias.name}" for alias in node.names)
    return found


IMPORTS = {name_of(path): imported(path) for path in PACKAGE.rglob("*.py")}


def reached(module):
    """Return all modules that a module imports, directly or through others of the package."""
    found, ahead = set(), [module]
    while ahead:
        new = IMPORTS.get(ahead.pop(), set()) - found
        found |= new
        ahead += new
    return found


@pytest.mark.parametrize("module", ["jacobian", "singularity", "ellipsoid", "ellipse", "partition"])
def test_the_linear_algebra_knows_no_pinocchio(module):
    roots = {name.partition(".")[0] for name in reached(f"pmjac_pin.{module}")}
    assert "numpy" in roots
    assert "pinocchio" not in roots


def test_the_spec_knows_no_pinocchio():
    assert "pinocchio" not in reached("pmjac_pin.spec")


def test_mujoco_is_imported_for_its_own_format_alone():
    code = "import sys, pmjac_pin as pj; pj.load('four_bar'); assert 'mujoco' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True, cwd=PACKAGE.parent)


def knowing(package):
    """Return the modules outside a package of ours that import anything of it."""
    inside = {name for name in IMPORTS if f"{name}.".startswith(f"pmjac_pin.{package}.")}
    return {name for name, names in IMPORTS.items() if names & inside} - inside


def test_only_the_command_line_knows_the_viewer():
    assert knowing("viewer") == {"pmjac_pin.cli.view"}


@pytest.mark.parametrize("module", ["mechanism", "configuration"])
def test_values_know_no_study(module):
    studies = ("studies", "modes", "certificates", "homotopy", "diagnosis")
    known = {
        name.removeprefix("pmjac_pin.").partition(".")[0] for name in reached(f"pmjac_pin.{module}")
    }
    assert known.isdisjoint(studies)


def test_nobody_knows_the_command_line():
    assert knowing("cli") == {"pmjac_pin.__main__"}


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
        "found = [name for name in sys.modules if name.startswith(('pmjac_pin.modes',"
        " 'pmjac_pin.homotopy', 'pmjac_pin.certificates', 'pmjac_pin.viewer', 'pmjac_pin.cli'))];"
        "assert not found, found"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=PACKAGE.parent)


@pytest.mark.slow
@pytest.mark.parametrize("module", sorted(IMPORTS))
def test_each_module_can_be_imported_first(module):
    subprocess.run([sys.executable, "-c", f"import {module}"], check=True, cwd=PACKAGE.parent)
