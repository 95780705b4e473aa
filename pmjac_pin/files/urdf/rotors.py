"""Rotors of a URDF's motors: what they add to the inertia of a joint."""

from __future__ import annotations

from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.files.xml_text import label, numbers


def rotors(urdf: Urdf) -> dict[str, float]:
    """Return the armatures of joints that move, kg m² or kg, in MuJoCo's or in Drake's way.

    ``<dynamics armature>`` as it is; a ``<drake:rotor_inertia>`` times the square of the
    ``<drake:gear_ratio>``, 1 where there is none.

    Raises
    ------
    ModelFileError
        A value that is no number, or below 0.
    """
    moving = {joint.name for joint in urdf.joints if joint.type != "fixed"}
    found = {}
    for joint in urdf.robot().iterfind("joint"):
        if (name := joint.get("name", "")) in moving and (armature := _armature(joint)):
            found[name] = armature
    return found


def _armature(joint: Element) -> float:
    where, armature = label(joint), _value(joint, "dynamics", "armature", 0.0)
    armature += _value(joint, "{*}rotor_inertia", "value", 0.0) * (
        _value(joint, "{*}gear_ratio", "value", 1.0) ** 2
    )
    if armature < 0.0:
        raise ModelFileError(f"{where}: the inertia of its rotor is below 0: {armature:g}")
    return armature


def _value(joint: Element, tag: str, key: str, default: float) -> float:
    element = joint.find(tag)
    if element is None or element.get(key) is None:
        return default
    (value,) = numbers(f"{label(joint)}, <{tag.removeprefix('{*}')}>", element, key)
    return value
