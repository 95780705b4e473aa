"""Placed numbers: the origins and sizes in a URDF that parameters may move."""

from __future__ import annotations

from typing import NamedTuple

from pmjac_pin.files.urdf.robot import SIZE_ATTRIBUTES, Urdf
from pmjac_pin.files.xml_text import numbers, parse_xml


class Origin(NamedTuple):
    """Where a joint is in its parent link: m, and roll, pitch and yaw in rad."""

    xyz: tuple[float, ...]
    rpy: tuple[float, ...]


def origins_of(urdf: Urdf) -> dict[str, Origin]:
    """Return the origins of the joints, by their names.

    Examples
    --------
    >>> from pmjac_pin.files.urdf.robot import parse_urdf
    >>> text = '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="fixed">'
    >>> text += '<origin xyz="1 0 0"/><parent link="a"/><child link="b"/></joint></robot>'
    >>> origins_of(parse_urdf(text, "r.urdf"))["j"].xyz
    (1.0, 0.0, 0.0)
    """
    found = {}
    for joint in parse_xml(urdf.kinematic_xml()).iterfind("joint"):
        origin = joint.find("origin")
        given = (
            tuple(numbers("origin", origin, key, default="0 0 0", count=3))
            for key in ("xyz", "rpy")
        )
        found[joint.get("name", "")] = Origin(*given)
    return found


def sizes_of(urdf: Urdf) -> dict[tuple[str, str], tuple[float, ...]]:
    """Return the sizes of shapes that have names, by these and the attribute.

    Examples
    --------
    >>> from pmjac_pin.files.urdf.robot import parse_urdf
    >>> text = '<robot name="r"><link name="a"><visual name="disc"><geometry>'
    >>> text += '<sphere radius="2"/></geometry></visual></link></robot>'
    >>> sizes_of(parse_urdf(text, "r.urdf"))
    {('disc', 'radius'): (2.0,)}
    """
    found = {}
    for visual in urdf.robot().iterfind("link/visual"):
        for shape in visual.iterfind("geometry/*"):
            for attribute in SIZE_ATTRIBUTES.get(shape.tag, ()):
                count = 3 if attribute == "size" else 1
                size = numbers("shape", shape, attribute, count=count)
                found[visual.get("name", ""), attribute] = tuple(size)
    return found
