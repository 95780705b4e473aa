"""MJCF's geoms as the shapes of a URDF, for a picture."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element

from pmjac_pin.files.tree_urdf import undrawn
from pmjac_pin.files.xml_text import written

# Those that a URDF has, by their number in mujoco.mjtGeom.
_GEOMS = {2: "sphere", 3: "capsule", 5: "cylinder", 6: "box"}


def shape(kind: int, size: Sequence[float]) -> Element:
    """Return the shape of a geom; one that is not drawn where a URDF has none.

    MuJoCo's sizes are half-lengths, a URDF's are whole ones.

    Examples
    --------
    >>> shape(3, [0.1, 0.5, 0.0]).attrib
    {'radius': '0.1', 'length': '1.0'}
    >>> shape(7, [0.0, 0.0, 0.0]).tag
    'mesh'
    """
    if (name := _GEOMS.get(kind)) is None:
        return undrawn(f"geom of type {kind}")
    if name == "sphere":
        return Element(name, radius=written(size[:1]))
    if name == "box":
        return Element(name, size=written(2.0 * side for side in size))
    return Element(name, radius=written(size[:1]), length=written([2.0 * size[1]]))
