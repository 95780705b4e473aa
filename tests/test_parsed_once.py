"""Each file is parsed once, whatever is made of it."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import looped
import mechanisms
import mjcf_models
import pytest

import pmjac_pin as pj
from pmjac_pin.files import xml_text as urdf_xml
from pmjac_pin.files.visuals import read_visuals


@pytest.fixture
def parsed(monkeypatch):
    """The XML texts that were parsed, and how often."""
    texts: Counter[str] = Counter()
    parse = urdf_xml.bounded_tree

    def counted(text: str):
        texts[text] += 1
        return parse(text)

    monkeypatch.setattr(urdf_xml, "bounded_tree", counted)
    return texts


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_a_catalogue_machine(name, parsed):
    mechanism = pj.load(name)
    assert parsed.total() == 1
    parsed.clear()
    other = pj.load(name, {key: 1.01 * value for key, value in mechanism.parameters.items()})
    read_visuals(other.urdf)
    assert parsed.total() == 1


SDF = """
<sdf version="1.7"><model name="arm"><link name="base"/><link name="rod"/>
  <joint name="swing" type="revolute"><parent>base</parent><child>rod</child>
    <axis><xyz>0 0 1</xyz></axis></joint></model></sdf>"""
FORMATS = {
    "urdf": (".urdf", looped.two_parents(), {"actuated": ["theta1"], "tool": looped.TOOL}),
    "extended urdf": (".urdf", looped.two_parents(), {"tool": looped.TOOL}),
    "sdf": (".sdf", SDF, {"actuated": ["swing"], "tool": "rod"}),
    "mjcf": (".xml", mjcf_models.FOUR_BAR, {"tool": "coupler"}),
}


@pytest.fixture(params=FORMATS)
def file(request, tmp_path):
    suffix, text, options = FORMATS[request.param]
    path = (tmp_path / "robot").with_suffix(suffix)
    path.write_text(text)
    if request.param == "extended urdf":
        closed = "closed_loop: []\nname_mot: [theta]\n"
        path.with_suffix(".yaml").write_text(closed)
    return path, options


def test_every_format(file, parsed):
    path, options = file
    pj.load(path, **options)
    assert parsed.total() == 1


def test_a_locked_joint(parsed):
    locked = pj.load("five_bar").passive[:1]
    parsed.clear()
    pj.load("five_bar", locked=locked)
    assert parsed.total() == 1


def test_another_cut_parses_nothing(parsed):
    mechanism = pj.load("four_bar")
    parsed.clear()
    pj.recut(mechanism, "phi1")
    assert not parsed


def test_what_is_written_is_read_once_to_see_that_it_can_be(file, parsed, tmp_path):
    path, options = file
    _, urdf = pj.convert(path, tmp_path / "mine.toml", **options)
    assert parsed == {path.read_text(): 1, urdf.read_text(): 1}


def test_each_included_file(parsed, tmp_path):
    (tmp_path / "robot.xml").write_text('<mujoco><include file="part.xml"/></mujoco>')
    (tmp_path / "part.xml").write_text(mjcf_models.FOUR_BAR)
    pj.load(Path(tmp_path / "robot.xml"), tool="coupler")
    assert sorted(parsed.values()) == [1, 1]
