"""An installed wheel, used from an unrelated folder, is as good as the checkout."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import pmjac_pin as pj

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The wheel, unpacked into a folder of its own as an installer would."""
    folder = tmp_path_factory.mktemp("wheel")
    arguments = ["wheel", ".", "--no-deps", "--no-build-isolation", "--quiet", "-w", str(folder)]
    subprocess.run([sys.executable, "-m", "pip", *arguments], cwd=ROOT, check=True)
    (wheel,) = folder.glob("*.whl")
    site = folder / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    return site


def run(installed, tmp_path, *arguments):
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    return subprocess.run(
        [sys.executable, "-P", *arguments],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    ).stdout


@pytest.mark.slow
def test_the_wheel_holds_models_urdfs_types_and_the_page(installed, tmp_path):
    code = "import pmjac_pin as pj; print(pj.__file__, *pj.list_mechanisms(), sep='\\n')"
    where, *names = run(installed, tmp_path, "-c", code).split()
    assert Path(where).is_relative_to(installed)
    assert tuple(names) == pj.list_mechanisms()
    assert (installed / "pmjac_pin" / "py.typed").exists()
    page = Path("pmjac_pin", "viewer", "page")
    mine = {file.name for file in (ROOT / page).iterdir()}
    assert {file.name for file in (installed / page).iterdir()} == mine


@pytest.mark.slow
@pytest.mark.parametrize("name", pj.list_mechanisms())
def test_the_wheel_reports_the_same(installed, tmp_path, name):
    output = run(installed, tmp_path, "-m", "pmjac_pin", "report", name, "--json")
    mine = run(ROOT, tmp_path, "-m", "pmjac_pin", "report", name, "--json")
    assert json.loads(output) == json.loads(mine)
