"""Locking joints of a URDF: each becomes fixed where it is at a given value."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError, LimitError, unknown_name
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.files.xml_text import numbers, written
from pmjac_pin.model.spec import JointValue

_OF_UNIT_LENGTH = 1e-6
_AXIS = "1 0 0"  # URDF's, where a joint gives none
_NO_PITCHES: Mapping[str, float] = MappingProxyType({})


def lock_joints(
    urdf: Urdf, values: Mapping[str, JointValue], pitches: Mapping[str, float] = _NO_PITCHES
) -> Urdf:
    """Return the URDF with these joints fixed at these values.

    Parameters
    ----------
    urdf : Urdf
    values : mapping of str to float or floats
        Revolute, continuous or prismatic joints, and their values in rad or m. Floating joints,
        and their translation in m with a rotation vector (6 numbers) or a quaternion xyzw (7);
        0 for their origin.
    pitches : mapping of str to float, optional
        How far joints that turn slide as well, m/rad.

    Raises
    ------
    UnknownNameError
        A joint that the URDF does not have.
    ArgumentError
        A planar joint, or values that do not fit the joint.
    LimitError
        A value outside the joint's limits.

    Examples
    --------
    >>> text = '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="continuous">'
    >>> text += '<parent link="a"/><child link="b"/></joint></robot>'
    >>> from pmjac_pin.files.urdf.robot import parse_urdf
    >>> lock_joints(parse_urdf(text, "r.urdf"), {"j": 0.5}).joints[0].type
    'fixed'
    """
    if not values:
        return urdf
    robot = urdf.robot()
    joints = {joint.get("name", ""): joint for joint in robot.iterfind("joint")}
    for name, value in values.items():
        if name not in joints:
            moving = tuple(joint.name for joint in urdf.joints if joint.type != "fixed")
            raise unknown_name("joint", name, moving)
        _lock_joint(joints[name], value, pitches.get(name, 0.0))
    return urdf.changed(robot, values.keys())


def _lock_joint(joint: Element, value: JointValue, pitch: float) -> None:
    name, kind = joint.get("name", ""), joint.get("type", "")
    if kind == "floating":
        _shift_origin(joint, _floating_placement(name, value))
    elif kind not in ("revolute", "continuous", "prismatic"):
        wanted = "revolute, continuous, prismatic and floating joints can be locked"
        raise ArgumentError(f"joint {name!r} is {kind}; {wanted}")
    elif not isinstance(value, float | int):
        raise ArgumentError(f"joint {name!r} is locked at one number, got {len(value)}")
    else:
        _check_limits(joint, value)
        _shift_origin(joint, _motion_at(joint, value, pitch))
    for tag in ("axis", "limit", "dynamics"):
        for element in joint.findall(tag):
            joint.remove(element)
    joint.set("type", "fixed")


def _check_limits(joint: Element, value: float) -> None:
    if joint.get("type") == "continuous":
        return
    name = joint.get("name", "")
    lower, upper = (
        numbers(name, joint.find("limit"), end, default="0", largest=np.inf)[0]
        for end in ("lower", "upper")
    )
    if not lower <= value <= upper:
        message = f"joint {name!r} cannot be locked at {value:g}, outside [{lower:g}, {upper:g}]"
        unit = "m" if joint.get("type") == "prismatic" else "rad"
        raise LimitError(message, joint=name, value=value, lower=lower, upper=upper, unit=unit)


def _motion_at(joint: Element, value: float, pitch: float) -> pin.SE3:
    """Return the motion of a joint of one degree of freedom at this value."""
    direction = np.array(numbers("axis", joint.find("axis"), "xyz", default=_AXIS, count=3))
    step = value * direction / np.linalg.norm(direction)
    if joint.get("type") == "prismatic":
        return pin.SE3(np.eye(3), step)
    return pin.SE3(pin.exp3(step), pitch * step)


def _floating_placement(name: str, value: JointValue) -> pin.SE3:
    """Return where a floating joint is at its values, as a pose gives them."""
    values = np.atleast_1d(np.array(value, dtype=float))
    if values.shape == (1,) and values[0] == 0.0:
        return pin.SE3.Identity()
    if values.shape not in ((6,), (7,)):
        raise ArgumentError(f"joint {name!r} is floating; it is locked at 6 or 7 numbers, or at 0")
    if values.size == 6:
        return pin.SE3(pin.exp3(values[3:]), values[:3])
    if abs(np.linalg.norm(values[3:]) - 1.0) > _OF_UNIT_LENGTH:
        raise ArgumentError(f"the quaternion of joint {name!r} is not of unit length")
    return pin.SE3(pin.Quaternion(values[3:]).normalized(), values[:3])


def _shift_origin(joint: Element, motion: pin.SE3) -> None:
    """Turn and shift a joint's origin by the joint's motion."""
    origin = joint.find("origin")
    xyz, rpy = (numbers("origin", origin, key, default="0 0 0", count=3) for key in ("xyz", "rpy"))
    there = pin.SE3(pin.rpy.rpyToMatrix(np.array(rpy)), np.array(xyz)) * motion
    if origin is None:
        origin = SubElement(joint, "origin")
    origin.set("xyz", written(there.translation))
    origin.set("rpy", written(pin.rpy.matrixToRpy(there.rotation)))
