"""The home pose of an MJCF model: its keyframe "home", or else qpos0."""

from __future__ import annotations

from collections.abc import Container, Sequence
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from pmjac_pin.formats.mjcf_bodies import Body
from pmjac_pin.formats.mjcf_frames import unit_vector
from pmjac_pin.formats.mjcf_joints import KINDS, SCALAR, MjcfJoint
from pmjac_pin.spec import JointValue
from pmjac_pin.urdf_xml import numbers

_KEYFRAME = "home"


def read_home(
    root: Element, bodies: Sequence[Body], held: Container[str]
) -> tuple[dict[str, JointValue], list[str]]:
    """Return each joint's value, those that are not zero, and notes.

    Raises
    ------
    ModelFileError
        A keyframe that does not fit the joints.
    """
    joints = [(joint, body) for body in bodies for joint in body.joints]
    qpos, notes = _keyframe(root, sum(KINDS[joint.kind] for joint, _ in joints))
    home: dict[str, JointValue] = {}
    for joint, body in joints:
        given = _qpos0(joint, body) if qpos is None else qpos[: KINDS[joint.kind]]
        qpos = None if qpos is None else qpos[KINDS[joint.kind] :]
        if joint.kind not in SCALAR:
            home[joint.name] = _with_quaternion(joint, given)
        elif joint.name not in held:
            home[joint.name] = value = _within(joint, given[0])
            if value != given[0]:
                what = f"{given[0]:g} of joint {joint.name!r} is outside its range"
                notes.append(f"{what}: home starts at {value:g}")
    return {name: value for name, value in home.items() if value != 0.0}, notes


def _keyframe(root: Element, size: int) -> tuple[list[float] | None, list[str]]:
    for key in root.iterfind("keyframe/key"):
        if key.get("name") == _KEYFRAME and key.get("qpos"):
            qpos = numbers(f"key {_KEYFRAME!r}", key, "qpos", count=size)
            return qpos, [f"the home pose is the keyframe {_KEYFRAME!r}"]
    return None, []


def _qpos0(joint: MjcfJoint, body: Body) -> list[float]:
    if joint.kind in SCALAR:
        return [joint.reference]
    if joint.kind == "ball":
        return [1.0, 0.0, 0.0, 0.0]
    x, y, z, w = pin.Quaternion(body.placement.rotation).coeffs().tolist()
    return [*body.placement.translation.tolist(), w, x, y, z]


def _with_quaternion(joint: MjcfJoint, given: Sequence[float]) -> tuple[float, ...]:
    """Return MuJoCo's numbers with the quaternion's w at the end, as in Pinocchio."""
    position, wxyz = given[:-4], np.array(given[-4:])
    w, *xyz = unit_vector(f"key {_KEYFRAME!r}: joint {joint.name!r}", wxyz).tolist()
    return (*position, *xyz, w)


def _within(joint: MjcfJoint, value: float) -> float:
    lower, upper = joint.limits or (value, value)
    return min(max(value, lower), upper)
