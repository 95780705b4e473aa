"""Loops that a URDF declares: URDF+'s <loop>, the <constraint> proposed for urdfdom, <mimic>.

<loop> has a predecessor and a successor, each with an <origin> inside, and one <axis>, the same
in both frames. <constraint> has a parent and a child, <parent_origin> and <child_origin>, and may
have two axes, <parent_axis> and <child_axis>; it is also read as URDF+'s parser exports it.

References: M. Chignoli et al., "URDF+: An Enhanced URDF for Robots with Kinematic Loops", 2024;
pull request 264 of ros/urdfdom, 2026.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from xml.etree.ElementTree import Element

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ModelFileError, did_you_mean, quoted
from pmjac_pin.files.anchors import KINDS, Anchors, loop_of_kind, placement_of
from pmjac_pin.files.joint_dialects import listed
from pmjac_pin.files.urdf.checks import SHORTEST_AXIS, checked_end, checked_origin
from pmjac_pin.files.xml_text import check_name, label, numbers, only, written
from pmjac_pin.model.loop_between_frames import X
from pmjac_pin.model.loop_spec import JointLoop, Loop
from pmjac_pin.model.table import Vector

TAGS = ("loop", "constraint")
_SAME_AXIS = 1e-9


#: What implementations of the proposed <constraint> call kinds of ours.
_OTHER_NAMES = {"ball": "spherical", "spherical_joint": "spherical"}


@dataclass(frozen=True, slots=True)
class ClosingElement:
    """A loop that an element declares.

    Attributes
    ----------
    where : str
        How messages call the element.
    links : tuple of str
        The links that it joins.
    loop : Loop or None
        None for one that holds nothing.
    """

    where: str
    links: tuple[str, str]
    loop: Loop | None


def read_closings(
    elements: Sequence[Element], links: Collection[str], anchors: Anchors
) -> list[ClosingElement]:
    """Return the loops of <loop> and <constraint> elements; their anchors are added."""
    return [_closing(element, number, links, anchors) for number, element in enumerate(elements, 1)]


def _closing(
    element: Element, number: int, links: Collection[str], anchors: Anchors
) -> ClosingElement:
    name = element.get("name") or f"{element.tag}{number}"
    where = f"{element.tag} {name!r}"
    given = element.get("type", "")
    kind = _OTHER_NAMES.get(given, given)
    if kind not in KINDS:
        known = did_you_mean(given, KINDS)
        raise ModelFileError(f"{where} has the unknown type {quoted(given)}{known}")
    tags = ("predecessor", "successor")
    if element.find("parent") is not None or element.find("child") is not None:
        tags = ("parent", "child")
    first, second = (checked_end(where, element, tag, links) for tag in tags)
    if first == second:
        raise ModelFileError(f"{where} joins link {first!r} with itself")
    places = [_end_placement(where, element, tag) for tag in tags]
    if kind == "floating":
        return ClosingElement(where, (first, second), None)
    axes = (X, X) if kind in ("spherical", "fixed") else _loop_axes(where, element, kind)
    if kind != "universal":
        places[1] *= _turn_of_second(where, kind, axes)
    frames = (anchors.add(name, first, places[0]), anchors.add(name, second, places[1]))
    return ClosingElement(where, (first, second), loop_of_kind(kind, frames, axes))


def _end_placement(where: str, element: Element, tag: str) -> pin.SE3:
    """Return an end's <origin>, inside it or beside it as <TAG_origin>."""
    end = only(where, element, tag)
    if end is not None and end.find("origin") is not None:
        return placement_of(checked_origin(f"{where}, <{tag}>", end))
    return placement_of(checked_origin(where, element, f"{tag}_origin"))


def _loop_axes(where: str, element: Element, kind: str) -> tuple[Vector, Vector]:
    """Return the axis in the first and in the second frame, of length 1."""
    if kind == "universal":
        for tag in ("parent_axis", "child_axis"):
            if element.find(tag) is None:
                raise ModelFileError(f"{where} is universal: give <parent_axis> and <child_axis>")
    return (
        _first_direction(where, element, ("parent_axis", "axis", "child_axis")),
        _first_direction(where, element, ("child_axis", "axis", "parent_axis")),
    )


def _first_direction(where: str, element: Element, tags: Sequence[str]) -> Vector:
    """Return the direction of the first of these elements that is there; URDF's x for none."""
    for tag in tags:
        if (found := only(where, element, tag)) is not None:
            x, y, z = numbers(f"{where}, <{tag}>", found, "xyz", count=3)
            if (length := math.hypot(x, y, z)) < SHORTEST_AXIS:
                got = f"`xyz` is {written([x, y, z])!r}, of length zero"
                raise ModelFileError(f"{where}, <{tag}>: {got}; an axis needs a direction")
            return (x / length, y / length, z / length)
    return X


def _turn_of_second(where: str, kind: str, axes: tuple[Vector, Vector]) -> pin.SE3:
    """Return the turn of the second frame that gives the axis the same components in both."""
    first, second = map(np.array, axes)
    if np.abs(first - second).max() < _SAME_AXIS:
        return pin.SE3.Identity()
    if kind == "prismatic":
        todo = "turn one of the origins instead, since a slider keeps the frames aligned"
        raise ModelFileError(f"{where} is prismatic and has two different axes; {todo}")
    return pin.SE3(pin.Quaternion.FromTwoVectors(first, second).matrix(), np.zeros(3))


def read_gears(joints: Sequence[Element]) -> tuple[JointLoop, ...]:
    """Return each <mimic> as q = multiplier · q_leader + offset, and take it out of its joint.

    One of a fixed joint, which has no value, says nothing: `idle_mimics` tells.

    Raises
    ------
    ModelFileError
        A leader that does not exist, or joints that follow each other in a circle.
    """
    names = [joint.get("name", "") for joint in joints]
    gears: dict[str, JointLoop] = {}
    for joint in joints:
        where = label(joint)
        if (mimic := only(where, joint, "mimic")) is None:
            continue
        joint.remove(mimic)
        if joint.get("type") == "fixed":
            continue
        where, leader = f"{where}, <mimic>", mimic.get("joint", "")
        check_name(f"{where}: the joint", leader, names)
        (ratio,) = numbers(where, mimic, "multiplier", default="1")
        (offset,) = numbers(where, mimic, "offset", default="0")
        follower = joint.get("name", "")
        if leader == follower:
            raise ModelFileError(f"{where}: the joint follows itself")
        gears[follower] = JointLoop(joints=(leader, follower), ratio=ratio, offset=offset)
    _refuse_circles(gears)
    return tuple(gears.values())


def idle_mimics(joints: Sequence[Element]) -> list[str]:
    """Return a note on joints that are fixed and are to follow others all the same."""
    fixed = [joint for joint in joints if joint.get("type") == "fixed"]
    names = [joint.get("name", "") for joint in fixed if joint.find("mimic") is not None]
    return [f"fixed, and follow no other joint: {listed(names)}"] if names else []


def _refuse_circles(gears: Mapping[str, JointLoop]) -> None:
    leaders = {follower: [gear.joints[0]] for follower, gear in gears.items()}
    try:
        TopologicalSorter(leaders).prepare()
    except CycleError as error:
        circle = " -> ".join(error.args[1][::-1])
        raise ModelFileError(f"joints follow each other by <mimic>: {circle}") from None
