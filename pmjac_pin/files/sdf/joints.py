"""The joints of an SDFormat model: their kind, the links they join, their axes and limits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ModelFileError, did_you_mean, quoted
from pmjac_pin.files.joint_dialects import WITHOUT_LIMIT
from pmjac_pin.files.sdf.frames import MODEL, WORLD, Frames, pose, truth
from pmjac_pin.files.urdf.checks import SHORTEST_AXIS
from pmjac_pin.files.xml_text import label, numbers_in, only, written
from pmjac_pin.values.checks import LARGEST, SMALLEST

ENDS = ("parent", "child")
AXIS_TAGS = ("axis", "axis2")
# How many axes each kind has; a gearbox is no joint of its own but couples two others.
AXES: Mapping[str, int] = {
    "revolute": 1,
    "continuous": 1,
    "prismatic": 1,
    "screw": 1,
    "ball": 0,
    "fixed": 0,
    "universal": 2,
    "revolute2": 2,
    "gearbox": 2,
}
_CROSSES = ("universal", "revolute2")
_ONE_AXIS = 1e-6  # of the sine of the angle between two axes


@dataclass(frozen=True)
class SdfAxis:
    """An axis of a joint.

    Attributes
    ----------
    direction : ndarray, shape (3,)
        A unit vector in the joint's frame.
    limits : tuple of float
        Lower and upper, rad or m; ±1e16 where there is none.
    """

    direction: NDArray[np.float64]
    limits: tuple[float, float]


@dataclass(frozen=True, eq=False)
class SdfJoint:
    """A joint, in the frame of the model.

    Attributes
    ----------
    name, kind : str
    parent, child : str
        Links; the parent may be "world".
    placement : pin.SE3
        Of the joint's frame, with all joints at zero.
    axes : tuple of Axis
        As many as `AXES` says.
    element : Element
        What else the file says of it.
    pitch : float
        Of a screw, m/rad.
    armature : float
        What its motor's rotor adds to its inertia, kg m² or kg.
    """

    name: str
    kind: str
    parent: str
    child: str
    placement: pin.SE3
    axes: tuple[SdfAxis, ...]
    element: Element
    pitch: float = 0.0
    armature: float = 0.0


def read_joint(element: Element, frames: Frames, version: tuple[int, int]) -> SdfJoint:
    """Read one joint.

    Raises
    ------
    ModelFileError
        An unknown kind, link or frame, or a number that is none.
    """
    where, kind = label(element), element.get("type", "")
    if kind not in AXES:
        known = did_you_mean(kind, AXES)
        raise ModelFileError(f"{where} has the type {quoted(kind)}, which is not read{known}")
    parent, child = (frames.link(end_of(element, tag), f"{where}, <{tag}>") for tag in ENDS)
    if parent == child:
        raise ModelFileError(f"{where} joins link {parent!r} to itself")
    name = element.get("name", "")
    # Not by the joint's own name: before SDFormat 1.7 a link may have the same.
    relative_to, local = pose(where, element, end_of(element, "child"))
    placement = frames.placement(relative_to, where) * local
    tags = AXIS_TAGS[: AXES[kind]]
    axes = tuple(_joint_axis(element, tag, placement, frames, version) for tag in tags)
    if assumed := _assumed_axis(element, kind):
        _refuse_parallel(where, assumed, axes)
    pitch = _pitch(where, element) if kind == "screw" else 0.0
    armature = _armature(where, element)
    if armature and len(axes) != 1:
        got = f"{where} has a <drake:rotor_inertia>"
        raise ModelFileError(f"{got}, which is not read of a {kind} joint; remove it")
    return SdfJoint(name, kind, parent, child, placement, axes, element, pitch, armature)


def _assumed_axis(joint: Element, kind: str) -> str | None:
    """Return which of a joint's two axes the file leaves to SDFormat, where it gives the other."""
    given = [joint.find(tag) is not None for tag in AXIS_TAGS]
    if kind not in _CROSSES or all(given) or not any(given):
        return None
    return AXIS_TAGS[given.index(False)]


def assumed_axes(joints: Iterable[SdfJoint]) -> Iterator[str]:
    """Yield a sentence for each joint of two axes of which the file gives one."""
    for joint in joints:
        if tag := _assumed_axis(joint.element, joint.kind):
            default = "SDFormat's default 0 0 1, along z of the joint's frame, is taken"
            yield f"{joint.kind} joint {joint.name!r} has no <{tag}>: {default}"


def _refuse_parallel(where: str, assumed: str, axes: tuple[SdfAxis, ...]) -> None:
    if np.linalg.norm(np.cross(axes[0].direction, axes[1].direction)) < _ONE_AXIS:
        got = f"{where} has no <{assumed}>, and SDFormat's default 0 0 1 is the other axis"
        raise ModelFileError(f"{got}; write <{assumed}><xyz>...</xyz></{assumed}>")


def freedom_names(joint: SdfJoint) -> tuple[str, ...]:
    """Return the names of the joints of the tree that a joint becomes, one for each axis."""
    if len(joint.axes) < 2:
        return (joint.name,) * len(joint.axes)
    return tuple(f"{joint.name}_{tag}" for tag in AXIS_TAGS)


