"""SDFormat: links placed at home, and joints between them, those that close loops at the end."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.files.xml_text import written
from pmjac_pin.model.loop_between_frames import LoopAlongAxis, LoopBetweenFrames
from pmjac_pin.model.loop_spec import (
    FrameLoop,
    Loop,
    PointLoop,
    PrismaticLoop,
    RevoluteLoop,
    UniversalLoop,
)
from pmjac_pin.studies.export.closable import closable
from pmjac_pin.studies.export.from_home import FromHome, counted
from pmjac_pin.studies.export.gears import followers
from pmjac_pin.studies.export.masses import Masses
from pmjac_pin.studies.export.mesh_files import mesh_path
from pmjac_pin.studies.export.motors import refuse_planar_motors
from pmjac_pin.studies.export.names import renamed
from pmjac_pin.studies.export.plain_machine import (
    PlainBody,
    PlainJoint,
    PlainMachine,
    PlainShape,
    PlainStep,
    Written,
)
from pmjac_pin.studies.export.single_steps import with_single_steps
from pmjac_pin.values.arrays import Array

_VERSION = "1.11"  # the first with <mimic>
_DRAKE = "http://drake.mit.edu"  # whose word for an armature others pass over
#: The types of <joint> that close loops, by the kinds of loops that they are.
SDF_LOOPS: dict[type[Loop], str] = {
    PointLoop: "ball",
    FrameLoop: "fixed",
    RevoluteLoop: "revolute",
    PrismaticLoop: "prismatic",
    UniversalLoop: "universal",
}
_SDF_STEPS = {"hinge": "revolute", "slide": "prismatic", "ball": "ball"}


def sdf(machine: PlainMachine, folder: Path) -> Written:
    """Return a machine's <sdf>.

    Raises
    ------
    ArgumentError
        A body that moves any way and no loop holds; a planar motor; gears in which no order is.
    """
    refuse_planar_motors(machine, "sdf")
    _check_held(machine)
    machine, renames = _with_own_names(machine)
    machine, notes = closable(machine, tuple(SDF_LOOPS))
    machine = with_single_steps(machine, _stays_whole)
    writer = _SdfWriter(machine, folder)
    root = Element("sdf", {"version": _VERSION, "xmlns:drake": _DRAKE})
    root.append(writer.model())
    return Written(root, machine, (*renames, *notes, *writer.notes()))


def _check_held(machine: PlainMachine) -> None:
    """Refuse a body that moves any way: but for its loops, which are joints, it would be apart."""
    pairs = [
        tuple(machine.frames[name][0] for name in loop.frames)
        for loop in machine.loops
        if isinstance(loop, LoopBetweenFrames)
    ]
    pairs += [(joint.parent, joint.child) for joint in machine.joints if not _is_loose(joint)]
    held = {0}
    while more := {body for pair in pairs if held & set(pair) for body in pair} - held:
        held |= more
    for joint in machine.joints:
        if _is_loose(joint) and (joint.driven or joint.child not in held):
            what = f"sdf has no joint that moves any way, as {quoted(joint.name)} does"
            raise ArgumentError(f"{what}; mjcf or toml would do")


def _is_loose(joint: PlainJoint) -> bool:
    """Tell whether a joint holds nothing: it is left out."""
    return joint.kind == "free"


def _stays_whole(joint: PlainJoint) -> bool:
    return joint.kind == "helical" or _is_loose(joint)


def _with_own_names(machine: PlainMachine) -> tuple[PlainMachine, list[str]]:
    """Return the machine without names that are SDFormat's, or of a frame and a joint alike."""
    taken, moving = machine.taken, {joint.name for joint in machine.joints}
    moving |= {step.name for step in machine.steps}
    frames = {name: _of_ours(name, "link") for name in machine.frames}
    joints = {name: _of_ours(name, "joint") for name in sorted(moving)}
    # SDFormat has one space for all names of a model.
    joints |= {name: f"{name}_joint" for name in moving & set(machine.frames)}
    machine = replace(machine, name=_of_ours(machine.name, "model"))
    return renamed(machine, _changed(frames, taken), _changed(joints, taken))


def _changed(names: Mapping[str, str], taken: set[str]) -> dict[str, str]:
    """Return the names that are others, like none that is taken."""
    return {old: unused_name(new, taken) for old, new in names.items() if new != old}


def _of_ours(name: str, what: str) -> str:
    """Return a name that SDFormat does not keep for itself."""
    plain = name.replace("::", "_")
    return f"{plain}_{what}" if plain == "world" or re.fullmatch("__.*__", plain) else plain


