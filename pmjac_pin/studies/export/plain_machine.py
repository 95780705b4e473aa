"""A mechanism in the words that all formats share: bodies, steps of joints, frames, loops.

A joint moves by steps, one after the other: slides and hinges along and about axes of its frame,
a ball, or all at once. Formats that have no word for a joint write its steps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from pmjac_pin.files.shapes import Colour
from pmjac_pin.model.loop_spec import Loop
from pmjac_pin.values.arrays import Array

StepKind = Literal["hinge", "slide", "ball", "free"]


@dataclass(frozen=True, eq=False)
class PlainStep:
    """One of the motions of a joint.

    Attributes
    ----------
    name : str
        The joint's own where it has one step.
    kind : {"hinge", "slide", "ball", "free"}
    axis : ndarray, shape (3,)
        In the joint's frame, of length 1.
    limits : tuple of float
        Rad or m, infinite where there are none.
    armature : float
        kg m² or kg.
    effort : float
        What a motor can do both ways, N or N m; infinite where the model does not say.
    rate : float
        How fast, m/s or rad/s, as `effort`.
    driven : bool
        Whether it is a motor.
    """

    name: str
    kind: StepKind
    axis: Array
    limits: tuple[float, float] = (-np.inf, np.inf)
    armature: float = 0.0
    effort: float = np.inf
    rate: float = np.inf
    driven: bool = False

    @property
    def single(self) -> bool:
        """Whether it has one degree of freedom."""
        return self.kind in ("hinge", "slide")

    def seen_from(self, frame: pin.SE3) -> PlainStep:
        """Return the step with its axis in a frame that is turned against the joint's."""
        return replace(self, axis=frame.rotation.T @ self.axis)

    def motion(self, values: tuple[float, ...]) -> pin.SE3:
        """Return how far it moves at its values: a number, a quaternion, or a place and one."""
        match self.kind:
            case "hinge":
                return pin.SE3(pin.exp3(values[0] * self.axis), np.zeros(3))
            case "slide":
                return pin.SE3(np.eye(3), values[0] * self.axis)
            case "ball":
                return pin.XYZQUATToSE3(np.array([0.0, 0.0, 0.0, *values]))
            case "free":
                return pin.XYZQUATToSE3(np.array(values))


@dataclass(frozen=True, eq=False)
class PlainJoint:
    """A joint: the child's pose is the parent's · placement · its steps' motions.

    Attributes
    ----------
    name, kind : str
        The kind is one of `JOINT_KINDS`.
    parent, child : int
        Bodies.
    placement : pin.SE3
        Of the joint's frame in the parent.
    steps : tuple of PlainStep
    pitch : float
        Of a screw, m/rad.
    """

    name: str
    kind: str
    parent: int
    child: int
    placement: pin.SE3
    steps: tuple[PlainStep, ...]
    pitch: float = 0.0

    @property
    def driven(self) -> bool:
        """Whether it is a motor."""
        return any(step.driven for step in self.steps)


@dataclass(frozen=True, eq=False)
class PlainShape:
    """A shape on a body: a URDF's <geometry> child, its place there, and its colour."""

    shape: Element
    place: pin.SE3
    colour: Colour | None
    file: str  # the URDF that names it, from where a mesh's path counts


@dataclass(frozen=True, eq=False)
class PlainBody:
    """What moves as one: with its inertia about its own frame, its other frames and shapes."""

    name: str
    inertia: pin.Inertia
    frames: Mapping[str, pin.SE3]
    shapes: tuple[PlainShape, ...] = ()


@dataclass(frozen=True, eq=False)
class PlainMachine:
    """A mechanism to be written.

    Attributes
    ----------
    name : str
    bodies : tuple of PlainBody
        The world first, parents before their children.
    joints : tuple of PlainJoint
        One to each body but the world, in their order.
    loops : tuple of Loop
        Without parameters; their frames are the bodies' names and those in `PlainBody.frames`.
    poses : mapping of str to mapping of str to tuple of float
        Closed, "home" among them: values by the steps' names.
    motors : tuple of str
        The steps that are driven, in the order of the columns of J_eq.
    tool : tuple of str
        A frame, or the three that span it; none.
    gravity : ndarray, shape (3,)
    length : float
        The characteristic one, m.
    """

    name: str
    bodies: tuple[PlainBody, ...]
    joints: tuple[PlainJoint, ...]
    loops: tuple[Loop, ...]
    poses: Mapping[str, Mapping[str, tuple[float, ...]]]
    motors: tuple[str, ...]
    tool: tuple[str, ...]
    gravity: Array
    length: float

    @property
    def steps(self) -> tuple[PlainStep, ...]:
        """All steps, joint by joint."""
        return tuple(step for joint in self.joints for step in joint.steps)

    def step(self, name: str) -> PlainStep:
        """Return a step by its name."""
        return next(step for step in self.steps if step.name == name)

    @property
    def frames(self) -> Mapping[str, tuple[int, pin.SE3]]:
        """The body that carries each frame, and the frame's place there."""
        own = {body.name: (k, pin.SE3.Identity()) for k, body in enumerate(self.bodies)}
        others = {
            name: (k, place)
            for k, body in enumerate(self.bodies)
            for name, place in body.frames.items()
        }
        return own | others

    @property
    def taken(self) -> set[str]:
        """All names of bodies, frames, joints and steps."""
        joints = {joint.name for joint in self.joints}
        return {*self.frames, *joints, *(step.name for step in self.steps)}

    def placements(self, pose: str | None = "home") -> tuple[pin.SE3, ...]:
        """Return where each body is in a pose; with all joints at zero where that is None."""
        values = {} if pose is None else self.poses[pose]
        placed = [pin.SE3.Identity()]
        for joint in self.joints:
            place = placed[joint.parent] * joint.placement
            for step in joint.steps:
                if step.name in values:
                    place = place * step.motion(values[step.name])
            placed.append(place)
        return tuple(placed)

    def with_frame(self, name: str, body: int, place: pin.SE3) -> PlainMachine:
        """Return the machine with a frame more on a body."""
        carrier = self.bodies[body]
        changed = replace(carrier, frames={**carrier.frames, name: place})
        return replace(self, bodies=(*self.bodies[:body], changed, *self.bodies[body + 1 :]))


@dataclass(frozen=True, eq=False)
class Written:
    """What became of a machine in a format.

    Attributes
    ----------
    root : Element
    machine : PlainMachine
        With the names that frames and motors have in the file.
    notes : tuple of str
    beside : str
        Of the file that belongs to it.
    """

    root: Element
    machine: PlainMachine
    notes: tuple[str, ...]
    beside: str = ""
