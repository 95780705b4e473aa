"""Which joints of an MJCF model are motors: those that <actuator> moves."""

from __future__ import annotations

from collections.abc import Container, Mapping
from xml.etree.ElementTree import Element

from pmjac_pin.formats.mjcf_joints import SCALAR, MjcfJoint
from pmjac_pin.formats.mjcf_names import find_name
from pmjac_pin.urdf_xml import shown

_BRAKES = ("adhesion", "damper")


def read_motors(
    root: Element, joints: Mapping[str, MjcfJoint], held: Container[str]
) -> tuple[tuple[str, ...], list[str]]:
    """Return the joints that actuators move, each once, in file order, and notes on the others.

    Raises
    ------
    ModelFileError
        A joint that does not exist.
    """
    motors: dict[str, None] = {}
    notes = []
    known = {name: name for name in joints}
    for element in root.iterfind("actuator/*"):
        where = f"actuator {shown(element.get('name', element.tag))}"
        given = element.get("joint") or element.get("jointinparent")
        if given is None or element.tag in _BRAKES:
            what = "is a brake" if element.tag in _BRAKES else "moves no joint by itself"
            notes.append(f"{where} {what}, and is left out")
            continue
        name = find_name(f"{where}: the joint", given, known)
        if joints[name].kind not in SCALAR:
            notes.append(f"{where} moves {joints[name].kind} joint {name!r}, and is left out")
        elif name in held:
            notes.append(f"{where} moves joint {name!r}, which is held, and is left out")
        else:
            motors[name] = None
    return tuple(motors), notes
