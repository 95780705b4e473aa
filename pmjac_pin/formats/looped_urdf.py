"""URDF with loops in it: cut into a tree, and all that closes it declared as loops.

A loop may be written as a link that is the child of two joints, as a cycle of joints, as URDF+'s
<loop>, as the <constraint> proposed for urdfdom, or as <mimic>.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element, tostring

import pinocchio as pin

from pmjac_pin.errors import ModelFileError
from pmjac_pin.formats.anchors import Anchors, loop_of_kind, placement_of
from pmjac_pin.formats.foreign_model import ForeignModel
from pmjac_pin.formats.joint_dialects import (
    floating_balls,
    home_within_limits,
    independence,
    opened_limits,
)
from pmjac_pin.formats.loop_elements import TAGS, Closing, read_closings, read_gears
from pmjac_pin.formats.spanning_tree import SpanningTree, spanning_tree
from pmjac_pin.loop_spec import JointLoop, Loop, X
from pmjac_pin.text_file import at_file, read_text
from pmjac_pin.urdf import MAXIMAL_SIZE, parse_urdf
from pmjac_pin.urdf_checks import (
    VELOCITIES,
    UrdfJoint,
    check_size,
    checked_joint,
    checked_names,
    joints_of,
)
from pmjac_pin.urdf_xml import parse_xml


def read_looped_urdf(path: Path, motors: Collection[str] = ()) -> ForeignModel:
    """Read a URDF, with loops or without.

    Parameters
    ----------
    path : Path
    motors : collection of str, optional
        Joints that are not to be cut, beside those of which the file says so.

    Returns
    -------
    ForeignModel
        With `actuated` where joints say whether they are ``independent``, or where there is no
        loop: then every joint of one degree of freedom that follows no other.

    Raises
    ------
    ModelFileError
        The message starts with the file's path and names the element at fault.
    """
    with at_file(str(path)):
        model = read_robot(parse_xml(read_text(path, MAXIMAL_SIZE)), path, motors)
        if model.actuated or any(not isinstance(loop, JointLoop) for loop in model.loops):
            return model
        followers = {loop.joints[1] for loop in model.loops if isinstance(loop, JointLoop)}
        single = [joint.name for joint in model.urdf.joints if VELOCITIES[joint.type] == 1]
        actuated = tuple(name for name in single if name not in followers)
        note = "no loop closes: every joint of one degree of freedom counts as a motor"
        return replace(model, actuated=actuated, notes=(*model.notes, note))


def read_robot(robot: Element, path: Path, motors: Collection[str]) -> ForeignModel:
    """Read the <robot> of a URDF, which is changed; `actuated` only where joints tell.

    Raises
    ------
    ModelFileError
        Without the file's path.
    """
    links, joints = robot.findall("link"), robot.findall("joint")
    check_size(links, joints)
    names = checked_names(links)
    checked_names(joints)
    if robot.find("coupling") is not None:
        todo = "gear the joints by <mimic>"
        raise ModelFileError(f"<coupling> is not read, and left out it would free a motion; {todo}")
    limit_notes = opened_limits(joints)
    balls = floating_balls(joints)
    independent = independence(joints)
    gears = read_gears(joints)
    elements = [element for element in robot if element.tag in TAGS]
    checked = Element("robot")
    checked.extend([checked_joint(joint, names) for joint in joints])
    geared = {name for gear in gears for name in gear.joints}
    wanted = {name for name, given in independent.items() if given}
    given = joints_of(checked)
    tree = _tree(list(names), given, {*motors, *wanted, *geared})
    for element in (*elements, *(joints[number] for number in tree.cut)):
        robot.remove(element)
    anchors = Anchors(robot)
    for branch in tree.branches:
        if branch.turned:
            anchors.turn(joints[branch.joint], _placement(checked[branch.joint]))
    cut_loops = [_closed(given[number], checked[number], balls, anchors) for number in tree.cut]
    closings = read_closings(elements, names, anchors)
    kept = [joint for number, joint in enumerate(given) if number not in tree.cut]
    home, home_notes = home_within_limits(checked, kept)
    loops = (*cut_loops, *(closing.loop for closing in closings), *gears)
    return ForeignModel(
        name=path.stem,
        urdf=parse_urdf(tostring(robot, encoding="unicode"), str(path)),
        loops=tuple(loop for loop in loops if loop is not None),
        spherical=tuple(joint.name for joint in kept if joint.name in balls),
        home=home,
        actuated=_actuated(kept, independent, gears),
        notes=(
            *limit_notes,
            *home_notes,
            *_tree_notes(tree, given, balls),
            *_closing_notes(closings, kept),
        ),
    )


def _actuated(
    tree: Sequence[UrdfJoint], independent: Mapping[str, bool], gears: Iterable[JointLoop]
) -> tuple[str, ...]:
    """Return the independent joints, once one joint says whether it is: true is the default."""
    if not independent:
        return ()
    followers = {gear.joints[1] for gear in gears}
    single = [joint.name for joint in tree if VELOCITIES[joint.type] == 1]
    return tuple(name for name in single if name not in followers and independent.get(name, True))


def _tree(links: Sequence[str], joints: Sequence[UrdfJoint], kept: Collection[str]) -> SpanningTree:
    for joint in joints:
        if joint.parent == joint.child:
            message = f"joint {joint.name!r} joins link {joint.parent!r} with itself"
            raise ModelFileError(message)
    ends = [(joint.parent, joint.child) for joint in joints]
    first = [number for number, joint in enumerate(joints) if joint.name in kept]
    tree = spanning_tree(links, ends, first=first)
    for joint in (joints[number] for number in tree.cut if number in first):
        got = f"joint {joint.name!r} is a motor or geared by <mimic>, and would have to be cut"
        why = f"another such joint holds link {joint.child!r}, or it is the base"
        raise ModelFileError(f"{got}, since {why}")
    return tree


def _closed(
    joint: UrdfJoint, element: Element, balls: Collection[str], anchors: Anchors
) -> Loop | None:
    """Return the loop that does what a joint did that was cut."""
    kind = "spherical" if joint.name in balls else joint.type
    if kind == "floating":
        return None
    axis = element.find("axis")
    x, y, z = X if axis is None else map(float, axis.get("xyz", "").split())
    frames = (anchors.add(joint.name, joint.parent, _placement(element)), joint.child)
    return loop_of_kind(kind, frames, (x, y, z))


def _placement(joint: Element) -> pin.SE3:
    origin = joint.find("origin")
    return pin.SE3.Identity() if origin is None else placement_of(origin)


def _tree_notes(
    tree: SpanningTree, joints: Sequence[UrdfJoint], balls: Collection[str]
) -> list[str]:
    """Say which joints were turned round, and which were cut for what."""
    above = {branch.below: joints[branch.joint].name for branch in tree.branches}
    notes = [
        f"joint {joints[branch.joint].name!r} is turned round, as none leads to {branch.below!r}"
        for branch in tree.branches
        if branch.turned
    ]
    for joint in (joints[number] for number in tree.cut):
        kind = "spherical" if joint.name in balls else joint.type
        done = "holds nothing: left out" if kind == "floating" else f"cut, and closed as {kind}"
        other = above.get(joint.child)
        why = "which is the base" if other is None else f"which {other!r} holds"
        notes.append(f"joint {joint.name!r} leads to link {joint.child!r}, {why}: {done}")
    return notes


def _closing_notes(closings: Sequence[Closing], tree: Sequence[UrdfJoint]) -> list[str]:
    """Say which elements hold nothing, and which join links that a joint joins already."""
    joined = {frozenset((joint.parent, joint.child)): joint.name for joint in tree}
    notes = [
        f"{closing.where} is floating and holds nothing: left out"
        for closing in closings
        if closing.loop is None
    ]
    for closing in closings:
        if (name := joined.get(frozenset(closing.links))) is not None:
            notes.append(f"{closing.where} joins the links that joint {name!r} joins already")
    return notes
