"""Rotors of a URDF's motors: what they add to the inertia of a joint."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.xml_text import check_name, label, numbers, only


def rotors(robot: Element) -> dict[str, float]:
    """Return the armatures of a <robot>'s joints that move, kg m² or kg.

    ``<dynamics armature>`` as MuJoCo has it, and Drake's ``<drake:rotor_inertia>``, in the joint or
    in the actuator of its transmission, times the square of the ``<drake:gear_ratio>`` beside it,
    1 where there is none.

    Raises
    ------
    ModelFileError
        A value that is no number, or below 0; a transmission whose joint is not in the file, or
        that has several joints.
    """
    joints = {joint.get("name", ""): joint for joint in robot.iterfind("joint")}
    found = {name: _of_dynamics(joint) + _reflected(joint) for name, joint in joints.items()}
    for name, armature in _of_transmissions(robot):
        check_name("a transmission with a rotor: the joint", name, found)
        found[name] += armature
    return {
        name: armature
        for name, armature in found.items()
        if armature and joints[name].get("type") != "fixed"
    }


def _of_transmissions(robot: Element) -> Iterator[tuple[str, float]]:
    for transmission in robot.iterfind("transmission"):
        actuators, joints = transmission.findall("actuator"), transmission.findall("joint")
        armature = sum(map(_reflected, actuators))
        if not armature:
            continue
        if len(actuators) != 1 or len(joints) != 1:
            got = f"{label(transmission)} has rotors and {len(joints)} joints"
            raise ModelFileError(f"{got}; those of one actuator and one joint are read")
        yield joints[0].get("name", ""), armature


def _of_dynamics(joint: Element) -> float:
    return _rotor_inertia(f"{label(joint)}, <dynamics>", joint.find("dynamics"), "armature")


def _reflected(holder: Element) -> float:
    """Return the inertia of Drake's rotor as its joint feels it."""
    where = label(holder)
    rotor, gear = (only(where, holder, f"{{*}}{tag}") for tag in ("rotor_inertia", "gear_ratio"))
    (ratio,) = numbers(f"{where}, <drake:gear_ratio>", gear, "value", default="1")
    return _rotor_inertia(f"{where}, <drake:rotor_inertia>", rotor, "value") * ratio**2


def _rotor_inertia(where: str, element: Element | None, attribute: str) -> float:
    return numbers(where, element, attribute, default="0", least=0.0)[0]


def lost_rotors(armature: Mapping[str, float], kept: Collection[str]) -> list[str]:
    """Say which armatures no mass matrix has, since their joints are not among the kept ones."""
    lost = [name for name in armature if name not in kept]
    why = "its armature is lost, and no mass matrix has it; name it as a motor to keep it"
    return [f"joint {name!r} is cut: {why}" for name in lost]
