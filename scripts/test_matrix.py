"""Run a part of the quick tests over a matrix: each Python, lowest and newest versions.

For each cell it makes an environment in a temporary folder, installs there the wheel that
``make dist`` has built, with all that is optional, and runs the tests against what is installed.
"Lowest" is of each requirement the lowest version that pyproject.toml declares, or the first one
after it of which this Python has a wheel; "newest" the newest that there is. A Python that is not
on the path, nor among pyenv's, is told as not tried.

    make matrix
    python scripts/test_matrix.py [--python 3.11 ...] [--versions lowest ...] [--tests NAME ...]

The latter after ``make dist``, which installs the extra ``release`` for both. The extras of
``pmjac_pin.adapters`` are not in it.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PYTHONS = ("3.11", "3.12", "3.13")
#: What uv is told, by the name of a column.
RESOLUTIONS = {"lowest": "lowest-direct", "newest": "highest"}
#: What the tests need besides.
TOOLS = ("pytest>=8", "hypothesis>=6.100", "mpmath>=1.3")

#: At least one for each dependency, and for each thing that one can do with the package.
TESTS = (
    "test_batch.py",
    "test_catalog.py",
    "test_certificate.py",
    "test_cli.py",
    "test_closure.py",
    "test_closure_yaml.py",
    "test_convert.py",
    "test_hand_derived.py",
    "test_intervals.py",
    "test_lecture.py",
    "test_limits.py",
    "test_mjcf.py",
    "test_model_file.py",
    "test_modes_report.py",
    "test_output_file.py",
    "test_pages.py",
    "test_parameter_homotopy.py",
    "test_plotting.py",
    "test_proof.py",
    "test_report.py",
    "test_sdf.py",
    "test_server.py",
    "test_sweep.py",
    "test_tables.py",
    "test_urdf.py",
    "test_viewer.py",
)


@dataclass(frozen=True)
class Cell:
    """What became of one Python with one choice of versions."""

    python: str
    versions: str
    passed: bool
    told: str


def declared() -> dict[str, str]:
    """Return the lowest version of each requirement, with those of all that is optional."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    optional = [one for name in ("mjcf", "plot", "sweep", "table", "view") for one in extras[name]]
    return dict(one.split(">=") for one in project["dependencies"] + optional)


def interpreter(version: str) -> str | None:
    """Return a Python of this version: on the path, or of pyenv's; None where there is none."""
    candidates = [shutil.which(f"python{version}")]
    if root := shutil.which("pyenv") and _said(["pyenv", "root"]):
        candidates += sorted(map(str, Path(root).glob(f"versions/{version}.*/bin/python")))
    asked = ["-c", "import sys; print('%d.%d' % sys.version_info[:2])"]
    for candidate in candidates:
        if candidate and _said([candidate, *asked]) == version:
            return candidate
    return None


def _said(command: list[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return "" if done.returncode else done.stdout.strip()


def tried(python: str, versions: str, wheel: Path, tests: Sequence[str]) -> Cell:
    """Make the environment of a cell, run the tests in it, and remove it."""
    if (found := interpreter(python)) is None:
        return Cell(python, versions, True, "not tried: no such Python here")
    start = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="matrix_") as folder:
        environment = Path(folder)
        if problem := _installed(environment, found, versions, wheel):
            return Cell(python, versions, False, problem)
        other = ", ".join(_other_than_declared(environment)) if versions == "lowest" else ""
        last, passed = _tested(environment, versions, tests)
    seconds = f"{time.perf_counter() - start:.0f} s"
    return Cell(python, versions, passed, "; ".join(filter(None, (last, seconds, other))))


def _installed(environment: Path, python: str, versions: str, wheel: Path) -> str:
    """Install into an environment; return what went wrong."""
    uv = [sys.executable, "-m", "uv"]
    # Named, each is a direct one: only of these uv takes the lowest.
    direct = [f"{name}>={lowest}" for name, lowest in declared().items()]
    what = [f"pmjac_pin[all] @ {wheel.as_uri()}", *direct, *TOOLS]
    how = ["--only-binary", ":all:", "--resolution", RESOLUTIONS[versions]]
    into = ["--python", str(environment / "bin" / "python")]
    for command in (
        [*uv, "venv", "--quiet", "--clear", "--python", python, str(environment)],
        [*uv, "pip", "install", "--quiet", *into, *how, *what],
    ):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            return "not installed: " + " ".join(done.stderr.split())
    return ""


def _other_than_declared(environment: Path) -> Iterator[str]:
    """Name what is newer than the lowest version that is declared, for want of a wheel."""
    python = [str(environment / "bin" / "python"), "-c"]
    for name, lowest in declared().items():
        code = f"import importlib.metadata as m; print(m.version({name!r}))"
        found = _said([*python, code])
        if [int(k) for k in re.findall(r"\d+", found)][: lowest.count(".") + 1] != [
            int(k) for k in lowest.split(".")
        ]:
            yield f"{name} {found}"


def _tested(environment: Path, versions: str, tests: Sequence[str]) -> tuple[str, bool]:
    """Return pytest's last line, and whether all tests passed."""
    # Not as a module: the folder that it is started in would stand before what is installed.
    pytest = [environment / "bin" / "pytest", "-q", "-m", "not slow", "-p", "no:cacheprovider"]
    # Old packages use what newer ones that they need call deprecated.
    tolerant = ["-W", "ignore::DeprecationWarning"] if versions == "lowest" else []
    done = subprocess.run(
        [*pytest, *tolerant, *(f"tests/{name}" for name in tests)],
        cwd=ROOT,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        print(done.stdout[-5000:], done.stderr[-5000:], sep="\n")
    return done.stdout.strip().rpartition("\n")[2], done.returncode == 0


def main() -> int:
    """Print a line a cell; return 1 where a test failed."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--python", nargs="+", default=PYTHONS)
    parser.add_argument("--versions", nargs="+", default=list(RESOLUTIONS), choices=RESOLUTIONS)
    parser.add_argument("--tests", nargs="+", default=TESTS)
    parser.add_argument("--dist", type=Path, default=ROOT / "dist")
    asked = parser.parse_args()
    wheels = sorted(asked.dist.resolve().glob("*.whl"))
    if len(wheels) != 1:
        found = f"one wheel is wanted in {asked.dist}, there are {len(wheels)}"
        print(f"{found}: `make dist` builds it")
        return 1
    failed = False
    for python in asked.python:
        for versions in asked.versions:
            cell = tried(python, versions, wheels[0], asked.tests)
            failed |= not cell.passed
            print(f"Python {python}, {versions} versions: {cell.told}", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
