"""A URDF enters the readers of what it holds, and no others."""

from __future__ import annotations

import re
from xml.etree.ElementTree import Element, SubElement

import pytest

import pmjac_pin as pj
from pmjac_pin.files.urdf import dialects

PATHS = [path for paths, _ in dialects.DIALECTS for path in paths]


def robot_with(path):
    """A <robot> that holds one thing at a path."""
    robot = element = Element("robot", name="r")
    for step in filter(None, path.removeprefix(".").split("/")):
        tag, key, value = re.fullmatch(r"([^\[]+)(?:\[@(\w+)='(\w+)'\])?", step).groups()
        given = {key: value} if key else {}
        element = SubElement(element, tag.replace("{*}", "{http://drake.mit.edu}"), given)
    return robot


@pytest.fixture
def entered(monkeypatch):
    """The paths of the readers that were entered."""
    found = []
    readers = tuple(
        (paths, lambda robot, said, paths=paths: found.append(paths))
        for paths, _ in dialects.DIALECTS
    )
    monkeypatch.setattr(dialects, "DIALECTS", readers)
    return found


@pytest.mark.parametrize("path", dict.fromkeys(PATHS))
def test_each_element_asks_for_its_reader(entered, path):
    dialects.take_said(robot_with(path))
    assert any(path in paths for paths in entered)
    assert all(any(robot_with(path).find(one) is not None for one in paths) for paths in entered)


def test_what_is_not_there_asks_for_none(entered):
    dialects.take_said(robot_with("joint/limit"))
    assert entered == []


@pytest.mark.parametrize("name", ["four_bar", "three_rps", "bennett"])
def test_a_plain_urdf_needs_no_dialect(entered, name):
    pj.load(name)
    assert entered == []
