"""Run a part of the quick tests over a matrix: each Python, lowest and newest versions.

For each cell it makes an environment in a temporary folder, installs there the wheel that
``make dist`` has built, with all that is optional, and runs the tests against what is installed;
two cells at a time. "Lowest" is of each requirement the lowest version that pyproject.toml
declares, or the first one after it of which this Python has a wheel; "newest" the newest that there
is. A Python that is not on the path, nor among pyenv's, is told as not tried.

The libraries of ``pmjac_pin.adapters`` are installed too, and test_adapters.py runs with those that
have wheels for the cell; of the others it says so.

    make matrix
    python scripts/test_matrix.py [--python 3.11 ...] [--versions lowest ...] [--tests NAME ...]
                                  [--adapters [NAME ...]]

The latter after ``make dist``, which installs the extra ``release`` for both.
"""

from __future__ import annotations

import argparse
import itertools
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
PYTHONS = ("3.11", "3.12", "3.13")
#: What uv is told, by the name of a column.
RESOLUTIONS = {"lowest": "lowest-direct", "newest": "highest"}
OPTIONAL = ("mjcf", "plot", "sweep", "table", "view")
#: The extras that pmjac_pin.adapters are for.
ADAPTERS = tuple(re.findall(r"\w+", EXTRAS["adapters"][0].partition("[")[2]))
#: What the tests need besides.
TOOLS = ("pytest>=8.2", "hypothesis>=6.100", "mpmath>=1.3")

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
    """One Python with one choice of versions, and what is to run there."""

    python: str
    versions: str
    tests: Sequence[str]
    adapters: Sequence[str]


@dataclass(frozen=True)
class Outcome:
    """What became of a cell."""

    passed: bool
    told: str


def declared(extras: Sequence[str]) -> dict[str, str]:
    """Return the lowest version of each requirement, with those of what is optional."""
    optional = [one for name in extras for one in EXTRAS[name] if ">=" in one]
    return dict(one.split(">=") for one in PROJECT["dependencies"] + optional)


def interpreter(version: str) -> str | None:
    """Return a Python of this version: on the path, or of pyenv's; None where there is none."""
    candidates = [sys.executable, shutil.which(f"python{version}")]
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


def tried(cell: Cell, wheel: Path) -> Outcome:
    """Make the environment of a cell, run the tests in it, and remove it."""
    if (found := interpreter(cell.python)) is None:
        return Outcome(True, "not tried: no such Python here")
    start = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="matrix_") as folder:
        environment = Path(folder)
        run("venv", "--quiet", "--clear", "--python", found, folder)
        adapters, problem = cell.adapters, installed(environment, cell, cell.adapters, wheel)
        if problem and adapters:
            adapters = [name for name in adapters if installable(environment, cell, name, wheel)]
            problem = installed(environment, cell, adapters, wheel)
        if problem:
            return Outcome(False, f"not installed: {problem}")
        told, passed = tested(environment, cell, adapters)
        told.append(f"{time.perf_counter() - start:.0f} s")
        if missing := [name for name in cell.adapters if name not in adapters]:
            told.append(f"no wheels for {', '.join(missing)}")
        if cell.versions == "lowest":
            told.extend(other_than_declared(environment, adapters))
    return Outcome(passed, "; ".join(told))


def run(*command: str) -> str:
    """Run uv, and return what went wrong."""
    uv = [sys.executable, "-m", "uv"]
    done = subprocess.run([*uv, *command], capture_output=True, text=True, check=False)
    return " ".join(done.stderr.split()) if done.returncode else ""


def installed(
    environment: Path, cell: Cell, adapters: Sequence[str], wheel: Path, *how: str
) -> str:
    """Install into an environment; return what went wrong."""
    extras = (*OPTIONAL, *adapters)
    # Named, each is a direct one: only of these uv takes the lowest.
    direct = [f"{name}>={lowest}" for name, lowest in declared(extras).items()]
    what = [f"pmjac_pin[{','.join(extras)}] @ {wheel.as_uri()}", *direct, *TOOLS]
    wheels = ["--only-binary", ":all:", "--resolution", RESOLUTIONS[cell.versions]]
    into = ["--python", str(environment / "bin" / "python")]
    return run("pip", "install", "--quiet", *how, *into, *wheels, *what)


def installable(environment: Path, cell: Cell, adapter: str, wheel: Path) -> bool:
    """Return whether what an adapter is for has wheels that install beside the others."""
    return not installed(environment, cell, [adapter], wheel, "--dry-run")


def other_than_declared(environment: Path, adapters: Sequence[str]) -> Iterator[str]:
    """Name what is newer than the lowest version that is declared, for want of a wheel."""
    lowest = declared((*OPTIONAL, *adapters))
    code = "import importlib.metadata as m, sys; print(*map(m.version, sys.argv[1:]))"
    versions = _said([str(environment / "bin" / "python"), "-c", code, *lowest])
    for (name, asked), found in zip(lowest.items(), versions.split(), strict=True):
        if [int(k) for k in re.findall(r"\d+", found)][: asked.count(".") + 1] != [
            int(k) for k in asked.split(".")
        ]:
            yield f"{name} {found}"


def tested(environment: Path, cell: Cell, adapters: Sequence[str]) -> tuple[list[str], bool]:
    """Return pytest's last lines, and whether all tests passed."""
    runs = [["-m", "not slow", *(f"tests/{name}" for name in cell.tests)]]
    if adapters:
        runs.append(["tests/test_adapters.py"])
    # Old packages use what newer ones that they need call deprecated.
    tolerant = ["-W", "ignore::DeprecationWarning"] if cell.versions == "lowest" else []
    outcomes = [_pytest(environment, [*tolerant, *arguments]) for arguments in runs]
    return [told for told, _ in outcomes], all(passed for _, passed in outcomes)


def _pytest(environment: Path, arguments: Sequence[str]) -> tuple[str, bool]:
    # Not as a module: the folder that it is started in would stand before what is installed.
    done = subprocess.run(
        [environment / "bin" / "pytest", "-q", "-p", "no:cacheprovider", *arguments],
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
    parser.add_argument("--adapters", nargs="*", default=ADAPTERS, choices=ADAPTERS)
    parser.add_argument("--dist", type=Path, default=ROOT / "dist")
    asked = parser.parse_args()
    wheels = sorted(asked.dist.resolve().glob("*.whl"))
    if len(wheels) != 1:
        found = f"one wheel is wanted in {asked.dist}, there are {len(wheels)}"
        print(f"{found}: `make dist` builds it")
        return 1
    cells = [
        Cell(python, versions, asked.tests, asked.adapters)
        for python in asked.python
        for versions in asked.versions
    ]
    failed = False
    with ThreadPoolExecutor(max_workers=2) as two:
        outcomes = two.map(tried, cells, itertools.repeat(wheels[0]))
        for cell, outcome in zip(cells, outcomes, strict=True):
            failed |= not outcome.passed
            print(f"Python {cell.python}, {cell.versions} versions: {outcome.told}", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
