"""The gallery: its pages say what the library computes, and need nothing from elsewhere."""

from __future__ import annotations

import re
import tomllib

import gallery_page
import make_gallery
import numpy as np
import pytest
from hand_planar import slider_crank
from mechanisms import CATALOGUE, loaded

REFERENCES = tomllib.loads(make_gallery.REFERENCES.read_text(encoding="utf-8"))


def written(name, folder):
    pages, scenes = folder / "pages", folder / "scenes"
    for place in (pages, scenes):
        place.mkdir(exist_ok=True)
    sentence = gallery_page.write_page(name, pages, scenes, tuple(REFERENCES.get(name, ())))
    assert sentence == loaded(name).spec.description
    return pages, (pages / f"{name}.md").read_text(encoding="utf-8")


def entry(page, row):
    """The first number of a row of the last table that has it."""
    return float(re.findall(rf"^\| {row} \\\[\S+\] \| (\S+) ", page, re.M)[-1])


def looks_complete(name, pages, page):
    scene = (pages.parent / "scenes" / f"{name}.html").read_text(encoding="utf-8")
    assert not re.search(r"""(src|href)=["']?(http|//)""", scene)
    assert f'src="scenes/{name}.html"' in page
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", page)
    assert f"{name}.png" in pictures
    assert f"{name}_map.png" in pictures
    for picture in [*pictures, f"{name}_small.png"]:
        assert (pages / picture).stat().st_size > 1000
    headings = re.findall("^## (.*)$", page, re.M)
    known = ["Mobility", "Matrices at home", "Assembly modes", "Working modes", "Map", "References"]
    assert [heading for heading in headings if heading in known] == known
    assert "nan" not in page


def test_a_slider_cranks_page_has_its_closed_form(tmp_path):
    pages, page = written("slider_crank", tmp_path)
    mechanism = loaded("slider_crank")
    sizes = [mechanism.parameters[name] for name in ("r", "l", "e")]
    _, speed = slider_crank(mechanism.home.actuated[0], *sizes)
    assert entry(page, "v_x") == pytest.approx(speed, abs=5e-5)
    assert "| **mobility**, by rank | 1 |" in page
    assert "are 2 ways" in page
    assert "proof: exactly 2" in page
    looks_complete("slider_crank", pages, page)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in CATALOGUE if name != "slider_crank"])
def test_every_page(name, tmp_path):
    pages, page = written(name, tmp_path)
    looks_complete(name, pages, page)
    J_eq = loaded(name).home.jacobian().J_eq
    rows = ("v_x", "v_y", "v_z", "ω_x", "ω_y", "ω_z")
    found = [entry(page.split("## Assembly modes")[0], row) for row in rows]
    np.testing.assert_allclose(found, J_eq[:, 0], atol=6e-5 * max(1.0, np.abs(J_eq).max()))
    assert f"| **mobility**, by rank | {loaded(name).mobility} |" in page


@pytest.mark.slow
def test_it_is_made_where_it_is_asked_for(tmp_path):
    make_gallery.make_gallery(tmp_path / "new", ("slider_crank", "serial_2r"))
    files = {path.relative_to(tmp_path / "new").as_posix() for path in tmp_path.rglob("*.*")}
    scenes = {"files/gallery/scenes/serial_2r.html", "files/gallery/scenes/slider_crank.html"}
    assert files >= {"pages/index.md", "pages/serial_2r.md", "pages/slider_crank.md"} | scenes


def test_the_index_shows_every_mechanism():
    page = make_gallery.index({name: f"about {name}" for name in CATALOGUE}, REFERENCES["every"])
    for name in CATALOGUE:
        assert f"[![{name}]({name}_small.png)]({name}.md)<br>**[{name}]({name}.md)**" in page
    assert page.split("toctree")[1].split()[4:-1] == list(CATALOGUE)


def test_what_is_said_of_single_mechanisms_is_said_of_such_as_there_are():
    named = {*REFERENCES} - {"every"}
    named |= {*gallery_page.WORKSPACES, *gallery_page.LOCI, *gallery_page.LONG_WORKING_MODES}
    assert named <= {*CATALOGUE}
