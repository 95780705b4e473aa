"""Puts together what Sphinx reads: the pages of `docs/`, the README, and a page for each name.

The pages stay as they are read beside the code. Links that lead out of `docs/` are led to the
page's place on the site; `index.md` says in which order pages are, `api.md` which names there are.
Run by `make docs`: `python docs/website/stage.py FOLDER`.
"""

from __future__ import annotations

import inspect
import re
import shutil
import sys
from os.path import relpath
from pathlib import Path

import pmjac_pin as pj

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"

#: Pages that stand elsewhere than in docs/, and where the site has them.
ELSEWHERE = {
    ROOT / "README.md": "readme.md",
    ROOT / "CHANGELOG.md": "changelog.md",
    ROOT / "CONTRIBUTING.md": "contributing.md",
    ROOT / "examples": "examples/index.rst",
    DOCS / "make_gallery.py": "gallery/index.md",
}

#: Who writes them, where it is not this.
MADE = {"examples/index.rst": "sphinx-gallery", "gallery/index.md": "docs/make_gallery.py"}

PICTURES = {".png", ".svg"}

_FENCED = re.compile(r"(^```.*?^```$)", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"(!?)\[([^]]*)\]\((?![a-z]+:|#)([^)#]+)(#[^)]*)?\)")
_LISTED_NAME = re.compile(r"^- `(\w+)`$", re.MULTILINE)


def pages() -> dict[Path, str]:
    """Return the place on the site of each page that is written by hand."""
    own = {page: page.relative_to(DOCS).as_posix() for page in sorted(DOCS.glob("*.md"))}
    return {page: place for page, place in (own | ELSEWHERE).items() if page.exists()}


def with_links(text: str, page: Path, places: dict[Path, str]) -> str:
    """Lead its links to where things are on the site; files that are not there are named only."""

    def led(match: re.Match[str]) -> str:
        mark, words, path, part = match.groups()
        target = (page.parent / path).resolve()
        if target in places:
            place = relpath(places[target], Path(places[page]).parent)
        elif target.suffix in PICTURES and target.is_relative_to(DOCS):
            place = relpath(target.relative_to(DOCS), Path(places[page]).parent)
        else:
            return words
        return f"{mark}[{words}]({place}{part or ''})"

    return "".join(
        piece if piece.startswith("```") else _LINK.sub(led, piece) for piece in _FENCED.split(text)
    )


def contents(index: str) -> list[tuple[str, list[str]]]:
    """Return the captions of the index, each with the pages below it, in their order."""
    found: list[tuple[str, list[str]]] = []
    for line in index.splitlines():
        if caption := re.fullmatch(r"\*\*(.+)\*\*", line):
            found.append((caption[1], []))
        elif found:
            found[-1][1].extend(re.findall(r"\]\(([\w/.]+)\.(?:md|rst)\)", line))
    return found


def toctree(places: list[str], caption: str = "") -> str:
    """Return a table of contents for the margin."""
    named = [f":caption: {caption}"] if caption else []
    return "\n".join(["", "```{toctree}", ":hidden:", *named, "", *places, "```", ""])


def with_contents(index: str) -> str:
    """Add the tables of contents that the index tells."""
    return index + "".join(toctree(places, caption) for caption, places in contents(index))


def summary(name: str) -> str:
    """Return the first sentence of its docstring."""
    first = (inspect.getdoc(getattr(pj, name)) or "").split("\n\n")[0]
    return " ".join(first.split())


def with_summaries(api: str) -> str:
    """Say in the list of names what each is, and lead there."""

    def told(match: re.Match[str]) -> str:
        return f"- [`{match[1]}`](api/{match[1]}.rst): {summary(match[1])}"

    return _LISTED_NAME.sub(told, api) + toctree(
        [f"api/{name}" for name in _LISTED_NAME.findall(api)]
    )


def page_of(name: str) -> str:
    """Return the page of a public name, all of it from its docstrings."""
    value = getattr(pj, name)
    lines = [f"{name}\n{'=' * len(name)}", ".. currentmodule:: pmjac_pin"]
    if inspect.ismodule(value):
        return "\n\n".join([lines[0], f".. automodule:: pmjac_pin.{name}\n"])
    if not inspect.isclass(value):
        return "\n\n".join([*lines, f".. autofunction:: {name}\n"])
    kind = "autoexception" if issubclass(value, BaseException) else "autoclass"
    foreign = [base.__name__ for base in value.__mro__ if not _ours(base)]
    options = f"   :members:\n   :inherited-members: {','.join(foreign)}\n"
    return "\n\n".join([*lines, f".. {kind}:: {name}\n{options}"])


def _ours(base: type) -> bool:
    return base.__module__.startswith("pmjac_pin")


def stage(folder: Path) -> None:
    """Write everything that Sphinx reads into a new folder."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "api").mkdir(parents=True)
    places = pages()
    for page, place in places.items():
        if place in MADE:
            continue
        text = with_links(page.read_text(encoding="utf-8"), page, places)
        if place == "index.md":
            text = with_contents(text)
        elif place == "api.md":
            for name in _LISTED_NAME.findall(text):
                (folder / "api" / f"{name}.rst").write_text(page_of(name), encoding="utf-8")
            text = with_summaries(text)
        (folder / place).write_text(text, encoding="utf-8")
    for picture in DOCS.iterdir():
        if picture.suffix in PICTURES:
            shutil.copy2(picture, folder)


if __name__ == "__main__":
    stage(Path(sys.argv[1]))
