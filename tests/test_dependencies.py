"""What is imported is declared, with the lowest version that is known to work."""

from __future__ import annotations

import ast
import re
import runpy
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
OPTIONAL = ("mjcf", "plot", "sweep", "table", "view")
WITH_WHEELS = ("casadi", "crocoddyl", "jax", "mink", "pink")
ADAPTERS = (*WITH_WHEELS, "tsid")  # of the libraries that they are for
REQUIREMENTS = [*PROJECT["dependencies"], *(one for name in OPTIONAL for one in EXTRAS[name])]

PYTHONS = {
    one.rpartition(" ")[2] for one in PROJECT["classifiers"] if re.search(r"Python :: 3\.", one)
}

#: What is imported under another name than it is installed.
IMPORTED_AS = {
    "lazy-loader": "lazy_loader",
    "pin-pink": "pink",
    "pin": "pinocchio",
    "python-flint": "flint",
    "pyyaml": "yaml",
    "tomli-w": "tomli_w",
}
NOT_IMPORTED = {"example-robot-data"}  # files only


def imports():
    """Return the packages that any file of ours imports, in functions too."""
    found = set()
    for path in (ROOT / "pmjac_pin").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found.update(alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                found.add(node.module)
    return {name.partition(".")[0] for name in found} - set(sys.stdlib_module_names)


def names():
    return {re.split(r"[^\w.-]", requirement)[0] for requirement in REQUIREMENTS}


def test_what_is_imported_is_declared():
    for_adapters = {re.split(r"[^\w.-]", EXTRAS[name][0])[0] for name in ADAPTERS}
    known = (names() | for_adapters) - NOT_IMPORTED
    declared = {IMPORTED_AS.get(name, name) for name in known}
    # meshcat's files are looked up by its name, without importing it; matplotlib brings a second.
    assert imports() - {"pmjac_pin", "mpl_toolkits"} == declared - {"meshcat"}


def test_all_is_every_extra_that_a_user_may_want():
    assert EXTRAS["all"] == [f"pmjac_pin[{','.join(OPTIONAL)}]"]


def test_each_adapter_has_an_extra():
    folder = ROOT / "pmjac_pin" / "adapters"
    needs_none = {"__init__", "crocoddyl_build", "ros2_control"}
    modules = {path.stem for path in folder.glob("*.py")} - needs_none
    assert modules == set(ADAPTERS)
    assert EXTRAS["adapters"] == [f"pmjac_pin[{','.join(WITH_WHEELS)}]"]
    for name in ADAPTERS:
        assert re.fullmatch(r"[\w-]+>=\d+(\.\d+)+", EXTRAS[name][0])


@pytest.mark.parametrize("name", ["dask", "ray"])
def test_each_cluster_has_an_extra_with_what_sweeps_need(name):
    library, *others = EXTRAS[name]
    assert others == ["pmjac_pin[sweep]"]
    assert re.fullmatch(r"[\w-]+>=\d+(\.\d+)+", library)


def test_each_extra_that_somebody_is_told_of_is_there():
    places = [*(ROOT / "pmjac_pin").rglob("*.py"), *(ROOT / "docs").glob("*.md")]
    text = "".join(path.read_text(encoding="utf-8") for path in places)
    told = {
        name for some in re.findall(r"pmjac_pin\[([a-z,]+)\]", text) for name in some.split(",")
    }
    assert {"compiled", "dask", "ray", *OPTIONAL} <= told <= set(EXTRAS)


def test_each_requirement_states_its_lowest_version():
    for requirement in REQUIREMENTS:
        assert re.fullmatch(r"[\w-]+>=\d+(\.\d+)+", requirement), requirement


def test_the_matrix_takes_exactly_these():
    script = runpy.run_path(str(ROOT / "scripts" / "test_matrix.py"))
    assert script["declared"](script["OPTIONAL"]) == dict(one.split(">=") for one in REQUIREMENTS)
    assert set(script["OPTIONAL"]) == set(OPTIONAL)
    assert set(script["ADAPTERS"]) == set(WITH_WHEELS)
    assert set(script["PYTHONS"]) == PYTHONS
    assert all((ROOT / "tests" / name).is_file() for name in script["TESTS"])


@pytest.mark.parametrize("missing", ["meshcat", "tornado"])
def test_without_the_page_all_else_works_and_the_error_says_what_to_install(missing):
    code = (
        f"import sys; sys.modules['{missing}'] = None;"
        "import pmjac_pin as pj; home = pj.load('four_bar').home; home.jacobian();"
        "from pmjac_pin.cli import main; raise SystemExit(main(['view', 'four_bar']))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr == f"pmjac: the page needs {missing}: pip install 'pmjac_pin[view]'\n"
