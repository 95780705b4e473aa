"""ToolChain: virtual joints from the world to where a tool is to be, the first of them motors.

    tool = base · slide(d) · turn · end

At home d is 0 and the turn none. What a task leaves free slides and turns along as passive joints;
what the machine never does has no joint at all.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal, TypeAlias, assert_never

import numpy as np
import pinocchio as pin

from pmjac_pin.model.linkage import turned_to
from pmjac_pin.model.rows import across
from pmjac_pin.model.tool_spec import Tool
from pmjac_pin.studies.reach.gimbal import Gimbal
from pmjac_pin.studies.reach.task import plane_axes
from pmjac_pin.values.arrays import Array

#: How what is led turns: as a task says, about one axis only, not at all, or with nobody leading.
ChainTurning: TypeAlias = Literal[
    "free", "heading", "pointing", "orientation", "hinge", "none", "swivel"
]


@dataclass(frozen=True, slots=True, eq=False)
class ChainJoint:
    """A virtual joint.

    Attributes
    ----------
    name : str
    joint : pin.JointModel
    entries : callable
        (d (3,), Q (3, 3)) ↦ its entries in q, where the tool has slid and turned so since home, in
        the axes of the base.
    driven : bool
        Whether it is a motor: what the task tells.
    place : pin.SE3
        In the joint before.
    """

    name: str
    joint: pin.JointModel
    entries: Callable[[Array, Array], Array]
    driven: bool = True
    place: pin.SE3 = field(default_factory=pin.SE3.Identity)


@dataclass(frozen=True, slots=True, eq=False)
class ToolChain:
    """What may be commanded of a tool, as a chain of joints.

    Attributes
    ----------
    tool : Tool
    home : pin.SE3
        The tool's pose at home, in the world.
    axes : ndarray, shape (3, 3)
        Columns: the axes along which it slides, those that are commanded first.
    slides : int
        How many are commanded.
    floats : bool
        Whether it slides along the others as it likes; elsewhere, never.
    turning : {"free", "heading", "pointing", "orientation", "hinge", "none", "swivel"}
        What of its turn is commanded; with "hinge" all of it, about one axis, with "none" it never
        turns; with "swivel" it turns as it likes; "free" is left open by the loop at its end.
    axis : ndarray, shape (3,)
        Of a heading or a hinge, in the world, or of the tool, for pointing.
    singly : bool
        Whether it slides along one axis after the other, as proofs and homotopies want their
        motors.
    gimbal : Gimbal, optional
        Turns any way by three hinges in turn, these, not by a ball: they lock where two of their
        axes meet.
    """

    tool: Tool
    home: pin.SE3
    axes: Array
    slides: int
    floats: bool
    turning: ChainTurning
    axis: Array
    singly: bool = False
    gimbal: Gimbal | None = None

    @property
    def name(self) -> str:
        """That of the tool."""
        return "-".join(self.tool.names)

    @property
    def base(self) -> pin.SE3:
        """Where the chain begins."""
        return pin.SE3(self.axes, self.home.translation)

    @property
    def end(self) -> pin.SE3:
        """The tool in the last joint."""
        if self.turning == "heading":
            return pin.SE3.Identity()
        if self.gimbal is not None and self.turning == "orientation":
            return pin.SE3(self.gimbal.after.T, np.zeros(3)) * self._turned_at_home
        return self._about.inverse() * self._turned_at_home

    @property
    def _turned_at_home(self) -> pin.SE3:
        return pin.SE3(self.axes.T @ self.home.rotation, np.zeros(3))

    @property
    def _about(self) -> pin.SE3:
        """What takes z to the axis of the last joint, where that is a hinge."""
        if self.turning == "pointing":
            return turned_to(self._turned_at_home.rotation @ self.axis)
        return turned_to(self.axes.T @ self.axis) if self.turning == "hinge" else pin.SE3.Identity()

    def moved(self, pose: pin.SE3) -> tuple[Array, Array]:
        """Return how the tool has slid (3,) and turned (3, 3) since home, in the base's axes."""
        slid = self.axes.T @ (pose.translation - self.home.translation)
        turned = self.axes.T @ pose.rotation @ self.home.rotation.T @ self.axes
        return slid, turned

    @property
    def joints(self) -> tuple[ChainJoint, ...]:
        """The virtual joints, the first one's place being in the world."""
        chain = [*self._sliding(), *self._turning()]
        return tuple(
            one if k else replace(one, place=self.base * one.place) for k, one in enumerate(chain)
        )

    def _sliding(self) -> Iterator[ChainJoint]:
        if not self.singly and (self.slides == 3 or (self.floats and not self.slides)):
            name, anywhere = f"{self.name} position", pin.JointModelTranslation()
            yield ChainJoint(name, anywhere, lambda slid, _: slid, self.slides > 0)
            return
        kinds = (pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ)
        for k, kind in enumerate(kinds[: 3 if self.floats else self.slides]):
            yield ChainJoint(f"{self.name} slide {k + 1}", kind(), _part(k), k < self.slides)

    def _turning(self) -> Iterator[ChainJoint]:
        name, hinge = self.name, pin.JointModelRUBZ()
        match self.turning:
            case "free" | "none":
                return
            case "orientation" | "pointing" | "swivel":
                yield from self._ball(self.turning != "swivel")
                if self.turning == "pointing":
                    yield ChainJoint(f"{name} spin", hinge, _no_turn, False, self._about)
            case "hinge":
                turn = partial(_turn, self.axes.T @ self.axis)
                yield ChainJoint(f"{name} angle", hinge, turn, place=self._about)
            case "heading":
                yield from self._heading()
            case _:
                assert_never(self.turning)

    def _ball(self, driven: bool) -> Iterator[ChainJoint]:
        if (gimbal := self.gimbal) is not None:
            yield from self._in_turn(gimbal.before, gimbal.after, 3 * driven)
            return
        ball = pin.JointModelSpherical()
        yield ChainJoint(f"{self.name} orientation", ball, _quaternion, driven)

    def _heading(self) -> Iterator[ChainJoint]:
        """Yield turns about the axis, then about y and x: of these the first is the heading."""
        level = self.axes.T @ plane_axes(self.axis)
        return self._in_turn(level, self.axes.T @ self.home.rotation, 1)

    def _in_turn(self, before: Array, after: Array, driven: int) -> Iterator[ChainJoint]:
        """Yield turns about z, y and x, the first so many driven, between what is turned before."""
        kinds = (pin.JointModelRUBZ, pin.JointModelRUBY, pin.JointModelRUBX)
        for k, (kind, what) in enumerate(zip(kinds, ("yaw", "pitch", "roll"), strict=True)):

            def entries(_: Array, turned: Array, k: int = k) -> Array:
                angle = pin.rpy.matrixToRpy(before.T @ turned @ after)[2 - k]
                return np.array([np.cos(angle), np.sin(angle)])

            place = pin.SE3(np.eye(3) if k else before, np.zeros(3))
            yield ChainJoint(f"{self.name} {what}", kind(), entries, k < driven, place)


def _part(k: int) -> Callable[[Array, Array], Array]:
    return lambda slid, _: slid[k : k + 1]


def _quaternion(_: Array, turned: Array) -> Array:
    return np.asarray(pin.Quaternion(turned).coeffs())


def _no_turn(_: Array, turned: Array) -> Array:
    return np.array([1.0, 0.0])


def _turn(axis: Array, _: Array, turned: Array) -> Array:
    """Return cosine and sine of the angle by which a rotation turns about an axis."""
    side = across(axis)[0]
    x, y = side @ turned @ side, np.cross(axis, side) @ turned @ side
    return np.asarray(np.array([x, y]) / np.hypot(x, y))
