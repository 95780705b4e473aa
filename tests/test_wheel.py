"""An installed wheel, used from an unrelated folder, is as good as the checkout."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tarfile
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


def files_for(wheel):
    """Return the kernels that a wheel holds, and for which platforms it says it is."""
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (metadata,) = (name for name in names if name.endswith(".dist-info/WHEEL"))
        tags = re.findall(r"^Tag: (.*)$", archive.read(metadata).decode(), re.MULTILINE)
    return {name for name in names if name.endswith(".so")}, tags


@pytest.mark.slow
def test_the_wheel_holds_its_kernels_and_is_for_their_platform(installed, hatch_build):
    (wheel,) = installed.parent.glob("*.whl")
    kernels, tags = files_for(wheel)
    assert kernels == {f"pmjac_pin/{built}" for built in hatch_build.KERNELS}
    (tag,) = tags
    assert re.fullmatch(rf"py3-none-{sys.platform}_\w+", tag)


@pytest.mark.slow
def test_without_a_compiler_numpy_does_the_work_and_the_build_says_so(tmp_path):
    def hatchling(folder, *arguments):
        command = [sys.executable, "-m", "hatchling", "build", "-d", str(tmp_path), *arguments]
        environment = {**os.environ, "CC": "no-such-compiler"}
        done = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, check=True
        )
        return done.stdout + done.stderr

    hatchling(ROOT, "-t", "sdist")
    (source,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(source) as archive:
        assert not [name for name in archive.getnames() if name.endswith((".so", ".pyc"))]
        archive.extractall(tmp_path, filter="data")
    said = hatchling(source.with_name(source.name.removesuffix(".tar.gz")), "-t", "wheel")
    assert "no kernel is built, NumPy does its work" in " ".join(said.split())
    (wheel,) = tmp_path.glob("*.whl")
    assert files_for(wheel) == (set(), ["py3-none-any"])
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "site")
    code = "import pmjac_pin as pj; print(pj.batch(pj.load('four_bar')).runs_on)"
    assert run(tmp_path / "site", tmp_path, "-c", code).strip() == "NumPy"


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


def relative_links(text):
    """Return the places of links and pictures that no address begins."""
    return re.findall(r"\]\((?!https://|#)([^)]+)\)", text)


@pytest.mark.slow
def test_no_link_of_the_description_leads_nowhere(installed):
    (metadata,) = installed.glob("*.dist-info/METADATA")
    text = metadata.read_text(encoding="utf-8")
    assert "\nDescription-Content-Type: text/markdown\n" in text
    assert "`docs/formats.md`" in text
    assert not relative_links(text)


@pytest.mark.parametrize("repository", [None, "https://example.org/repository"])
def test_links_lead_to_the_repository_or_are_names(hatch_build, repository):
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    files = relative_links(readme)
    assert files
    assert all((ROOT / file).is_file() for file in files)
    text = hatch_build.described(readme, repository)
    assert not relative_links(text)
    assert all(file in text for file in files)
    if repository:
        assert f"[docs/formats.md]({repository}/blob/HEAD/docs/formats.md)" in text
        assert f"]({repository}/raw/HEAD/docs/assembly_modes.png)" in text


REPORTS = """
import json, sys
from contextlib import redirect_stdout
from io import StringIO
from pmjac_pin.cli import main
found = {}
for name in sys.argv[1:]:
    with redirect_stdout(StringIO()) as out:
        assert main(["report", name, "--json"]) == 0
    found[name] = json.loads(out.getvalue())
print(json.dumps(found))
"""


@pytest.mark.slow
def test_the_wheel_reports_the_same(installed, tmp_path):
    wheel, mine = (
        json.loads(run(folder, tmp_path, "-c", REPORTS, *pj.list_mechanisms()))
        for folder in (installed, ROOT)
    )
    assert wheel.keys() == set(pj.list_mechanisms())
    for name, report in mine.items():
        assert wheel[name] == report, name


@pytest.mark.slow
def test_the_wheel_is_run_as_a_module(installed, tmp_path):
    output = run(installed, tmp_path, "-m", "pmjac_pin", "report", "four_bar", "--json")
    assert json.loads(output)
