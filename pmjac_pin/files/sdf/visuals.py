"""The visuals of SDFormat's links as a URDF has them: for pictures, and to tell bodies apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import pinocchio as pin

from pmjac_pin.files.sdf.frames import Frames, pose
from pmjac_pin.files.tree_urdf import undrawn
from pmjac_pin.files.urdf.robot import SIZE_ATTRIBUTES
from pmjac_pin.files.vocabulary import spelt
from pmjac_pin.files.xml_text import label, only

_EMPTY = "empty"


@dataclass(frozen=True, eq=False)
class SdfVisual:
    """One <visual>.

    Attributes
    ----------
    link : str
    placement : pin.SE3
        In the link's frame.
    shape : Element
        As a URDF has it.
    rgba : str or None
    """

    link: str
    placement: pin.SE3
    shape: Element
    rgba: str | None


def read_sdf_visuals(links: Sequence[Element], frames: Frames) -> Iterator[SdfVisual]:
    """Yield the visuals in file order.

    Sizes are handed on as they are written: what reads a URDF's looks at them.

    Raises
    ------
    ModelFileError
        A pose that is none.
    """
    for link in links:
        name = link.get("name", "")
        for visual in link.iterfind("visual"):
            where = f"{label(link)}, {label(visual)}"
            geometry = only(where, visual, "geometry")
            if geometry is None or len(geometry) == 0 or geometry[0].tag == _EMPTY:
                continue
            relative_to, placement = pose(where, visual, name)
            seen = frames.placement(name, where).actInv(frames.placement(relative_to, where))
            yield SdfVisual(name, seen * placement, _shape(geometry[0]), _diffuse(visual))


def _shape(element: Element) -> Element:
    """Return a shape as a URDF has it."""
    if (sizes := SIZE_ATTRIBUTES.get(element.tag)) is not None:  # by which both describe it
        return Element(element.tag, {size: _text_of_child(element, size) for size in sizes})
    return undrawn(_text_of_child(element, "uri") or spelt(element.tag))


def _diffuse(visual: Element) -> str | None:
    material = visual.find("material")
    diffuse = "" if material is None else _text_of_child(material, "diffuse")
    words = diffuse.split()
    return " ".join([*words, "1"][:4]) if len(words) in (3, 4) else None


def _text_of_child(element: Element, tag: str) -> str:
    return (element.findtext(tag) or "").strip()
