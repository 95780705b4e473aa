"""What a URDF must be before Pinocchio may see it, and the copy that Pinocchio sees.

Pinocchio's parser drops in silence, or with a line on stderr, what it cannot use: a joint whose
link has two parents, an inertial with a malformed number, a mimic, an axis of length zero. It
crashes on long chains. So every element that it will read is checked here and written anew,
with numbers that were parsed; nothing else reaches it.

A message names the element; the caller adds the file.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from pmjac_pin.errors import ModelFileError, did_you_mean, quoted
from pmjac_pin.files.joint_dialects import BALL_TYPES
from pmjac_pin.files.urdf.control_mimics import CONTROL_JOINTS, called_joint, mimic_params
from pmjac_pin.files.urdf.joint_tree import check_tree, joints_of
from pmjac_pin.files.vocabulary import spelt
from pmjac_pin.files.xml_text import check_name, label, numbers, only, written

MAXIMAL_NAME = 200  # characters: near matches of longer names would take minutes
MAXIMAL_LINKS = 1000
MAXIMAL_JOINTS = 2000  # with those that close loops
MAXIMAL_VELOCITIES = 200  # one pinocchio.Data takes 64 bytes times their cube: here 0.5 GB
SHORTEST_AXIS = 1e-6

VELOCITIES: Mapping[str, int] = MappingProxyType(
    {"revolute": 1, "continuous": 1, "prismatic": 1, "fixed": 0, "floating": 6, "planar": 3}
)
_VERSIONS = (None, "1.0", "1.1", "1.2")
_RESERVED_LINK = "universe"
_TIE_ELEMENTS = (
    *("loop", "constraint", "loop_joint", "coupling"),
    *("drake:ball_constraint", "drake:weld_constraint", "drake:coupler_constraint"),
)
#: The numbers of the elements that Pinocchio reads, each with what `numbers` asks of it.
_ASKED_OF: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    "origin": {key: {"count": 3, "default": "0 0 0"} for key in ("xyz", "rpy")},
    "mass": {"value": {"least": 0.0}},
    "inertia": {key: {} for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")},
    "limit": {key: {"least": 0.0, "largest": math.inf} for key in ("effort", "velocity")},
    "dynamics": {key: {"least": 0.0, "default": "0"} for key in ("damping", "friction")},
}
_RANGE = {key: {"default": "0", "largest": math.inf} for key in ("lower", "upper")}


def checked_robot(robot: Element) -> Element:
    """Return what Pinocchio may read: links with inertials and joints, all of it checked."""
    _check_root(robot)
    links, joints = robot.findall("link"), robot.findall("joint")
    check_size(links, joints)
    names = checked_names(links)
    checked_names(joints)
    copy = Element("robot", name=robot.get("name", ""))
    # Element.extend hides the error of an iterator: give it lists.
    copy.extend([_checked_link(link) for link in links])
    copy.extend([checked_joint(joint, names) for joint in joints])
    check_tree(names, joints_of(copy))
    return copy


def _check_root(robot: Element) -> None:
    if robot.tag != "robot":
        raise ModelFileError(
            f"the root element is <{quoted(robot.tag)[1:-1]}>; a URDF's is <robot>"
        )
    if robot.get("name") is None:
        raise ModelFileError('<robot> has no name; write <robot name="...">')
    if (version := robot.get("version")) not in _VERSIONS:
        known = ", ".join(filter(None, _VERSIONS))
        raise ModelFileError(f"URDF version {quoted(version or '')} is not read; {known} are")
    if unexpanded := [tag for child in robot if (tag := spelt(child.tag)).startswith("xacro:")]:
        todo = "expand it first: xacro robot.urdf.xacro > robot.urdf"
        raise ModelFileError(f"<{quoted(unexpanded[0])[1:-1]}> is xacro, which is not read; {todo}")
    ties = [f"<{tag}>" for child in robot if (tag := spelt(child.tag)) in _TIE_ELEMENTS]
    ties += ["<joint> in <gazebo>"] * (robot.find("gazebo/joint") is not None)
    followers = filter(mimic_params, robot.iterfind(CONTROL_JOINTS))
    ties += [f'<param name="mimic"> in {called_joint(joint)}' for joint in followers]
    if ties:
        why = "Pinocchio would ignore it in silence"
        todo = "declare the loop as [[loop]] in the model file and remove it here"
        raise ModelFileError(f"{ties[0]} is not read, since {why}; {todo}")


def check_size(links: Sequence[Element], joints: Sequence[Element]) -> None:
    """Refuse more links and joints than can be computed with."""
    if not links:
        raise ModelFileError("there is no <link>; a robot has at least one")
    if len(links) > MAXIMAL_LINKS:
        raise ModelFileError(f"{len(links)} links are too many; at most {MAXIMAL_LINKS} are read")
    velocities = sum(VELOCITIES.get(joint.get("type", ""), 0) for joint in joints)
    if velocities > MAXIMAL_VELOCITIES:
        got = f"the joints have {velocities} degrees of freedom"
        why = "the memory needed grows with their cube"
        raise ModelFileError(f"{got}; at most {MAXIMAL_VELOCITIES} are computed with ({why})")
    if len(joints) > MAXIMAL_JOINTS:
        got = f"{len(joints)} joints are too many"
        raise ModelFileError(f"{got}; at most {MAXIMAL_JOINTS} are read")


def checked_names(elements: Sequence[Element]) -> Collection[str]:
    """Return the names of elements of one tag: there, readable, and different."""
    seen: dict[str, None] = {}
    for number, element in enumerate(elements, start=1):
        name, where = element.get("name"), f"<{element.tag}> number {number}"
        if name is None or not name.strip():
            raise ModelFileError(f"{where} has no name")
        if len(name) > MAXIMAL_NAME:
            got = f"a name of {len(name)} characters"
            raise ModelFileError(f"{where} has {got}; at most {MAXIMAL_NAME} are read")
        if not name.isprintable():
            raise ModelFileError(f"{where}: the name {name!r} holds an invisible character")
        if name == _RESERVED_LINK:
            why = "Pinocchio calls the world so, and would mix them up"
            raise ModelFileError(f"{where}: the name {name!r} is taken ({why}); choose another")
        if name in seen:
            raise ModelFileError(f"two {element.tag}s are named {name!r}; names must differ")
        seen[name] = None
    return seen


def checked_origin(where: str, parent: Element, tag: str = "origin") -> Element:
    """Return an element's <origin>: the identity where there is none."""
    origin = only(where, parent, tag)
    where = f"{where}, <{tag}>"
    if origin is not None and origin.get("quat_xyzw") is not None:
        raise ModelFileError(f"{where}: `quat_xyzw` is not read; give `rpy`")
    return _with_numbers(where, origin, "origin", _ASKED_OF["origin"])


