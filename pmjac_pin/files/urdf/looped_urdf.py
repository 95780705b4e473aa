"""URDF with loops in it: cut into a tree, and all that closes it declared as loops.

A loop may be written as a link that is the child of two joints, as a cycle of joints, as URDF+'s
<loop> or <coupling>, as the <constraint> proposed for urdfdom, as <mimic>, or as other programs
write it: see `pmjac_pin.files.urdf.ties`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element

from pmjac_pin.files.anchors import Anchors
from pmjac_pin.files.cut_joints import CutJoints
from pmjac_pin.files.foreign_model import ForeignModel
from pmjac_pin.files.joint_dialects import home_within_limits, independence, opened_limits
from pmjac_pin.files.massless import mass_notes
from pmjac_pin.files.sdf.plugins import is_detachable
from pmjac_pin.files.sdf.vocabulary import SDF_WORDS
from pmjac_pin.files.text_file import at_file, read_text
from pmjac_pin.files.urdf.checks import VELOCITIES, check_size, checked_names
from pmjac_pin.files.urdf.couplings import follower
from pmjac_pin.files.urdf.dialects import Said, take_said, unread_words
from pmjac_pin.files.urdf.joint_tree import UrdfJoint
from pmjac_pin.files.urdf.loop_elements import ClosingElement, read_closings
from pmjac_pin.files.urdf.robot import MAXIMAL_URDF, Urdf
from pmjac_pin.files.urdf.rotors import lost_rotors
from pmjac_pin.files.urdf.ties import (
    GAZEBO_JOINTS,
    PLUGINS,
    closing_frames,
    refuse_unreadable,
    take_gazebo_joints,
    take_loops,
)
from pmjac_pin.files.xml_text import parse_xml
from pmjac_pin.model.loop_spec import JointLoop


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
        loop and no motors are given: then every joint of one degree of freedom that follows no
        other.

    Raises
    ------
    ModelFileError
        The message starts with the file's path and names the element at fault.
    """
    with at_file(str(path)):
        model = read_robot(parse_xml(read_text(path, MAXIMAL_URDF)), path, motors)
        return model if motors else model.with_open_chain()


def read_robot(
    robot: Element,
    path: Path,
    motors: Collection[str],
    *,
    joined: Collection[str] = (),
    added: Collection[str] = (),
) -> ForeignModel:
    """Read the <robot> of a URDF, which is changed; `actuated` only where joints tell.

    Parameters
    ----------
    robot : Element
    path : Path
    motors : collection of str
        Joints that are not to be cut.
    joined : collection of str
        Links whose loops are told elsewhere.
    added : collection of str
        Links that the file does not have.

    Raises
    ------
    ModelFileError
        Without the file's path.
    """
    elements, names, unread = _checked(robot)
    limit_notes, said = opened_limits(elements), take_said(robot)
    independent, gears = independence(elements), [*said.mimics, *said.couplings]
    cut = CutJoints.of(elements, names, said.balls, _uncut(motors, independent, gears))
    declared, tie_notes = _declared(robot, names, cut, joined)
    kept = [joint.name for joint in cut.kept]
    cut.remove_from(robot)
    anchors = Anchors(robot)
    cut.turn(anchors)
    cut_loops = cut.loops(anchors)
    closings = read_closings(declared, names, anchors) if declared else []
    loops = (*cut_loops, *(closing.loop for closing in closings), *gears)
    home, home_notes = home_within_limits(cut.checked, cut.kept)
    urdf = Urdf.of(robot, str(path))
    massless = mass_notes(urdf, set(names) - set(added))
    return ForeignModel(
        name=path.stem,
        urdf=urdf,
        loops=tuple(loop for loop in loops if loop is not None),
        spherical=tuple(name for name in kept if name in said.balls),
        armature={name: said.armature[name] for name in said.armature if name in kept},
        home=home,
        actuated=_actuated(cut.kept, independent, _followers(said, independent)),
        notes=(
            *(*limit_notes, *home_notes, *cut.notes(), *lost_rotors(said.armature, kept)),
            *(*tie_notes, *_closing_notes(closings, cut.kept), *said.notes, *massless),
        ),
        unread=(*unread, *said.unread),
    )


def _uncut(
    motors: Collection[str], independent: Mapping[str, bool], gears: Iterable[JointLoop]
) -> set[str]:
    """Return the joints that loops are not to be cut at: motors, and such as are geared."""
    geared = {name for gear in gears for name in gear.joints}
    return {*motors, *(name for name, given in independent.items() if given), *geared}


def _checked(robot: Element) -> tuple[list[Element], Collection[str], tuple[str, ...]]:
    """Return a robot's joints, names of its links, and what nobody reads."""
    links, elements = robot.findall("link"), robot.findall("joint")
    check_size(links, elements)
    names = checked_names(links)
    checked_names(elements)
    unread = _unread(robot)
    refuse_unreadable(robot)
    return elements, names, unread


def _followers(said: Said, independent: Mapping[str, bool]) -> set[str]:
    """Return the joints that follow others."""
    led = {follower(gear, independent) for gear in said.couplings}
    return led | {gear.joints[1] for gear in said.mimics}


def _unread(robot: Element) -> tuple[str, ...]:
    """Return what of a robot nobody reads, once no word in it looks misspelt."""
    joints = robot.findall(GAZEBO_JOINTS)
    held = [plugin for plugin in robot.iterfind(PLUGINS) if is_detachable(plugin, robot)]
    inside = [note for joint in joints for note in SDF_WORDS.unread(joint)]
    return (*unread_words(robot, *joints, *held), *inside)


def _declared(
    robot: Element, links: Collection[str], cut: CutJoints, joined: Collection[str]
) -> tuple[list[Element], list[str]]:
    """Take all that declares loops out of a robot; return it as URDF+ writes it, and notes."""
    declared = take_loops(robot)
    closing, notes = closing_frames(links, declared, joined)
    if robot.find("gazebo") is not None:
        gazebo, gazebo_notes = take_gazebo_joints(robot, cut.placements())
        return [*declared, *gazebo, *closing], [*gazebo_notes, *notes]
    return [*declared, *closing], notes


def _actuated(
    tree: Sequence[UrdfJoint], independent: Mapping[str, bool], followers: Collection[str]
) -> tuple[str, ...]:
    """Return the independent joints, once one joint says whether it is: true is the default."""
    if not independent:
        return ()
    single = [joint.name for joint in tree if VELOCITIES[joint.type] == 1]
    return tuple(name for name in single if name not in followers and independent.get(name, True))


def _closing_notes(closings: Sequence[ClosingElement], tree: Sequence[UrdfJoint]) -> list[str]:
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