def end_of(joint: Element, tag: str) -> str:
    """Return the name of the frame that a joint's <parent> or <child> gives."""
    name = text_of(label(joint), joint, tag)
    if name is None:
        raise ModelFileError(f"{label(joint)} has no <{tag}>; write <{tag}>LINK</{tag}>")
    if (tag, name) == ("child", WORLD):
        why = "the world cannot be a joint's child"
        raise ModelFileError(f"{label(joint)}: {why}; swap <parent> and <child>")
    return name


def text_of(where: str, parent: Element, tag: str) -> str | None:
    """Return the text of an element's one child of that tag; None where there is none."""
    element = only(where, parent, tag)
    return None if element is None else (element.text or "").strip()


def number_of(where: str, parent: Element | None, tag: str, default: str) -> float:
    """Return the one number in an element's child of that tag, or in one that is not there."""
    text = None if parent is None else text_of(where, parent, tag)
    return numbers_in(f"{where}, <{tag.removeprefix('{*}')}>", text or default)[0]


def _pitch(where: str, joint: Element) -> float:
    """Return the pitch of a screw, m/rad, right-handed.

    <screw_thread_pitch> has it in m per turn, <thread_pitch> the inverse in rad/m of a left-handed
    one; the former counts where both are given.
    """
    for tag in ("screw_thread_pitch", "thread_pitch"):
        if text := text_of(where, joint, tag):
            (given,) = numbers_in(f"{where}, <{tag}>", text)
            if not SMALLEST <= abs(given) <= LARGEST:
                limits = f"is {given:g}; a screw's is of magnitude {SMALLEST:g} to {LARGEST:g}"
                raise ModelFileError(f"{where}, <{tag}> {limits}")
            return given / math.tau if tag == "screw_thread_pitch" else -1.0 / given
    raise ModelFileError(f"{where} is a screw and has no <screw_thread_pitch>, in m per turn")


def _armature(where: str, joint: Element) -> float:
    """Return Drake's rotor inertia times the square of its gear ratio, 1 where there is none."""
    rotor, gear = (text_of(where, joint, f"{{*}}{tag}") for tag in ("rotor_inertia", "gear_ratio"))
    (inertia,) = numbers_in(f"{where}, <drake:rotor_inertia>", "0" if rotor is None else rotor)
    (ratio,) = numbers_in(f"{where}, <drake:gear_ratio>", "1" if gear is None else gear)
    if inertia < 0.0:
        raise ModelFileError(f"{where}, <drake:rotor_inertia> is below 0: {inertia:g}")
    return inertia * ratio**2


def _joint_axis(
    joint: Element, tag: str, placement: pin.SE3, frames: Frames, version: tuple[int, int]
) -> SdfAxis:
    where = f"{label(joint)}, <{tag}>"
    element = only(label(joint), joint, tag)
    if _assumed_axis(joint, joint.get("type", "")) == tag:
        return SdfAxis(np.array([0.0, 0.0, 1.0]), (-WITHOUT_LIMIT, WITHOUT_LIMIT))
    if element is None:
        raise ModelFileError(f"{label(joint)} has no <{tag}>; a {joint.get('type')} joint needs it")
    xyz = only(where, element, "xyz")
    text = "0 0 1" if xyz is None else (xyz.text or "").strip()
    direction = np.array(numbers_in(f"{where}, <xyz>", text, count=3))
    if (length := math.hypot(*direction)) < SHORTEST_AXIS:
        raise ModelFileError(f"{where}: <xyz> is {quoted(text)}, of length zero")
    seen_from = _expressed_in(where, element, xyz, version)
    if seen_from is not None:
        turn = frames.placement(seen_from, f"{where}, <xyz>").rotation
        direction = placement.rotation.T @ turn @ direction
    return SdfAxis(direction / length, _axis_limits(where, element))


def _expressed_in(
    where: str, axis: Element, xyz: Element | None, version: tuple[int, int]
) -> str | None:
    """Return the frame that an axis is given in; None for the joint's own.

    Before SDFormat 1.5 it is the model's; from 1.5 on where `use_parent_model_frame` says so;
    and from 1.7 on `expressed_in` names it.
    """
    if xyz is not None and (frame := xyz.get("expressed_in")):
        return frame
    flag = text_of(where, axis, "use_parent_model_frame")
    if flag is None:
        return MODEL if version < (1, 5) else None
    return MODEL if truth(f"{where}, <use_parent_model_frame>", flag) else None


def _axis_limits(where: str, axis: Element) -> tuple[float, float]:
    """Return the limits; one beyond 1e16, or infinite, is none, as in SDFormat."""
    where, limit = f"{where}, <limit>", only(where, axis, "limit")
    found = []
    for tag, sign in (("lower", -1.0), ("upper", 1.0)):
        text = None if limit is None else text_of(where, limit, tag)
        if not text:
            text = written([sign * WITHOUT_LIMIT])
        elif text.lower().lstrip("+-") in ("inf", "infinity"):
            text = written([-WITHOUT_LIMIT if text.startswith("-") else WITHOUT_LIMIT])
        found += numbers_in(f"{where}, <{tag}>", text, largest=math.inf)
    lower, upper = (min(max(value, -WITHOUT_LIMIT), WITHOUT_LIMIT) for value in found)
    for tag, value, beyond in (("lower", lower, "inf"), ("upper", -upper, "-inf")):
        if value >= WITHOUT_LIMIT:
            raise ModelFileError(f"{where}, <{tag}> is {beyond}; no limit is -inf to inf")
    if lower > upper:
        raise ModelFileError(f"{where}: lower {lower:g} exceeds upper {upper:g}")
    return lower, upper
