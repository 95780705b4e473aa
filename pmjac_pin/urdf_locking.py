"""Locking joints of a URDF: each becomes fixed where it is at a given value."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError, LimitError, unknown_name
from pmjac_pin.urdf import Urdf, parse_urdf
from pmjac_pin.urdf_xml import numbers, parse_xml, written

_AXIS = "1 0 0"  # URDF's, where a joint gives none


def lock_joints(urdf: Urdf, values: Mapping[str, float]) -> Urdf:
    """Return the URDF with these joints fixed at these values.

    Parameters
    ----------
    urdf : Urdf
    values : mapping of str to float
        Revolute, continuous or prismatic joints, and their values in rad or m.

    Raises
    ------
    UnknownNameError
        A joint that the URDF does not have.
    ArgumentError
        A joint that does not have one degree of freedom.
    LimitError
        A value outside the joint's limits.

    Examples
    --------
    >>> text = '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="continuous">'
    >>> text += '<parent link="a"/><child link="b"/></joint></robot>'
    >>> lock_joints(parse_urdf(text, "r.urdf"), {"j": 0.5}).joints[0].type
    'fixed'
    """
    if not values:
        return urdf
    robot = parse_xml(urdf.text)
    joints = {joint.get("name", ""): joint for joint in robot.iterfind("joint")}
    for name, value in values.items():
        if name not in joints:
            moving = tuple(joint.name for joint in urdf.joints if joint.type != "fixed")
            raise unknown_name("joint", name, moving)
        _lock(joints[name], value)
    return parse_urdf(tostring(robot, encoding="unicode"), urdf.path)


def _lock(joint: Element, value: float) -> None:
    name, kind = joint.get("name", ""), joint.get("type", "")
    if kind not in ("revolute", "continuous", "prismatic"):
        wanted = "revolute, continuous and prismatic joints can be locked"
        raise ArgumentError(f"joint {name!r} is {kind}; {wanted}")
    if kind != "continuous":
        lower, upper = (
            numbers(name, joint.find("limit"), end, default="0", largest=np.inf)[0]
            for end in ("lower", "upper")
        )
        if not lower <= value <= upper:
            message = (
                f"joint {name!r} cannot be locked at {value:g}, outside [{lower:g}, {upper:g}]"
            )
            raise LimitError(message, joint=name, value=value, lower=lower, upper=upper)
    _move(joint, value, kind)
    for tag in ("axis", "limit", "dynamics"):
        for element in joint.findall(tag):
            joint.remove(element)
    joint.set("type", "fixed")


def _move(joint: Element, value: float, kind: str) -> None:
    """Turn or shift a joint's origin by the joint's motion at this value."""
    origin, axis = joint.find("origin"), joint.find("axis")
    direction = np.array(numbers("axis", axis, "xyz", default=_AXIS, count=3))
    step = value * direction / np.linalg.norm(direction)
    xyz, rpy = (numbers("origin", origin, key, default="0 0 0", count=3) for key in ("xyz", "rpy"))
    at_zero = pin.SE3(pin.rpy.rpyToMatrix(np.array(rpy)), np.array(xyz))
    if kind == "prismatic":
        motion = pin.SE3(np.eye(3), step)
    else:
        motion = pin.SE3(pin.exp3(step), np.zeros(3))
    there = at_zero * motion
    if origin is None:
        origin = SubElement(joint, "origin")
    origin.set("xyz", written(there.translation))
    origin.set("rpy", written(pin.rpy.matrixToRpy(there.rotation)))