class _SdfWriter:
    """Writes the model part by part; all links are placed in its frame, at home."""

    def __init__(self, machine: PlainMachine, folder: Path) -> None:
        self._machine, self._folder = machine, folder
        self._placed = machine.placements()
        self._masses, self._from_home = Masses(machine), FromHome(machine)
        self._taken = machine.taken

    def model(self) -> Element:
        """Return the <model>."""
        machine = self._machine
        model = Element("model", name=machine.name)
        for number, body in enumerate(machine.bodies):
            model.append(self._link(number, body))
        for body in machine.bodies:
            for name, place in body.frames.items():
                frame = SubElement(model, "frame", {"name": name, "attached_to": body.name})
                frame.append(_sdf_pose(place))
        base = machine.bodies[0].name
        held = self._joint(unused_name(f"{base}_to_world", self._taken), "fixed", "world", base)
        model.append(held)
        joints = {
            one.steps[0].name: self._moving(one) for one in machine.joints if not _is_loose(one)
        }
        model.extend(joints.values())
        for gear in followers(self._from_home.gears(), machine.motors, "sdf"):
            leader, follower = gear.joints
            for axis in joints[follower].findall("axis"):
                mimic = SubElement(axis, "mimic", joint=leader)
                SubElement(mimic, "multiplier").text = written([gear.ratio])
                SubElement(mimic, "offset").text = written([gear.offset])
        for loop in machine.loops:
            if isinstance(loop, LoopBetweenFrames):
                model.append(self._loop(loop))
        return model

    def notes(self) -> Iterator[str]:
        """Yield what is to be said of what was written."""
        yield from self._masses.notes()
        yield from self._from_home.notes()
        for step in self._machine.steps:
            if step.armature and not step.single:
                yield f"the armature of joint {step.name!r}, which turns any way, is left out"
        motors = ",".join(self._machine.motors)
        yield f"sdf does not say which joints are motors: read it with --actuated {motors}"

    def _link(self, number: int, body: PlainBody) -> Element:
        link = Element("link", name=body.name)
        link.append(_sdf_pose(self._placed[number]))
        if number:
            link.append(_sdf_inertial(self._masses.of(body)))
        for count, drawn in enumerate(body.shapes, start=1):
            link.append(self._visual(drawn, f"visual{count}"))
        return link

    def _visual(self, drawn: PlainShape, name: str) -> Element:
        visual = Element("visual", name=name)
        visual.append(_sdf_pose(drawn.place))
        shape = SubElement(SubElement(visual, "geometry"), drawn.shape.tag)
        for key, value in drawn.shape.attrib.items():
            mesh = key == "filename"
            SubElement(shape, "uri" if mesh else key).text = (
                mesh_path(drawn, self._folder) if mesh else value
            )
        if drawn.colour is not None:
            material = SubElement(visual, "material")
            for tag in ("ambient", "diffuse"):
                SubElement(material, tag).text = written(drawn.colour)
        return visual

    def _joint(self, name: str, kind: str, parent: str, child: str) -> Element:
        joint = Element("joint", {"name": name, "type": kind})
        SubElement(joint, "parent").text = parent
        SubElement(joint, "child").text = child
        return joint

    def _moving(self, joint: PlainJoint) -> Element:
        """Return a joint: of one step, or a screw."""
        parent, child = (self._machine.bodies[k].name for k in (joint.parent, joint.child))
        if joint.kind == "helical":
            screw = self._step(joint.steps[0], "screw", parent, child)
            SubElement(screw, "screw_thread_pitch").text = written([math.tau * joint.pitch])
            return screw
        (step,) = joint.steps
        return self._step(step, _SDF_STEPS[step.kind], parent, child)

    def _step(self, step: PlainStep, kind: str, parent: str, child: str) -> Element:
        if not step.single:
            return self._joint(step.name, kind, parent, child)
        limits = self._from_home.limits(step)
        free = not np.isfinite(limits).any() and step.name not in counted(self._machine)
        kind = "continuous" if kind == "revolute" and free else kind
        joint = self._joint(step.name, kind, parent, child)
        axis = _sdf_axis("axis", step.axis)
        known = {} if free else dict(zip(("lower", "upper"), limits, strict=True))
        most = {"effort": step.effort, "velocity": step.rate}
        known |= {tag: number for tag, number in most.items() if np.isfinite(number)}
        if known:
            limit = SubElement(axis, "limit")
            for tag, number in known.items():
                SubElement(limit, tag).text = written([number])
        joint.append(axis)
        if step.armature:
            SubElement(joint, "drake:rotor_inertia").text = written([step.armature])
        return joint

    def _loop(self, loop: LoopBetweenFrames) -> Element:
        """Return the joint of a loop, at its second frame."""
        (one, first), (other, second) = (self._machine.frames[name] for name in loop.frames)
        kind = next(tag for known, tag in SDF_LOOPS.items() if isinstance(loop, known))
        names = (self._machine.bodies[one].name, self._machine.bodies[other].name)
        label = unused_name("-".join(loop.frames), self._taken)
        joint = self._joint(label, kind, *names)
        joint.append(_sdf_pose(second))
        if isinstance(loop, LoopAlongAxis):
            joint.append(_sdf_axis("axis", np.array(loop.axis)))
        elif isinstance(loop, UniversalLoop):
            a, b = map(np.array, loop.axes)
            seen = (self._placed[other] * second).actInv(self._placed[one] * first)
            joint.append(_sdf_axis("axis", seen.rotation @ a))
            joint.append(_sdf_axis("axis2", b))
        return joint


def _sdf_axis(tag: str, direction: Array) -> Element:
    axis = Element(tag)
    SubElement(axis, "xyz").text = written(direction)
    return axis


def _sdf_pose(place: pin.SE3) -> Element:
    pose = Element("pose")
    pose.text = written([*place.translation, *pin.rpy.matrixToRpy(place.rotation)])
    return pose


def _sdf_inertial(inertia: pin.Inertia) -> Element:
    element = Element("inertial")
    element.append(_sdf_pose(pin.SE3(np.eye(3), inertia.lever)))
    SubElement(element, "mass").text = written([inertia.mass])
    moments = SubElement(element, "inertia")
    for k in range(3):
        for m in range(k, 3):
            number = inertia.inertia[k, m]
            SubElement(moments, f"i{'xyz'[k]}{'xyz'[m]}").text = written([number])
    return element
