"""MJCF, for MuJoCo: bodies with their joints and sites, equalities, motors, closed keyframes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from pmjac_pin.files.xml_text import written
from pmjac_pin.studies.export.closable import closable
from pmjac_pin.studies.export.masses import Masses
from pmjac_pin.studies.export.mjcf_loops import MJCF_LOOPS, closed_by_equalities
from pmjac_pin.studies.export.mjcf_shapes import Shapes, place_attributes
from pmjac_pin.studies.export.motors import refuse_planar_motors
from pmjac_pin.studies.export.names import with_root
from pmjac_pin.studies.export.plain_machine import PlainJoint, PlainMachine, PlainStep, Written
from pmjac_pin.studies.export.single_steps import with_screws_geared
from pmjac_pin.values.checks import LARGEST

_MOTORS_OF = {"ball": 3, "free": 6}


def mjcf(machine: PlainMachine, folder: Path) -> Written:
    """Return a machine's <mujoco>.

    Parameters
    ----------
    machine : PlainMachine
    folder : Path
        Where the file will be.

    Raises
    ------
    ArgumentError
        A planar motor.
    """
    refuse_planar_motors(machine, "mjcf")
    machine, renamed = with_root(with_screws_geared(machine), "world")
    machine, notes = closable(machine, MJCF_LOOPS)
    machine, equality, tendons = closed_by_equalities(machine)
    writer = _MjcfWriter(machine, folder)
    root = Element("mujoco", model=machine.name)
    SubElement(root, "compiler", angle="radian", autolimits="true")
    SubElement(root, "option", gravity=written(machine.gravity))
    parts = (writer.shapes.assets, writer.worldbody(), tendons, equality, writer.actuators())
    root.extend([part for part in parts if len(part)])
    root.append(writer.keyframe())
    return Written(root, machine, (*renamed, *notes, *writer.notes()))


class _MjcfWriter:
    """Writes bodies, depth first, and remembers the order of their joints."""

    def __init__(self, machine: PlainMachine, folder: Path) -> None:
        self.shapes = Shapes(folder)
        self._machine, self._masses = machine, Masses(machine)
        self._written: list[tuple[PlainJoint, PlainStep]] = []

    def worldbody(self) -> Element:
        """Return all bodies."""
        world = Element("worldbody")
        self._fill(world, 0)
        return world

    def actuators(self) -> Element:
        """Return a motor for each freedom that is driven: its control is a force or a torque."""
        actuator = Element("actuator")
        for step in map(self._machine.step, self._machine.motors):
            for gear in _gear_rows(step):
                limit = {}
                if np.isfinite(step.effort):
                    limit["ctrlrange"] = written([-step.effort, step.effort])
                name = {"name": step.name if step.single else f"{step.name}.{len(actuator)}"}
                SubElement(actuator, "motor", {**name, "joint": step.name, **gear, **limit})
        return actuator

    def keyframe(self) -> Element:
        """Return a key for each pose: qpos in the order in which the joints were written."""
        keyframe = Element("keyframe")
        for pose, values in self._machine.poses.items():
            numbers = [
                number
                for joint, step in self._written
                for number in _qpos(joint, step, values[step.name])
            ]
            SubElement(keyframe, "key", name=pose, qpos=written(numbers))
        return keyframe

    def notes(self) -> Iterator[str]:
        """Yield what is to be said of what was written."""
        yield from self._masses.notes()
        yield from self.shapes.notes()
        if any(np.isfinite(step.rate) for step in self._machine.steps if step.driven):
            yield "mjcf has no limits of rates: those of the motors are left out"
        for joint in self._machine.joints:
            if joint.kind == "free" and joint.driven:
                count = sum(_MOTORS_OF.get(step.kind, 1) for step in joint.steps)
                what = f"{joint.name!r}, which moves any way, is a motor of the model"
                yield f"{what}: {count} actuators move it; remove them where nothing drives it"

    def _fill(self, element: Element, number: int) -> None:
        """Write what a body carries: its mass, joints, shapes and sites, and the bodies on it."""
        body = self._machine.bodies[number]
        for drawn in body.shapes:
            element.extend(self.shapes.geoms(drawn))
        for name, place in body.frames.items():
            SubElement(element, "site", {"name": name, **place_attributes(place)})
        for joint in self._machine.joints:
            if joint.parent == number:
                self._fill(self._body(element, joint), joint.child)

    def _body(self, element: Element, joint: PlainJoint) -> Element:
        body = self._machine.bodies[joint.child]
        child = SubElement(
            element, "body", {"name": body.name, **place_attributes(joint.placement)}
        )
        child.append(_mjcf_inertial(self._masses.of(body)))
        for step in joint.steps:
            self._written.append((joint, step))
            child.append(_mjcf_joint(step))
        return child


def _mjcf_inertial(inertia: pin.Inertia) -> Element:
    """Return an <inertial> about the axes of its moments, which MuJoCo would look for otherwise."""
    moments, axes = np.linalg.eigh(inertia.inertia)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    place = place_attributes(pin.SE3(axes, inertia.lever))
    numbers = {"mass": written([inertia.mass]), "diaginertia": written(moments)}
    return Element("inertial", {**numbers, **place})


def _mjcf_joint(step: PlainStep) -> Element:
    given = {"name": step.name, "type": step.kind}
    if step.single:
        given["axis"] = written(step.axis)
        if np.isfinite(step.limits).any():
            # MuJoCo wants both ends where there is one.
            given["range"] = written(np.clip(step.limits, -LARGEST, LARGEST))
    if step.armature:
        given["armature"] = written([step.armature])
    return Element("joint", given)


def _gear_rows(step: PlainStep) -> list[dict[str, str]]:
    """Return what each motor of a step moves: of one with several freedoms, one each."""
    if step.single:
        return [{}]
    return [{"gear": written(row)} for row in np.eye(6)[: _MOTORS_OF[step.kind]]]


def _qpos(joint: PlainJoint, step: PlainStep, values: tuple[float, ...]) -> tuple[float, ...]:
    """Return MuJoCo's numbers: w before x, y, z, and of a free body its pose in the world."""
    if step.single:
        return values
    if step.kind == "free":
        values = tuple(pin.SE3ToXYZQUAT(joint.placement * step.motion(values)).tolist())
    *place, x, y, z, w = values
    return (*place, w, x, y, z)
