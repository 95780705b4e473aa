"""MJCF's geoms as the shapes of a URDF, for a picture."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

import numpy as np

from pmjac_pin.urdf_xml import numbers, written

# How many sizes each shape has, and how many of them `fromto` takes the place of.
_SIZES: Mapping[str, tuple[int, int]] = {
    "sphere": (1, 0),
    "capsule": (2, 1),
    "cylinder": (2, 1),
    "box": (3, 2),
}


def shape(geom: Element) -> Element | None:
    """Return the shape of a geom with its defaults; None where it is no simple one.

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
    if kind not in _SIZES or geom.get("mesh") is not None:
        return None
    where, (count, given) = f"<geom> {geom.get('name', '')!r}", _SIZES[kind]
    half = 0.0
    if ends := geom.get("fromto"):
        count -= given
        points = np.array(numbers(where, geom, "fromto", count=6))
        half = float(np.linalg.norm(points[3:] - points[:3])) / 2.0
    # More sizes than a shape has are allowed, and ignored.
    words = geom.get("size", "").split()[:count]
    sizes = numbers(where, Element("geom", size=" ".join(words)), "size", count=count)
    radius, *others = [*sizes, half] if ends else sizes
    if kind == "sphere":
        return Element(kind, radius=written([radius]))
    if kind == "box":
        box = (radius, radius, half) if ends else (radius, *others)
        return Element(kind, size=written(2.0 * side for side in box))
    return Element(kind, radius=written([radius]), length=written([2.0 * others[-1]]))
