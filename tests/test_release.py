"""What goes with a release says the same in all its places."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
MATRIX = runpy.run_path(str(ROOT / "scripts" / "test_matrix.py"))
PAPER = (ROOT / "paper.md").read_text(encoding="utf-8")

#: Few, that use each dependency.
TELLING = (
    "test_lecture.py",
    "test_catalog.py",
    "test_certificate.py::test_every_named_pose_is_certified",
    "test_closure_yaml.py::test_all_keys",
    "test_mjcf.py::test_a_four_bar_by_connect",
    "test_model_file.py::test_bad_model_files",
    "test_plotting.py::test_other_formats[PNG]",
    "test_report.py",
    "test_sweep.py::test_measures",
    "test_sweep.py::test_the_command",
    "test_viewer.py::test_save_html",
)


def test_the_version_is_that_of_the_citation_and_of_the_newest_changes():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    newest, date = re.search(r"^## (\S+), (\S+)$", changes, re.MULTILINE).groups()
    assert citation["version"] == newest == PROJECT["version"]
    assert str(citation["date-released"]) == date


def test_what_the_paper_cites_is_in_its_references():
    keys = re.findall(r"^@\w+\{(\w+),$", (ROOT / "paper.bib").read_text(encoding="utf-8"), re.M)
    assert sorted(set(keys)) == sorted(keys)
    assert set(re.findall(r"@(\w+)", PAPER)) == set(keys)


def test_the_paper_has_the_sections_and_the_length_that_its_journal_asks_for():
    """https://joss.readthedocs.io/en/latest/paper.html"""
    assert re.findall(r"^# (.*)$", PAPER.split("---\n", 2)[2], re.M) == [
        "Summary",
        "Statement of need",
        "State of the field",
        "Software design",
        "Research impact statement",
        "AI usage disclosure",
        "Acknowledgements",
        "References",
    ]
    prose = [line for line in PAPER.splitlines() if not line.startswith("|")]
    assert 750 <= len(" ".join(prose).split()) <= 1750


def without_numbers(cell):
    return re.sub(r"\d\S*", "#", cell.strip())


@pytest.mark.slow
def test_the_papers_table_is_what_the_script_finds(monkeypatch):
    """The column of this library; how many digits rounding leaves is the processor's."""
    monkeypatch.syspath_prepend(str(ROOT / "scripts"))
    known = runpy.run_path(str(ROOT / "scripts" / "compared" / "known.py"))
    found = runpy.run_path(str(ROOT / "scripts" / "compared" / "with_pmjac_pin.py"))["answers"]()
    rows = [row.split("|")[1:3] for row in PAPER.splitlines() if row.startswith("| ")][1:]
    told = {question.strip(): cell for question, cell in rows}
    assert list(told) == list(known["QUESTIONS"].values())
    for key, question in known["QUESTIONS"].items():
        assert without_numbers(told[question]) == without_numbers(found[key])
    assert found["mobility"] == told[known["QUESTIONS"]["mobility"]].strip()


@pytest.fixture(scope="module")
def released(tmp_path_factory):
    """Return the folder of what is released, and what was said when it was built."""
    for needed in ("uv", "twine", "auditwheel"):
        pytest.importorskip(needed)
    folder = tmp_path_factory.mktemp("dist")
    return folder, said_by("build_distributions.py", folder)


def said_by(script, *arguments):
    command = [sys.executable, ROOT / "scripts" / script, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return " ".join(done.stdout.split())


@pytest.mark.slow
def test_what_is_released_is_built_looked_at_and_installed(released):
    folder, said = released
    assert said.count("PASSED") == 2
    assert "installed, its batches run on kernel" in said
    assert "built without a C compiler, its batches run on NumPy" in said
    wheel, source = sorted(file.name for file in folder.iterdir())
    assert source == f"pmjac_pin-{PROJECT['version']}.tar.gz"
    platform = "many" if sys.platform.startswith("linux") else sys.platform
    assert wheel.startswith(f"pmjac_pin-{PROJECT['version']}-py3-none-{platform}")


@pytest.mark.slow
@pytest.mark.parametrize("python", MATRIX["PYTHONS"])
def test_what_is_released_works_with_the_versions_that_it_declares(released, python):
    """With the lowest and the newest ones; `make matrix` takes more tests, and the adapters."""
    if MATRIX["interpreter"](python) is None:
        pytest.skip(f"Python {python} is not on this machine")
    cells = ("--dist", released[0], "--python", python, "--adapters", "--tests", *TELLING)
    said = said_by("test_matrix.py", *cells)
    for versions in ("lowest", "newest"):
        assert re.search(rf"Python {python}, {versions} versions: =* ?\d+ passed", said), said


@pytest.mark.parametrize("file", sorted((ROOT / ".github" / "ISSUE_TEMPLATE").iterdir()))
def test_an_issue_template_has_a_name_and_asks_for_something(file):
    _, head, body = file.read_text(encoding="utf-8").split("---\n", 2)
    assert {"name", "about"} <= yaml.safe_load(head).keys()
    assert body.count("**") >= 6
