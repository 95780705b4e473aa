"""What other programs write into a URDF to tie links and joints together, as URDF+ writes it.

Each becomes a <loop> or a <mimic>: Drake's <drake:ball_constraint>, <loop_joint> of Isaac Sim and
of Drake's first parser, a <joint> within <gazebo>, Gazebo's mimic plugin and the `mimic` of
<ros2_control>, and the pairs of frames closing_NAME_1 and closing_NAME_2 of onshape-to-robot.

References: the documentation of Drake, "Drake Extensions"; of Gazebo Classic, "Kinematic loops";
of onshape-to-robot, "Handling kinematic loops".
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from xml.etree.ElementTree import Element, SubElement

import pinocchio as pin

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.gazebo_plugins import is_mimic_plugin
from pmjac_pin.files.sdf.frames import MODEL, WORLD, Frames, SdfFrame
from pmjac_pin.files.sdf.joints import SdfJoint, read_joint
from pmjac_pin.files.sdf.plugins import BALL, ball_parts, detachable_joints, is_detachable
from pmjac_pin.files.tree_urdf import origin
from pmjac_pin.files.urdf.control_mimics import CONTROL_JOINTS, called_joint, mimic_params
from pmjac_pin.files.urdf.loop_elements import TAGS
from pmjac_pin.files.vocabulary import spelt
from pmjac_pin.files.xml_text import check_name, label, numbers_in, only, written

PLUGINS, GAZEBO_JOINTS = "gazebo/plugin", "gazebo/joint"  # where they are in a <robot>
CLOSING = "closing_"  # what onshape-to-robot calls frames that coincide
_AXES_OF_THE_JOINT = (1, 12)  # the version of SDFormat, whose axes are in the joint's frame
_LOOP_KINDS = {"ball": "spherical"}
_CLOSING_FRAME = re.compile(rf"({CLOSING}.+)_(\d+)")
_NOT_READ = {
    "drake:coupler_constraint": "gear the joints by <mimic>",
    "drake:weld_constraint": 'write it as <loop type="fixed">',
}


def refuse_unreadable(robot: Element) -> None:
    """Refuse the ties that are known and that nobody reads."""
    for child in robot:
        if (todo := _NOT_READ.get(tag := spelt(child.tag))) is not None:
            why = "is not read, and left out it would free a motion"
            raise ModelFileError(f"<{tag}> {why}; {todo}")


def take_loops(robot: Element) -> list[Element]:
    """Take the elements that declare loops out of a robot; return them as <loop> or <constraint>.

    Raises
    ------
    ModelFileError
        One that does not say what it joins.
    """
    readers = {"loop_joint": _loop_joint, BALL: _ball_constraint, **dict.fromkeys(TAGS, _unchanged)}
    found = [child for child in robot if spelt(child.tag) in readers]
    for child in found:
        robot.remove(child)
    return [readers[spelt(child.tag)](child) for child in found]


def _unchanged(element: Element) -> Element:
    return element


def _loop_joint(element: Element) -> Element:
    kind, name = element.get("type", ""), element.get("name", "")
    loop = Element("loop", name=name, type=kind)
    for tag, end in (("link1", "predecessor"), ("link2", "successor")):
        if (link := only(label(element), element, tag)) is None:
            raise ModelFileError(f'{label(element)} has no <{tag}>; write <{tag} link="..."/>')
        place = {key: link.get(key, "0 0 0") for key in ("xyz", "rpy")}
        SubElement(SubElement(loop, end, link=link.get("link", "")), "origin", place)
    loop.extend(element.findall("axis"))
    return loop


def _ball_constraint(element: Element) -> Element:
    """Return Drake's ball constraint, whose values are attributes in URDF and text in SDFormat."""
    given, loop = ball_parts(element), Element("loop", type="spherical")
    for body, point, end in (("body_A", "p_AP", "predecessor"), ("body_B", "p_BQ", "successor")):
        link = SubElement(loop, end, link=given[body].get("name", ""))
        SubElement(link, "origin", xyz=given[point].get("value", ""))
    return loop


def take_gazebo_joints(
    robot: Element, placements: Mapping[str, pin.SE3]
) -> tuple[list[Element], list[str]]:
    """Take the joints within <gazebo> out of a robot; return them as elements, and notes.

    Those of Gazebo's detachable joints are among them.

    Parameters
    ----------
    robot : Element
    placements : mapping of str to pin.SE3
        Where the links are with all joints at zero, the base first.
    """
    base = next(iter(placements))
    frames = Frames(
        {name: SdfFrame(name, name, MODEL, place) for name, place in placements.items()},
        list(placements),
        base,
    )
    loops, notes = [], []
    for gazebo in robot.iterfind("gazebo"):
        for element in gazebo.findall("joint"):
            gazebo.remove(element)
            joint = read_joint(element, frames, _AXES_OF_THE_JOINT)
            if (joint.parent, joint.child, joint.kind) == (WORLD, base, "fixed"):
                notes.append(f"{label(element)} of <gazebo> holds the base: it is held anyway")
                continue
            loops.append(_closing_joint(joint, placements, base))
            done = f"is closed as {loops[-1].get('type')}, without its limits"
            notes.append(f"{label(element)} of <gazebo> {done}")
    for joint in detachable_joints(robot, PLUGINS, frames, ()):
        loops.append(_closing_joint(joint, placements, base))
        ends = f"links {joint.parent!r} and {joint.child!r}"
        notes.append(f"{label(joint.element)} of <gazebo> is closed as fixed, between {ends}")
    for gazebo in robot.iterfind("gazebo"):
        for plugin in gazebo.findall("plugin"):
            if is_detachable(plugin, robot):
                gazebo.remove(plugin)
    return loops, notes


