"""MJCF's geoms as the shapes of a URDF, for a picture."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

import numpy as np

from pmjac_pin.urdf_xml import numbers, written

# How many sizes each solid has, and how many of them `fromto` takes the place of.
SOLIDS: Mapping[str, tuple[int, int]] = {
    "sphere": (1, 0),
    "capsule": (2, 1),
    "cylinder": (2, 1),
    "box": (3, 2),
    "ellipsoid": (3, 2),
}


def half_sizes(geom: Element) -> list[float]:
    """Return the radius of a solid, its radius and half its length, or its three half-lengths.

    Raises
    ------
    ModelFileError
        A size that is no number.
    """
    kind = geom.get("type", "sphere")
    where, (count, given) = f"<geom> {geom.get('name', '')!r}", SOLIDS[kind]
    ends = geom.get("fromto")
    # More sizes than a solid has are allowed, and ignored.
    count -= given if ends else 0
    words = geom.get("size", "").split()[:count]
    sizes = numbers(where, Element("geom", size=" ".join(words)), "size", count=count)
    if not (ends and given):
        return sizes
    points = np.array(numbers(where, geom, "fromto", count=6))
    half = float(np.linalg.norm(points[3:] - points[:3])) / 2.0
    return [sizes[0]] * given + [half]


def shape(geom: Element) -> Element | None:
    """Return the shape of a geom with its defaults; None where a URDF has none.

    MuJoCo's sizes are half-lengths, a URDF's are whole ones.

    Raises
    ------
    ModelFileError
        A size that is no number.

    Examples
    --------
    >>> shape(Element("geom", type="capsule", size="0.1 0.5")).attrib
    {'radius': '0.1', 'length': '1.0'}
    >>> shape(Element("geom", type="mesh")) is None
    True
    """
    kind = geom.get("type", "sphere")
    if kind not in SOLIDS or kind == "ellipsoid" or geom.get("mesh") is not None:
        return None
    radius, *others = half_sizes(geom)
    if kind == "sphere":
        return Element(kind, radius=written([radius]))
    if kind == "box":
        return Element(kind, size=written(2.0 * side for side in (radius, *others)))
    return Element(kind, radius=written([radius]), length=written([2.0 * others[-1]]))
