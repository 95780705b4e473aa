"""URDF+: a URDF whose loops are <loop> elements, its gears <mimic>, and that tells motors."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.files.xml_text import written
from pmjac_pin.model.loop_between_frames import LoopAlongAxis, LoopBetweenFrames
from pmjac_pin.model.loop_spec import (
    CylindricalLoop,
    FrameLoop,
    Loop,
    PlanarLoop,
    PointLoop,
    PrismaticLoop,
    RevoluteLoop,
    UniversalLoop,
)
from pmjac_pin.studies.export.closable import closable
from pmjac_pin.studies.export.from_home import FromHome
from pmjac_pin.studies.export.gears import followers
from pmjac_pin.studies.export.motors import refuse_planar_motors, refuse_turning_motors
from pmjac_pin.studies.export.plain_machine import PlainMachine, Written
from pmjac_pin.studies.export.urdf_tree import UrdfTree, prepared

#: The types of <loop> and <constraint>, by the kinds of loops that they are.
URDF_PLUS_LOOPS: dict[type[Loop], str] = {
    PointLoop: "spherical",
    FrameLoop: "fixed",
    RevoluteLoop: "revolute",
    PrismaticLoop: "prismatic",
    CylindricalLoop: "cylindrical",
    PlanarLoop: "planar",
    UniversalLoop: "universal",
}


def urdf_plus(machine: PlainMachine, folder: Path) -> Written:
    """Return a machine's <robot>.

    Raises
    ------
    ArgumentError
        A motor that turns any way, or in a plane; gears in which no order is.
    """
    refuse_planar_motors(machine, "urdf-plus")
    refuse_turning_motors(machine, "urdf-plus")
    machine, notes = closable(machine, tuple(URDF_PLUS_LOOPS))
    prepared_machine = prepared(machine)
    values = FromHome(prepared_machine)
    tree = UrdfTree(prepared_machine, folder, "spherical", values)
    robot = tree.urdf.robot
    with_mimics(tree, values, "urdf-plus")
    written = tree.joints
    for step in machine.steps:
        if step.single and step.name in written:  # those of a planar joint are not
            written[step.name].set("independent", "true" if step.driven else "false")
    robot.extend(_loop_elements(machine.loops))
    return Written(robot, machine, (*notes, *values.notes(), *tree.notes(), *_order(machine)))


def _order(machine: PlainMachine) -> Iterable[str]:
    """Yield what is to be said where the file has the motors in another order."""
    order = tuple(step.name for step in machine.steps if step.driven)
    if order != machine.motors:
        yield f"the motors are in the order of the file's joints: {', '.join(map(repr, order))}"


def with_mimics(tree: UrdfTree, values: FromHome, to: str) -> None:
    """Write a machine's gears as <mimic> of the joints that follow."""
    ordered = followers(values.gears(), tree.machine.motors, to)
    for gear in ordered:
        leader, follower = gear.joints
        numbers = {"multiplier": written([gear.ratio]), "offset": written([gear.offset])}
        SubElement(tree.joints[follower], "mimic", {"joint": leader, **numbers})


def _loop_elements(loops: Iterable[Loop]) -> Iterable[Element]:
    """Yield the elements; the frames of each loop are links."""
    names: set[str] = set()
    for loop in loops:
        if isinstance(loop, LoopBetweenFrames):
            yield _loop_element(loop, unused_name("-".join(loop.frames), names))


def _loop_element(loop: LoopBetweenFrames, name: str) -> Element:
    kind = next(tag for known, tag in URDF_PLUS_LOOPS.items() if isinstance(loop, known))
    if isinstance(loop, UniversalLoop):  # <loop> has one axis
        element = Element("constraint", name=name, type=kind)
        for end, link, axis in zip(("parent", "child"), loop.frames, loop.axes, strict=True):
            SubElement(element, end, link=link)
            SubElement(element, f"{end}_axis", xyz=written(axis))
        return element
    element = Element("loop", name=name, type=kind)
    for end, link in zip(("predecessor", "successor"), loop.frames, strict=True):
        SubElement(element, end, link=link)
    if isinstance(loop, LoopAlongAxis):
        SubElement(element, "axis", xyz=written(loop.axis))
    return element