def _with_numbers(
    where: str, element: Element | None, tag: str, wanted: Mapping[str, Mapping[str, Any]]
) -> Element:
    """Return an element with its numbers alone, read and written anew."""
    found = {key: written(numbers(where, element, key, **how)) for key, how in wanted.items()}
    return Element(tag, found)


def _checked_link(link: Element) -> Element:
    where = label(link)
    for visual in link.iterfind("visual"):
        checked_origin(f"{where}, <visual>", visual)
    copy = Element("link", name=link.get("name", ""))
    if (inertial := only(where, link, "inertial")) is not None:
        copy.append(_checked_inertial(f"{where}, <inertial>", inertial))
    return copy


def _checked_inertial(where: str, inertial: Element) -> Element:
    copy = Element("inertial")
    copy.append(checked_origin(where, inertial))
    for tag in ("mass", "inertia"):
        if (element := only(where, inertial, tag)) is None:
            raise ModelFileError(f"{where} has no <{tag}>; give both <mass> and <inertia>")
        copy.append(_with_numbers(f"{where}, <{tag}>", element, tag, _ASKED_OF[tag]))
    return copy


def checked_joint(joint: Element, links: Collection[str]) -> Element:
    """Return what Pinocchio may read of a joint between two of these links."""
    where, kind = label(joint), joint.get("type", "")
    if kind not in VELOCITIES:
        known = did_you_mean(kind, [name for name in (*VELOCITIES, *BALL_TYPES) if name != kind])
        raise ModelFileError(f"{where} has the unknown type {quoted(kind)}{known}")
    if joint.find("mimic") is not None:
        why = "Pinocchio would ignore it and let the joint move freely"
        raise ModelFileError(f"{where}: <mimic> is not supported ({why}); remove it")
    copy = Element("joint", name=joint.get("name", ""), type=kind)
    copy.append(checked_origin(where, joint))
    for tag in ("parent", "child"):
        SubElement(copy, tag, link=checked_end(where, joint, tag, links))
    if kind not in ("fixed", "floating"):
        copy.append(_checked_axis(where, joint, kind))
    if VELOCITIES[kind] == 1:
        copy.extend(_checked_limit(where, joint, kind))
        copy.extend(_checked_dynamics(where, joint))
    return copy


def checked_end(where: str, joint: Element, tag: str, links: Collection[str]) -> str:
    """Return the link that an element's child of that tag names."""
    element = only(where, joint, tag)
    name = None if element is None else element.get("link")
    if name is None:
        raise ModelFileError(f'{where} has no {tag}; write <{tag} link="..."/>')
    check_name(f"{where}: the {tag} link", name, links)
    return name


def _checked_axis(where: str, joint: Element, kind: str) -> Element:
    element = only(where, joint, "axis")
    default = "1 0 0" if element is None else None  # URDF's; of an <axis/> urdfdom makes 0 0 0
    axis = numbers(f"{where}, <axis>", element, "xyz", default=default, count=3)
    if math.hypot(*axis) < SHORTEST_AXIS:
        length = f"`xyz` is {written(axis)!r}, of length zero"
        raise ModelFileError(f"{where}, <axis>: {length}; a joint that moves needs a direction")
    if kind == "planar" and not (axis[0] == axis[1] == 0.0 < axis[2]):
        why = "Pinocchio moves a planar joint in x and y whatever its axis"
        todo = 'write <axis xyz="0 0 1"/> and turn the origin'
        raise ModelFileError(f"{where}, <axis>: `xyz` is {written(axis)!r}, but {why}; {todo}")
    return Element("axis", xyz=written(axis))


def _checked_limit(where: str, joint: Element, kind: str) -> list[Element]:
    element = only(where, joint, "limit")
    if element is None:
        if kind == "continuous":
            return []
        example = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
        raise ModelFileError(f"{where} is {kind} and has no <limit>; write {example}")
    where, known = f"{where}, <limit>", _ASKED_OF["limit"]
    copy = _with_numbers(
        where, element, "limit", known if kind == "continuous" else {**known, **_RANGE}
    )
    lower, upper = (float(copy.get(key, "0")) for key in _RANGE)
    if lower > upper:
        got = f"`lower` is {lower:g} and `upper` is {upper:g}"
        raise ModelFileError(f"{where}: {got} (0 when left out); lower must not exceed upper")
    return [copy]


def _checked_dynamics(where: str, joint: Element) -> list[Element]:
    if (element := only(where, joint, "dynamics")) is None:
        return []
    return [_with_numbers(f"{where}, <dynamics>", element, "dynamics", _ASKED_OF["dynamics"])]
