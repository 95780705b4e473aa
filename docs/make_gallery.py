"""Make the gallery: a page a mechanism of the catalogue, and an index with pictures.

Run `python docs/make_gallery.py [FOLDER]`, by default into build/gallery. There `pages` has
Markdown and pictures, to be put beside the documentation's pages as `gallery`, and `files` what a
site copies as it is: `gallery/scenes`, a scene a mechanism, each one file that loads nothing.
"""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from gallery_page import write_page

import pmjac_pin as pj

ROOT = Path(__file__).resolve().parent.parent
REFERENCES = Path(__file__).with_name("gallery_references.toml")
PROCESSES = 2
ACROSS = 3  # pictures in a row of the index


def make_gallery(folder: Path, names: tuple[str, ...]) -> None:
    """Write the pages of these mechanisms, and their index."""
    pages, scenes = folder / "pages", folder / "files" / "gallery" / "scenes"
    for place in (pages, scenes):
        place.mkdir(parents=True, exist_ok=True)
    references = tomllib.loads(REFERENCES.read_text(encoding="utf-8"))
    with ProcessPoolExecutor(PROCESSES, get_context("spawn")) as workers:
        written = {
            name: workers.submit(write_page, name, pages, scenes, tuple(references.get(name, ())))
            for name in names
        }
        described = {name: page.result() for name, page in written.items()}
    text = index(described, references["every"])
    (pages / "index.md").write_text(text, encoding="utf-8")


def index(described: Mapping[str, str], references: list[str]) -> str:
    """Return the index: a picture, a name and a sentence a mechanism."""
    cells = [
        f"[![{name}]({name}_small.png)]({name}.md)<br>**[{name}]({name}.md)**<br>{sentence}"
        for name, sentence in described.items()
    ]
    cells += [""] * (-len(cells) % ACROSS)
    rows = [cells[k : k + ACROSS] for k in range(0, len(cells), ACROSS)]
    listed = "\n".join(described)
    return "\n".join(
        [
            "# Gallery\n",
            "Every mechanism of the catalogue: the machine in three dimensions, its mobility, its "
            "matrices at home, assembly and working modes with what they rest on, a map, and where "
            "it comes from. All numbers were computed when this page was made.\n",
            "| " + " | ".join([" "] * ACROSS) + " |",
            "|" + ":---:|" * ACROSS,
            *("| " + " | ".join(row) + " |" for row in rows),
            "\nFor all of them:\n",
            *(f"- {reference}" for reference in references),
            f"\n```{{toctree}}\n:hidden:\n:maxdepth: 1\n\n{listed}\n```\n",
        ]
    )


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "gallery"
    make_gallery(target, tuple(pj.list_mechanisms()))
    print(f"{target}: {len(list((target / 'pages').glob('*.md')))} pages")
