"""Every Python block of the documentation runs and prints what it says; so do the commands."""

from __future__ import annotations

import doctest
import re
import shlex
import shutil
import tomllib
from pathlib import Path

import pytest

import pmjac_pin as pj
from pmjac_pin.cli import main

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
# Homotopies take seconds each.
RUN = [
    pytest.param(page, marks=pytest.mark.slow) if page.name == "all_solutions.md" else page
    for page in PAGES
    if page.name != "adapters.md"  # test_adapters.py, block by block, where libraries are there
]
OPTIONS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", RUN, ids=lambda page: page.name)
def test_python_blocks(page):
    source = "\n".join(blocks(page, "python"))
    test = doctest.DocTestParser().get_doctest(source, {}, page.name, str(page), 0)
    output: list[str] = []
    failed, _ = doctest.DocTestRunner(optionflags=OPTIONS).run(test, out=output.append)
    assert not failed, "".join(output)


def test_there_are_python_blocks_to_run():
    assert sum(len(blocks(page, "python")) for page in PAGES) >= 4


@pytest.mark.parametrize("command", re.findall(r"^\$ pmjac (.*)$", PAGES[0].read_text(), re.M))
def test_commands_of_the_readme(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(command)) == 0
    assert capsys.readouterr().out


CONSOLE = [
    (command, output)
    for page in PAGES
    for block in blocks(page, "console")
    for command, output in re.findall(r"^\$ pmjac (.*)\n((?:(?!\$ ).*\n)*)", block, re.M)
    if output
]


@pytest.mark.parametrize(("command", "output"), CONSOLE)
def test_commands_print_what_the_page_shows(command, output, tmp_path, monkeypatch, capsys):
    """An ellipsis stands for what the page leaves out."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    main(shlex.split(command))
    shown = capsys.readouterr().out
    assert doctest.OutputChecker().check_output(output, shown, doctest.ELLIPSIS)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_model_file_blocks_load(page, tmp_path):
    for number, block in enumerate(blocks(page, "toml")):
        if (urdf := tomllib.loads(block).get("urdf")) is None:
            continue  # a sweep file
        shutil.copy(ROOT / "urdf" / urdf, tmp_path)
        model_file = tmp_path / f"block{number}.toml"
        model_file.write_text(block)
        assert pj.load(model_file).home.jacobian().J_eq.shape[0] == 6


def test_the_sweep_file_runs(tmp_path, capsys):
    (block,) = blocks(ROOT / "docs" / "sweeps.md", "toml")
    (tmp_path / "map.toml").write_text(block)
    assert main(["sweep", str(tmp_path / "map.toml"), "--workers", "1"]) == 0
    assert "63 CLOSED" in capsys.readouterr().out


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text()):
        assert (page.parent / target).exists(), target
