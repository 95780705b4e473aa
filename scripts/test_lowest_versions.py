"""Run a part of the quick tests with the lowest versions that pyproject.toml declares.

It makes an environment in a temporary folder, with exactly these versions of what the package
needs, and removes it afterwards: ``python scripts/test_lowest_versions.py``. It takes some
minutes and 1.3 GB of disk.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

#: What the tests need besides, in any version.
TOOLS = ("pytest", "hypothesis", "mpmath")

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


def lowest() -> list[str]:
    """Return each requirement at its lowest version, with those of all that is optional."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    optional = [one for name in ("mjcf", "plot", "sweep", "table", "view") for one in extras[name]]
    requirements = project["dependencies"] + optional
    return [re.sub(">=", "==", requirement) for requirement in requirements]


def main() -> int:
    """Return the tests' exit status."""
    with tempfile.TemporaryDirectory(prefix="lowest_versions_") as folder:
        venv.create(folder, with_pip=True)
        python = Path(folder) / "bin" / "python"
        pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, *lowest(), *TOOLS], check=True)
        subprocess.run([*pip, "--no-deps", "--editable", ROOT], check=True)
        # Old packages use what newer ones that they need call deprecated.
        tolerant = ["-W", "ignore::DeprecationWarning"]
        tests = [f"tests/{name}" for name in TESTS]
        pytest = [python, "-m", "pytest", "-q", "-m", "not slow", "-p", "no:cacheprovider"]
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        return subprocess.run(
            [*pytest, *tolerant, *tests], cwd=ROOT, env=environment, check=False
        ).returncode


if __name__ == "__main__":
    sys.exit(main())
