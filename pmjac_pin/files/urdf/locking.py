"""Locking joints of a URDF: each becomes fixed where it is at a given value."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from types import MappingProxyType
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError, LimitError, unknown_name
from pmjac_pin.files.anchors import placement_of
from pmjac_pin.files.tree_urdf import origin
from pmjac_pin.files.urdf.checks import checked_origin
from pmjac_pin.files.urdf.robot import Urdf
from pmjac_pin.files.xml_text import label, numbers
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.joint_kinds import JOINT_KINDS
from pmjac_pin.model.limits import SWITCH
from pmjac_pin.model.spec import JointValue

#: URDF's joints of several degrees of freedom, by the names that the kinds have.
_SEVERAL = {"floating": "free", "planar": "planar"}
_AXIS = "1 0 0"  # URDF's, where a joint gives none
_NO_PITCHES: Mapping[str, float] = MappingProxyType({})


def lock_joints(
    urdf: Urdf,
    values: Mapping[str, JointValue],
    pitches: Mapping[str, float] = _NO_PITCHES,
    balls: Collection[str] = (),
    *,
    enforce_limits: bool = True,
) -> Urdf:
    """Return the URDF with these joints fixed at these values.

    Parameters
    ----------
    urdf : Urdf
    values : mapping of str to float or floats
        Revolute, continuous or prismatic joints, and their values in rad or m. Floating, planar
        and ball joints, and their values as in a pose: translation in m, then an angle, a rotation
        vector, (cos, sin) or a quaternion xyzw; 0 for their origin.
    pitches : mapping of str to float, optional
        How far joints that turn slide as well, m/rad.
    balls : collection of str, optional
        Floating joints that only turn.
    enforce_limits : bool
        Whether the values keep within the joints' limits.

    Raises
    ------
    UnknownNameError
        A joint that the URDF does not have.
    ArgumentError
        A joint that is fixed, or values that do not fit the joint.
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
        if (kind := joints[name].get("type", "")) in _SEVERAL:
            several = "spherical" if name in balls else _SEVERAL[kind]
            motion = _locked_placement(several, name, value)
        else:
            motion = _joint_motion(joints[name], value, pitches.get(name, 0.0))
            if enforce_limits:
                _check_limits(joints[name], value)
        _fix(joints[name], motion)
    return urdf.changed(robot, values.keys())


def _fix(joint: Element, motion: pin.SE3) -> None:
    """Make a joint fixed where this motion takes it."""
    _shift_origin(joint, motion)
    for tag in ("axis", "limit", "dynamics"):
        for element in joint.findall(tag):
            joint.remove(element)
    joint.set("type", "fixed")


def _joint_motion(joint: Element, value: JointValue, pitch: float) -> pin.SE3:
    """Return the motion of a joint of one degree of freedom at a value."""
    name, kind = joint.get("name", ""), joint.get("type", "")
    if kind not in ("revolute", "continuous", "prismatic"):
        raise ArgumentError(f"joint {name!r} is {kind}; only joints that move can be locked")
    if not isinstance(value, float | int):
        raise ArgumentError(f"joint {name!r} is locked at one number, got {len(value)}")
    return _motion_at(joint, value, pitch)


def _check_limits(joint: Element, value: JointValue) -> None:
    if joint.get("type") not in ("revolute", "prismatic") or isinstance(value, tuple):
        return
    name = joint.get("name", "")
    lower, upper = (
        numbers(name, joint.find("limit"), end, default="0", largest=np.inf)[0]
        for end in ("lower", "upper")
    )
    if not lower <= value <= upper:
        message = (
            f"joint {name!r} cannot be locked at {value:g}, outside [{lower:g}, {upper:g}]{SWITCH}"
        )
        unit = "m" if joint.get("type") == "prismatic" else "rad"
        raise LimitError(message, joint=name, value=value, lower=lower, upper=upper, unit=unit)


def _motion_at(joint: Element, value: float, pitch: float) -> pin.SE3:
    """Return the motion of a joint of one degree of freedom at this value."""
    direction = np.array(numbers("axis", joint.find("axis"), "xyz", default=_AXIS, count=3))
    step = value * direction / np.linalg.norm(direction)
    if joint.get("type") == "prismatic":
        return pin.SE3(np.eye(3), step)
    return pin.SE3(pin.exp3(step), pitch * step)


def _locked_placement(kind: str, name: str, value: JointValue) -> pin.SE3:
    """Return where a joint of several degrees of freedom is at its values, as a pose gives them."""
    model = pin.Model()
    model.addJoint(0, JOINT_KINDS[kind].built(0.0), pin.SE3.Identity(), name)
    at_origin = isinstance(value, float | int) and value == 0
    q = JointCoordinates(model).q({} if at_origin else {name: value})
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    return data.oMi[1].copy()


def _shift_origin(joint: Element, motion: pin.SE3) -> None:
    """Turn and shift a joint's origin by the joint's motion."""
    there = placement_of(checked_origin(label(joint), joint)) * motion
    element = joint.find("origin")
    if element is None:
        element = SubElement(joint, "origin")
    element.attrib.update(origin(there))
