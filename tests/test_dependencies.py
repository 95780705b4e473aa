"""What is imported is declared, with the lowest version that is known to work."""

from __future__ import annotations

import ast
import re
import runpy
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
REQUIREMENTS = [*PROJECT["dependencies"], *EXTRAS["mjcf"], *EXTRAS["plot"]]

#: What is imported under another name than it is installed.
IMPORTED_AS = {
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
    declared = {IMPORTED_AS.get(name, name) for name in names() - NOT_IMPORTED}
    # meshcat's files are looked up by its name, without importing it.
    assert imports() - {"pmjac_pin"} == declared - {"meshcat"}


def test_each_requirement_states_its_lowest_version():
    for requirement in REQUIREMENTS:
        assert re.fullmatch(r"[\w-]+>=\d+(\.\d+)+", requirement), requirement


def test_the_script_takes_exactly_these():
    script = runpy.run_path(str(ROOT / "scripts" / "test_lowest_versions.py"))
    assert script["lowest"]() == [requirement.replace(">=", "==") for requirement in REQUIREMENTS]
    assert all((ROOT / "tests" / name).is_file() for name in script["TESTS"])