def _closing_joint(joint: SdfJoint, placements: Mapping[str, pin.SE3], base: str) -> Element:
    """Return a joint as an element: the base stands where the file has the world."""
    where, kind = label(joint.element), _LOOP_KINDS.get(joint.kind, joint.kind)
    if any(spelt(inside.tag) in ("mimic", "drake:mimic") for inside in joint.element.iter()):
        got = f"{where} of <gazebo> closes a loop, and its <mimic> is not read there"
        todo = "make it a <joint> of the robot itself, and cut another one instead"
        raise ModelFileError(f"{got}; {todo}")
    if kind in ("gearbox", "revolute2"):
        raise ModelFileError(f"{where} of <gazebo> is of type {kind}, which is not read there")
    parent = base if joint.parent == WORLD else joint.parent
    if parent == joint.child:
        raise ModelFileError(f"{where} of <gazebo> joins link {parent!r} to itself")
    loop = Element("constraint", name=joint.name, type=kind)
    for tag, link in (("parent", parent), ("child", joint.child)):
        SubElement(loop, tag, link=link)
        SubElement(loop, f"{tag}_origin", origin(placements[link].actInv(joint.placement)))
    if joint.axes:
        for tag, axis in (("parent_axis", joint.axes[0]), ("child_axis", joint.axes[-1])):
            SubElement(loop, tag, xyz=written(axis.direction))
    return loop


def closing_frames(
    links: Collection[str], loops: Sequence[Element], taken: Collection[str]
) -> tuple[list[Element], list[str]]:
    """Return a loop for each pair of links closing_NAME_1 and closing_NAME_2, and notes.

    Parameters
    ----------
    links : collection of str
    loops : sequence of Element
        Those that are declared; what they join is left to them.
    taken : collection of str
        Further links that are joined otherwise.
    """
    joined = {*taken, *(end.get("link", "") for loop in loops for end in loop)}
    found, notes = [], []
    for link in links:
        if (parts := _CLOSING_FRAME.fullmatch(link)) is None or link in joined:
            continue
        first, second = f"{parts[1]}_1", f"{parts[1]}_2"
        other = second if link == first else first
        if link not in (first, second):
            notes.append(f"link {link!r} closes no loop: those of {first!r} and {second!r} do")
        elif other not in links:
            notes.append(f"link {link!r} has no {other!r} to close a loop with")
        elif link == first and second not in joined:
            loop = Element("loop", name=parts[1], type="spherical")
            SubElement(loop, "predecessor", link=first)
            SubElement(loop, "successor", link=second)
            found.append(loop)
            kind = "as a ball, since the file does not say by what kind of joint"
            notes.append(f"the frames {first!r} and {second!r} are closed {kind}")
    return found, notes


def take_plugin_mimics(robot: Element) -> None:
    """Move into each joint, as <mimic>, what Gazebo's plugins say it follows.

    Raises
    ------
    ModelFileError
        A joint that does not exist, or that is to follow in two ways.
    """
    _put_mimics(robot, _plugin_ties(robot))


def take_control_mimics(robot: Element) -> None:
    """Move into each joint, as <mimic>, what <ros2_control> says it follows.

    Raises
    ------
    ModelFileError
        As `take_plugin_mimics`.
    """
    _put_mimics(robot, _of_control(robot))


def _put_mimics(robot: Element, ties: Iterator[tuple[str, str, Element]]) -> None:
    by_name = {joint.get("name", ""): joint for joint in robot.iterfind("joint")}
    for where, follower, mimic in ties:
        check_name(f"{where}: the joint", follower, by_name)
        joint = by_name[follower]
        if (own := only(label(joint), joint, "mimic")) is None:
            joint.append(mimic)
        elif _rule(own, label(joint)) != _rule(mimic, where):
            raise ModelFileError(f"{label(joint)} follows otherwise by <mimic> than by {where}")


def _rule(mimic: Element, where: str) -> tuple[str, float, float]:
    multiplier, offset = (
        numbers_in(f"{where}, `{key}`", mimic.get(key, default))[0]
        for key, default in (("multiplier", "1"), ("offset", "0"))
    )
    return mimic.get("joint", ""), multiplier, offset


def _plugin_ties(robot: Element) -> Iterator[tuple[str, str, Element]]:
    for gazebo in robot.iterfind("gazebo"):
        for plugin in filter(is_mimic_plugin, gazebo.findall("plugin")):
            gazebo.remove(plugin)
            where = label(plugin)
            leader, follower, *factors = (
                only(where, plugin, tag) for tag in ("joint", "mimicJoint", "multiplier", "offset")
            )
            given = dict(zip(("multiplier", "offset"), factors, strict=True))
            yield where, _text_within(follower), _mimic(_text_within(leader), given)


def _of_control(robot: Element) -> Iterator[tuple[str, str, Element]]:
    for joint in robot.iterfind(CONTROL_JOINTS):
        if params := mimic_params(joint):
            joint.remove(leader := params["mimic"])
            yield (
                called_joint(joint),
                joint.get("name", ""),
                _mimic(_text_within(leader), params),
            )


def _mimic(leader: str, given: Mapping[str, Element | None]) -> Element:
    keys = [key for key in ("multiplier", "offset") if given.get(key) is not None]
    return Element("mimic", {key: _text_within(given[key]) for key in keys}, joint=leader)


def _text_within(element: Element | None) -> str:
    return "" if element is None else (element.text or "").strip()
