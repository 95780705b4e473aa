"""What the site needs of the pages, without building it."""

from __future__ import annotations

import importlib.util
import inspect
import re
import sys
from functools import reduce
from pathlib import Path

import pytest

import pmjac_pin as pj

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
_LOADED = importlib.util.spec_from_file_location("stage", DOCS / "website" / "stage.py")
stage = importlib.util.module_from_spec(_LOADED)
sys.modules["stage"] = stage
_LOADED.loader.exec_module(stage)


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site") / "source"
    stage.stage(folder)
    return folder


def listed(page):
    """Return the pages in the tables of contents of a page."""
    blocks = re.findall(r"^```\{toctree\}\n(.*?)^```", page.read_text(), re.M | re.S)
    return [
        line.removesuffix(".rst")
        for block in blocks
        for line in block.splitlines()
        if line and line[0] != ":"
    ]


def test_each_page_is_once_in_the_contents(site):
    files = [*site.rglob("*.md"), *site.rglob("*.rst")]
    pages = {page.relative_to(site).with_suffix("").as_posix() for page in files} - {"index"}
    contents = listed(site / "index.md") + listed(site / "api.md")
    assert len(contents) == len(set(contents))
    assert {*contents} == pages | {page.rsplit(".")[0] for page in stage.MADE}


def test_every_public_name_has_a_page(site):
    names = {page.stem for page in (site / "api").glob("*.rst")}
    assert names == {*pj.__all__}
    listed_names = re.findall(r"^- \[`(\w+)`\]", (site / "api.md").read_text(), re.M)
    assert sorted(listed_names) == sorted(pj.__all__)


@pytest.mark.parametrize("name", pj.__all__)
def test_every_public_name_has_a_summary(name):
    assert stage.summary(name).endswith((".", "page."))
    inherited = [inspect.getdoc(base) for base in getattr(getattr(pj, name), "__mro__", [])[1:]]
    assert inspect.getdoc(getattr(pj, name)) not in inherited


CALLS = re.findall(r"`pj\.([\w.]+)`", (DOCS / "which_call.md").read_text(encoding="utf-8"))


@pytest.mark.parametrize("call", sorted(set(CALLS)))
def test_the_calls_that_answer_questions_exist(call):
    assert callable(reduce(getattr, call.split("."), pj))


ROWS = [
    (re.findall(r"`pj\.([\w.]+)`", line), re.findall(r"\]\(([^)#]+)", line))
    for line in (DOCS / "which_call.md").read_text(encoding="utf-8").splitlines()
    if "`pj." in line
]


@pytest.mark.parametrize(("calls", "targets"), [row for row in ROWS if row[1]])
def test_the_page_beside_a_call_speaks_of_it(calls, targets):
    told = "".join((DOCS / target).read_text(encoding="utf-8") for target in targets)
    for call in calls:
        assert re.search(rf"\b{call.split('.')[-1]}\b", told)


def test_links_stay_on_the_site(site):
    for page in site.glob("*.md"):
        for target in re.findall(r"\]\((?![a-z]+:|#)([^)#]+)", page.read_text()):
            assert target in stage.MADE or (page.parent / target).exists(), (page, target)


def test_links_to_elsewhere_are_whole_and_lead_somewhere_safe(site):
    """Whether what they lead to is there, nothing here can ask."""
    for page in [*site.glob("*.md"), ROOT / "paper.md"]:
        prose = re.sub(r"^```.*?^```|`[^`\n]*`", "", page.read_text(), flags=re.M | re.S)
        for target in re.findall(r"\]\(([a-z]+:[^)]*)\)", prose):
            assert re.fullmatch(r"https://[\w-]+(\.[\w-]+)+(/[\w./#%~-]*)?", target), (page, target)
        unlinked = re.sub(r"\]\([^)]*\)", "", prose)
        assert not re.search(r"://|\b[\w-]+/[\w-]+#\d", unlinked), page


def test_a_link_to_a_file_that_is_not_on_the_site_becomes_its_words():
    page = DOCS / "evidence.md"
    text = "[a test](../tests/conftest.py), [a page](reach.md#how), [all](../README.md#limits)"
    there = "a test, [a page](reach.md#how), [all](readme.md#limits)"
    assert stage.with_links(text, page, stage.pages()) == there
    kept = "```python\n[code](../tests/conftest.py)\n```"
    assert stage.with_links(kept, page, stage.pages()) == kept


def test_start_here_is_ten_lines():
    page = (DOCS / "start.md").read_text(encoding="utf-8")
    cells = re.findall(r"^```\{code-cell\} \w+\n(.*?)^```", page, re.M | re.S)
    assert sum(len(cell.splitlines()) for cell in cells) == 10


def test_the_settings_fetch_nothing_from_elsewhere():
    """Of Sphinx's extensions those that would, intersphinx and CDNs, are not used."""
    settings = (DOCS / "website" / "conf.py").read_text(encoding="utf-8")
    assert "intersphinx" not in settings
    assert "http" not in settings
    assert '"sphinx-mathjax-offline"' in settings
    assert '"write_computation_times": False' in settings
