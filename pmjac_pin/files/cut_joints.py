"""Cutting the joints of a URDF: a tree of them stays, and the others become loops."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from xml.etree.ElementTree import Element

import pinocchio as pin

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.anchors import Anchors, loop_of_kind, placement_of
from pmjac_pin.files.spanning_tree import SpanningTree, spanning_tree
from pmjac_pin.files.urdf.checks import checked_joint
from pmjac_pin.files.urdf.joint_tree import UrdfJoint, joints_of
from pmjac_pin.model.loop_between_frames import X
from pmjac_pin.model.loop_spec import Loop


@dataclass(frozen=True)
class CutJoints:
    """The joints of a URDF, and which of them are cut.

    Attributes
    ----------
    elements : sequence of Element
        As the file has them.
    checked : Element
        Their checked copies, in the same order.
    balls : collection of str
        Names of those that are balls and written as floating.
    tree : SpanningTree
        Of their numbers in this order.
    """

    elements: Sequence[Element]
    checked: Element
    balls: Collection[str]
    tree: SpanningTree

    @classmethod
    def of(
        cls,
        elements: Sequence[Element],
        links: Collection[str],
        balls: Collection[str],
        whole: Collection[str],
    ) -> CutJoints:
        """Check joints between these links and choose which to cut: none of the `whole` ones.

        Raises
        ------
        ModelFileError
            A joint is not to be understood, or none but a `whole` one could be cut.
        """
        checked = Element("robot")
        checked.extend([checked_joint(element, links) for element in elements])
        tree = _tree_of_links(list(links), joints_of(checked), whole)
        return cls(elements, checked, balls, tree)

    @cached_property
    def joints(self) -> tuple[UrdfJoint, ...]:
        """All joints."""
        return joints_of(self.checked)

    @cached_property
    def kept(self) -> list[UrdfJoint]:
        """The joints of the tree."""
        return [joint for number, joint in enumerate(self.joints) if number not in self.tree.cut]

    def placements(self) -> dict[str, pin.SE3]:
        """Return where the links are in the base with all joints at zero, the base first."""
        found = {self.tree.root: pin.SE3.Identity()}
        for branch in self.tree.branches:
            place = _joint_origin(self.checked[branch.joint])
            step = place.inverse() if branch.turned else place
            found[branch.below] = found[branch.above] * step
        return found

    def remove_from(self, robot: Element) -> None:
        """Take the joints that are cut out of a robot."""
        for number in self.tree.cut:
            robot.remove(self.elements[number])

    def turn(self, anchors: Anchors) -> None:
        """Turn round the joints that lead towards the root."""
        for branch in self.tree.branches:
            if branch.turned:
                anchors.turn(self.elements[branch.joint], _joint_origin(self.checked[branch.joint]))

    def loops(self, anchors: Anchors) -> list[Loop | None]:
        """Return the loops that do what the cut joints did; None for one that held nothing."""
        joints = self.joints
        return [self._loop(joints[cut], self.checked[cut], anchors) for cut in self.tree.cut]

    def _loop(self, joint: UrdfJoint, element: Element, anchors: Anchors) -> Loop | None:
        kind = self._kind(joint)
        if kind == "floating":
            return None
        axis = element.find("axis")
        x, y, z = X if axis is None else map(float, axis.get("xyz", "").split())
        frames = (anchors.add(joint.name, joint.parent, _joint_origin(element)), joint.child)
        return loop_of_kind(kind, frames, [(x, y, z)])

    def _kind(self, joint: UrdfJoint) -> str:
        return "spherical" if joint.name in self.balls else joint.type

    def notes(self) -> list[str]:
        """Say which joints were turned round, and which were cut for what."""
        joints = self.joints
        above = {branch.below: joints[branch.joint].name for branch in self.tree.branches}
        notes = [
            f"joint {joints[branch.joint].name!r} is turned round, as none leads to "
            f"{branch.below!r}"
            for branch in self.tree.branches
            if branch.turned
        ]
        for joint in (joints[number] for number in self.tree.cut):
            kind = self._kind(joint)
            done = "holds nothing: left out" if kind == "floating" else f"cut, and closed as {kind}"
            other = above.get(joint.child)
            why = "which is the base" if other is None else f"which {other!r} holds"
            notes.append(f"joint {joint.name!r} leads to link {joint.child!r}, {why}: {done}")
        return notes


def _tree_of_links(
    links: Sequence[str], joints: Sequence[UrdfJoint], kept: Collection[str]
) -> SpanningTree:
    for joint in joints:
        if joint.parent == joint.child:
            message = f"joint {joint.name!r} joins link {joint.parent!r} with itself"
            raise ModelFileError(message)
    ends = [(joint.parent, joint.child) for joint in joints]
    first = [number for number, joint in enumerate(joints) if joint.name in kept]
    tree = spanning_tree(links, ends, first=first)
    for joint in (joints[number] for number in tree.cut if number in first):
        got = f"joint {joint.name!r} is a motor or geared by <mimic>, and would have to be cut"
        why = f"another such joint holds link {joint.child!r}, or it is the base"
        raise ModelFileError(f"{got}, since {why}")
    return tree


def _joint_origin(joint: Element) -> pin.SE3:
    origin = joint.find("origin")
    return pin.SE3.Identity() if origin is None else placement_of(origin)
