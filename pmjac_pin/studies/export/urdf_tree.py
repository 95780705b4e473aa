"""The tree of a machine as a URDF, whose links stand where they are with all joints at zero.

URDF has no home pose. So where none stands beside it, values count from home: each joint's frame
is where home has it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from pmjac_pin.files.joint_dialects import WITHOUT_LIMIT
from pmjac_pin.files.tree_urdf import STILL, MovingAxis, TreeUrdf
from pmjac_pin.files.xml_text import written
from pmjac_pin.studies.export.from_home import FromHome, FromZero, counted
from pmjac_pin.studies.export.mesh_files import mesh_path
from pmjac_pin.studies.export.plain_machine import PlainJoint, PlainMachine, PlainShape, PlainStep
from pmjac_pin.studies.export.single_steps import with_screws_geared, with_single_steps

_STEP_TYPES: Mapping[str, str] = {"hinge": "revolute", "slide": "prismatic", "free": "floating"}


@dataclass
class UrdfTree:
    """Writes the tree.

    Attributes
    ----------
    machine : PlainMachine
        Of `prepared`; of a screw that nothing gears only the turn is written.
    folder : Path
        Where the file will be.
    ball : str
        What the format calls a ball joint.
    values : FromHome or FromZero
        From where values count.
    urdf : TreeUrdf
    """

    machine: PlainMachine
    folder: Path
    ball: str
    values: FromHome | FromZero
    urdf: TreeUrdf = field(init=False)

    def __post_init__(self) -> None:
        machine, placed = self.machine, self.machine.placements(self.values.pose)
        geared = counted(machine)
        self.urdf = TreeUrdf(machine.name, machine.bodies[0].name, placed[0], machine.taken)
        for joint in machine.joints:
            self._move(joint, placed, geared)
        for number, body in enumerate(machine.bodies):
            for name, place in body.frames.items():
                self.urdf.fixed(body.name, name, placed[number] * place)
            if number and (body.inertia.mass or body.inertia.inertia.any()):
                self.urdf.inertial(body.name, body.inertia)
            for drawn in body.shapes:
                colour = None if drawn.colour is None else written(drawn.colour)
                self.urdf.visual(
                    body.name, placed[number] * drawn.place, self._shape(drawn), colour
                )

    def notes(self) -> Iterator[str]:
        """Yield what a URDF cannot say of joints."""
        for joint in self.machine.joints:
            if joint.kind == "planar" and any(step.armature for step in joint.steps):
                yield f"the armature of planar joint {joint.name!r} is left out"

    @property
    def joints(self) -> Mapping[str, Element]:
        """The joints that were written, by name."""
        return {joint.get("name", ""): joint for joint in self.urdf.robot.iterfind("joint")}

    def _move(
        self, joint: PlainJoint, placed: tuple[pin.SE3, ...], geared: Collection[str]
    ) -> None:
        """Write a planar joint, or another's first step."""
        above, below = (self.machine.bodies[k].name for k in (joint.parent, joint.child))
        self.urdf.link(below, placed[joint.child])
        if joint.kind == "planar":
            self.urdf.joint(joint.name, "planar", (above, below), MovingAxis((0.0, 0.0, 1.0)))
            return
        step = joint.steps[0]
        self._step(step, (above, below), step.name in geared or joint.kind == "helical")

    def _step(self, step: PlainStep, ends: tuple[str, str], counted: bool) -> None:
        kind, moves = _STEP_TYPES.get(step.kind, self.ball), STILL
        if step.single:
            lower, upper = self.values.limits(step)
            if step.kind == "hinge" and not counted and not np.isfinite([lower, upper]).any():
                kind, moves = "continuous", MovingAxis(step.axis)
            else:
                limits = (max(lower, -WITHOUT_LIMIT), min(upper, WITHOUT_LIMIT))
                moves = MovingAxis(step.axis, limits)
        self.urdf.joint(step.name, kind, ends, moves)
        self._motor(step)

    def _motor(self, step: PlainStep) -> None:
        """Write what a motor can do, and its rotor."""
        joint = self.joints[step.name]
        most = {"effort": step.effort, "velocity": step.rate}
        if step.single and np.isfinite([*most.values()]).any():
            if (limit := joint.find("limit")) is None:
                limit = SubElement(joint, "limit")
            for key, number in most.items():
                limit.set(key, written([min(number, WITHOUT_LIMIT)]))
        if step.armature:
            joint.append(Element("dynamics", armature=written([step.armature])))

    def _shape(self, drawn: PlainShape) -> Element:
        """Return a shape; a mesh that is there by its path from the new file."""
        shape = Element(drawn.shape.tag, drawn.shape.attrib)
        if shape.tag == "mesh":
            shape.set("filename", mesh_path(drawn, self.folder))
        return shape


def urdf_name(joint: PlainJoint) -> str:
    """Return the name that a URDF has for a joint: a planar one is no single step."""
    return joint.name if joint.kind == "planar" else joint.steps[0].name


def motor_joints(machine: PlainMachine) -> tuple[str, ...]:
    """Return the motors by the names of the URDF's joints."""
    joints = {step.name: urdf_name(joint) for joint in machine.joints for step in joint.steps}
    return tuple(dict.fromkeys(joints[name] for name in machine.motors))


def prepared(machine: PlainMachine) -> PlainMachine:
    """Return a machine whose joints a URDF has: of one step, or planar."""
    geared = with_screws_geared(machine)
    return with_single_steps(geared, lambda joint: joint.kind == "planar")
