"""The home pose of an MJCF model: its keyframe "home", or else qpos0."""

from __future__ import annotations

from collections.abc import Container, Iterable
from typing import Any

from pmjac_pin.files.mjcf.joints import SCALAR, MjcfJoint
from pmjac_pin.files.mjcf.kept import KEYFRAME
from pmjac_pin.model.spec import JointValue


def read_home(
    model: Any, joints: Iterable[MjcfJoint], held: Container[str]
) -> tuple[dict[str, JointValue], list[str]]:
    """Return each joint's value, those that are not zero, and notes."""
    qpos, notes = model.qpos0, []
    for number in range(model.nkey):
        if model.key(number).name == KEYFRAME:
            qpos = model.key_qpos[number]
            notes.append(f"the home pose is the keyframe {KEYFRAME!r}")
    home: dict[str, JointValue] = {}
    for joint in joints:
        given = qpos[joint.qpos].tolist()
        if joint.kind not in SCALAR:
            *position, w, x, y, z = given  # Pinocchio has w at the end
            home[joint.name] = (*position, x, y, z, w)
        elif joint.name not in held:
            home[joint.name] = value = _within_range(joint, given[0])
            if value != given[0]:
                what = f"{given[0]:g} of joint {joint.name!r} is outside its range"
                notes.append(f"{what}: home starts at {value:g}")
    return {name: value for name, value in home.items() if value != 0.0}, notes


def _within_range(joint: MjcfJoint, value: float) -> float:
    lower, upper = joint.limits or (value, value)
    return min(max(value, lower), upper)
