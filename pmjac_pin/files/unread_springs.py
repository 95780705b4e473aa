"""Springs that files give to joints: not read, and told."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from xml.etree.ElementTree import Element

from pmjac_pin.errors import enumerated

_IN_DYNAMICS = ("stiffness", "spring_stiffness")  # attributes, or elements with text


def spring_notes(joints: Iterable[str]) -> list[str]:
    """Return what is to be said of joints that have springs in their file.

    Examples
    --------
    >>> spring_notes(["knee"])
    ['springs of joints are not read (knee): give those that are to act to statics or dynamics']
    """
    sprung = list(dict.fromkeys(joints))
    todo = "give those that are to act to statics or dynamics"
    return [f"springs of joints are not read ({enumerated(sprung)}): {todo}"] if sprung else []


def sprung_joints(model: Element) -> Iterator[str]:
    """Yield the joints of a URDF's <robot> or of SDFormat's <model> that have springs."""
    for joint in model.iterfind("joint"):
        for dynamics in joint.iterfind(".//dynamics"):
            given = [dynamics.get(name) or dynamics.findtext(name) for name in _IN_DYNAMICS]
            if any(map(_is_some, given)):
                yield joint.get("name", "")
    for gazebo in model.iterfind("gazebo"):
        if _is_some(gazebo.findtext("springStiffness")):
            yield gazebo.get("reference", "")


def _is_some(text: str | None) -> bool:
    """Whether a number is given that is not zero, or what is none at all."""
    if text is None or not text.strip():
        return False
    try:
        return float(text) != 0.0
    except ValueError:
        return True
