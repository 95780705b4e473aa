"""Anchors: small links fixed to the links of a URDF, at which its loops hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.tree_urdf import origin
from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.files.xml_text import label, written
from pmjac_pin.model.loop_spec import LOOP_KINDS, Loop
from pmjac_pin.model.table import Vector

#: The loop that does what a kind of joint does, where it is not called as that.
_AS_LOOPS: Mapping[str, str] = {"continuous": "revolute", "fixed": "frame"}
_ALONG = ("revolute", "continuous", "prismatic", "cylindrical", "planar")
KINDS = (*_ALONG, "spherical", "fixed", "floating", "universal")


class Anchors:
    """Adds links to a robot, each with a name of its own.

    Parameters
    ----------
    robot : Element
        Changed in place.
    """

    def __init__(self, robot: Element) -> None:
        self._robot = robot
        self._links = {link.get("name", "") for link in robot.iterfind("link")}
        self._joints = {joint.get("name", "") for joint in robot.iterfind("joint")}

    def add(self, closing: str, link: str, placement: pin.SE3) -> str:
        """Return the name of a frame at this place on a link: the link's own, where it is that."""
        if placement.isIdentity(0.0):
            return link
        name = self._link(f"{closing}_on_{link}")
        self._weld(link, name, placement)
        return name

    def turn(self, joint: Element, placement: pin.SE3) -> None:
        """Hang a joint's parent on its child: T·M(q), with its axis turned, is M(q) and then T⁻¹.

        One degree of freedom keeps its value.
        """
        parent, child = joint.find("parent"), joint.find("child")
        if parent is None or child is None:
            raise ModelFileError(f"{label(joint)} has no parent or no child")
        below, above = parent.get("link", ""), child.get("link", "")
        for old in joint.findall("origin"):
            joint.remove(old)
        parent.set("link", above)
        child.set("link", below)
        if not placement.isIdentity(0.0):
            child.set("link", self._link(f"{joint.get('name')}_on_{below}"))
            self._weld(child.get("link", ""), below, placement.inverse())
        if joint.get("type") in ("revolute", "continuous", "prismatic"):
            axis = joint.find("axis")
            if axis is None:
                axis = SubElement(joint, "axis", xyz="1 0 0")
            axis.set("xyz", written(-float(x) for x in axis.get("xyz", "").split()))

    def _link(self, name: str) -> str:
        name = unused_name(name, self._links)
        SubElement(self._robot, "link", name=name)
        return name

    def _weld(self, parent: str, child: str, placement: pin.SE3) -> None:
        name = unused_name(f"{child}_fixed", self._joints)
        joint = SubElement(self._robot, "joint", name=name, type="fixed")
        SubElement(joint, "origin", origin(placement))
        SubElement(joint, "parent", link=parent)
        SubElement(joint, "child", link=child)


def placement_of(element: Element) -> pin.SE3:
    """Return the placement that a checked <origin> gives."""
    xyz, rpy = (np.array(element.get(key, "").split(), dtype=float) for key in ("xyz", "rpy"))
    return pin.SE3(pin.rpy.rpyToMatrix(rpy), xyz)


def loop_of_kind(kind: str, frames: tuple[str, str], axes: Sequence[Vector]) -> Loop:
    """Return the loop that does what a joint of one of `KINDS` does, but for a floating one.

    `axes` are the axis, or the two of a universal joint; others have none.
    """
    table: Any = LOOP_KINDS[_AS_LOOPS.get(kind, kind)]
    given = {"axis": axes[0]} if kind in _ALONG else {}
    loop: Loop = table(frames=frames, **({"axes": tuple(axes)} if kind == "universal" else given))
    return loop
