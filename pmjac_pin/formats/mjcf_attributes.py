"""Misspelt attributes of MJCF, which would otherwise count as not given.

Which attributes there are grows with MuJoCo, so an unknown one is refused only where it looks
like one that is read.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError
from pmjac_pin.formats.mjcf_frames import ORIENTATIONS
from pmjac_pin.urdf_xml import label, shown

_POSE = ("name", "pos", *ORIENTATIONS)
_JOINT = ("name", "class", "type", "pos", "axis", "ref", "range", "limited")
_CLOSURE = ("name", "class", "active", "body1", "body2", "site1", "site2", "anchor")
_GEAR = ("name", "class", "active", "joint1", "joint2", "polycoef")
_BODY: Mapping[str, Sequence[str]] = {
    "body": (*_POSE, "childclass", "mocap"),
    "frame": (*_POSE, "childclass"),
    "site": (*_POSE, "class", "fromto"),
    "joint": _JOINT,
    "freejoint": ("name", "align"),
}
_SECTIONS: Mapping[str, Mapping[str, Sequence[str]]] = {
    "compiler": {
        "compiler": ("angle", "eulerseq", "autolimits", "coordinate", "alignfree"),
    },
    "default": {**_BODY, "default": ("class",), "equality": ("active",)},
    "worldbody": _BODY,
    "equality": {
        "connect": _CLOSURE,
        "weld": (*_CLOSURE, "relpose", "torquescale"),
        "joint": _GEAR,
    },
    "actuator": {"motor": ("name", "class", "joint", "jointinparent")},
}
_ALIKE = 0.75  # of difflib's ratio: "ps" is like "pos", "solref" is not like "ref"
_LONGEST = 40  # characters; a longer name is like none of them


def check_attributes(root: Element) -> None:
    """Refuse attributes that look like misspelt ones.

    Raises
    ------
    ModelFileError
        With the attribute that was meant.
    """
    for section in root:
        known = _SECTIONS.get(section.tag, {})
        for element in section.iter():
            for attribute in element.attrib:
                _check(element, attribute, known.get(element.tag, ()))


def _check(element: Element, attribute: str, known: Sequence[str]) -> None:
    if attribute in known or len(attribute) > _LONGEST:
        return
    # Also in the other case, which MuJoCo tells apart.
    if near := difflib.get_close_matches(attribute.lower(), known, n=1, cutoff=_ALIKE):
        where = label(element) if element.get("name") else f"<{element.tag}>"
        what = f"{where} has the unknown attribute {shown(attribute)}"
        raise ModelFileError(f"{what}; did you mean {near[0]!r}?")
