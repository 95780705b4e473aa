"""The visuals of a URDF that can be drawn without opening another file."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.anchors import placement_of
from pmjac_pin.files.shapes import Box, Colour, Cylinder, Shape, Sphere, scaled
from pmjac_pin.files.urdf.checks import checked_origin
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.files.xml_text import label, numbers
from pmjac_pin.values.arrays import Array

_logger = logging.getLogger(__name__)

# A shape and its transform in the visual's origin.
_PlacedShape = tuple[Shape, Array]


@dataclass(frozen=True, eq=False)
class Visual:
    """One <visual>.

    Attributes
    ----------
    link : str
    name : str
        Its own, or "visual1", "visual2", ... in the link.
    pieces : list of (Shape, ndarray of shape (4, 4))
        Shapes and their transforms in the link's frame; none where it is a mesh, or not to be
        understood.
    colour : Colour or None
        None where the URDF gives none.
    """

    link: str
    name: str
    pieces: list[_PlacedShape]
    colour: Colour | None


@dataclass(frozen=True, eq=False)
class DrawnElement:
    """A shape of a URDF as the file has it, a mesh too.

    Attributes
    ----------
    link : str
    shape : Element
        <box>, <cylinder>, <sphere>, <capsule> or <mesh>.
    place : pin.SE3
        In the link's frame.
    colour : Colour or None
    """

    link: str
    shape: Element
    place: pin.SE3
    colour: Colour | None


def drawn_elements(urdf: Urdf) -> Iterator[DrawnElement]:
    """Yield the shapes of all links in file order, but for those that are broken."""
    robot = urdf.robot()
    colours = _named_colours(robot)
    for link in robot.iterfind("link"):
        for visual in link.iterfind("visual"):
            shape = visual.find("geometry/*")
            if shape is None or not (shape.tag == "mesh" or _pieces(link, visual)):
                continue
            place = placement_of(checked_origin(f"{label(link)}, <visual>", visual))
            yield DrawnElement(link.get("name", ""), shape, place, _colour(visual, colours))


def read_visuals(urdf: Urdf) -> list[Visual]:
    """Return the visuals of all links in file order."""
    robot = urdf.robot()
    colours = _named_colours(robot)
    return [
        Visual(
            link.get("name", ""),
            visual.get("name") or f"visual{number}",
            _pieces(link, visual),
            _colour(visual, colours),
        )
        for link in robot.iterfind("link")
        for number, visual in enumerate(link.iterfind("visual"), start=1)
    ]


def _pieces(link: Element, visual: Element) -> list[_PlacedShape]:
    """Return nothing for a broken visual: a picture is no reason to refuse a mechanism."""
    where = f"{label(link)}, <visual>"
    try:
        origin = placement_of(checked_origin(where, visual)).homogeneous
        geometry = visual.find("geometry")
        shapes = [] if geometry is None else list(geometry)
        return [
            (shape, origin @ transform)
            for element in shapes[:1]
            for shape, transform in _shapes(f"{where}, <{element.tag}>", element)
        ]
    except ModelFileError as error:
        _logger.warning("not drawn: %s", error)
        return []


def _shapes(where: str, element: Element) -> Iterator[_PlacedShape]:
    match element.tag:
        case "box":
            yield Box(), scaled(_positive_numbers(where, element, "size", 3))
        case "sphere":
            yield Sphere(), scaled(_positive_numbers(where, element, "radius"))
        case "cylinder" | "capsule":
            radius = _positive_numbers(where, element, "radius")
            length = _positive_numbers(where, element, "length")
            yield Cylinder(), scaled(np.concatenate([radius, radius, length]))
            if element.tag == "capsule":
                for end in (-0.5, 0.5):
                    ball = scaled(radius)
                    ball[2, 3] = end * length[0]
                    yield Sphere(), ball
        case "mesh":  # bars are drawn in its place
            return
        case _:
            known = "box, sphere, cylinder, capsule or mesh"
            raise ModelFileError(f"{where}: this shape is no {known}")


def _positive_numbers(where: str, element: Element, attribute: str, count: int = 1) -> Array:
    values = np.array(numbers(where, element, attribute, count=count))
    if values.min() <= 0.0:
        raise ModelFileError(f"{where}: `{attribute}` is {values}; it must be positive")
    return values


def _named_colours(robot: Element) -> dict[str, Colour]:
    found = {}
    # A material may be defined within a visual too, and be known to all others by its name.
    for path in ("link/visual/material", "material"):
        for material in robot.iterfind(path):
            if (colour := _rgba(material)) is not None:
                found[material.get("name", "")] = colour
    return found


def _colour(visual: Element, named: Mapping[str, Colour]) -> Colour | None:
    material = visual.find("material")
    if material is None:
        return None
    return _rgba(material) or named.get(material.get("name", ""))


def _rgba(material: Element) -> Colour | None:
    if (element := material.find("color")) is None:
        return None
    try:
        red, green, blue, alpha = numbers("<color>", element, "rgba", count=4)
    except ModelFileError as error:
        _logger.warning("%s has no colour: %s", label(material), error)
        return None
    red, green, blue, alpha = np.clip([red, green, blue, alpha], 0.0, 1.0).tolist()
    return (red, green, blue, alpha)
