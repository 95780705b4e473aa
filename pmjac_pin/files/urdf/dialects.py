"""Dialects of URDF: what files say of joints beyond the standard, each with what reads it.

A file enters the readers of what it holds, and no others.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, TypeAlias
from xml.etree.ElementTree import Element

from pmjac_pin.files.gazebo_plugins import is_mimic_plugin, misread_mimics, unread_harmless
from pmjac_pin.files.joint_dialects import BALL_TYPES, floating_balls
from pmjac_pin.files.text_file import at_file, read_text
from pmjac_pin.files.unread_springs import spring_notes, sprung_joints
from pmjac_pin.files.urdf.control_mimics import CONTROL_JOINTS, doubtful
from pmjac_pin.files.urdf.couplings import take_couplings
from pmjac_pin.files.urdf.loop_elements import idle_mimics, read_gears
from pmjac_pin.files.urdf.robot import MAXIMAL_URDF, Urdf
from pmjac_pin.files.urdf.rotors import rotors
from pmjac_pin.files.urdf.ties import PLUGINS, take_control_mimics, take_plugin_mimics
from pmjac_pin.files.urdf.vocabulary import URDF_WORDS
from pmjac_pin.files.xml_text import parse_xml
from pmjac_pin.model.loop_spec import JointLoop


@dataclass
class Said:
    """What a <robot> says of its joints beyond the standard.

    Attributes
    ----------
    mimics, couplings : list of JointLoop
        Gears: by <mimic>, wherever it stands, and by <coupling>.
    followers : list of str
        Joints with a <mimic>.
    balls : list of str
        Ball joints, which are floating ones now.
    armature : dict of str to float
        As in `MechanismSpec`.
    notes, unread : list of str
        One sentence for each decision, and for each kind of thing that nobody reads.
    """

    mimics: list[JointLoop] = field(default_factory=list)
    couplings: list[JointLoop] = field(default_factory=list)
    followers: list[str] = field(default_factory=list)
    balls: list[str] = field(default_factory=list)
    armature: dict[str, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    unread: list[str] = field(default_factory=list)


Reader: TypeAlias = Callable[[Element, Said], None]


def _mimics(robot: Element, said: Said) -> None:
    joints = robot.findall("joint")
    said.followers += [joint.get("name", "") for joint in robot.iterfind("joint[mimic]")]
    said.notes += idle_mimics(joints)
    said.mimics += read_gears(joints)


def _couplings(robot: Element, said: Said) -> None:
    said.couplings += take_couplings(robot, robot.findall("joint"))


def _ball_joints(robot: Element, said: Said) -> None:
    said.balls += floating_balls(robot.findall("joint"))


def _springs(robot: Element, said: Said) -> None:
    said.notes += spring_notes(sprung_joints(robot))


def _rotors(robot: Element, said: Said) -> None:
    said.armature |= rotors(robot)


def _doubts(robot: Element, said: Said) -> None:
    said.unread += doubtful(robot, said.followers)


#: What asks for a reader, by the paths to it: each is entered in this order, where one leads
#: somewhere. What it takes out of the robot, or puts into it, those behind it see.
DIALECTS: tuple[tuple[tuple[str, ...], Reader], ...] = (
    ((PLUGINS,), lambda robot, _: take_plugin_mimics(robot)),
    ((CONTROL_JOINTS,), lambda robot, _: take_control_mimics(robot)),
    (("joint/mimic",), _mimics),
    (("coupling",), _couplings),
    (tuple(f"joint[@type='{kind}']" for kind in BALL_TYPES), _ball_joints),
    (("joint//dynamics", "gazebo/springStiffness"), _springs),
    (("joint/dynamics", ".//{*}rotor_inertia", ".//{*}gear_ratio"), _rotors),
    ((CONTROL_JOINTS,), _doubts),
)


def take_said(robot: Element) -> Said:
    """Take what the standard has no word for out of a <robot>; return it.

    Raises
    ------
    ModelFileError
        The message names the element at fault.
    """
    said = Said()
    for paths, read in DIALECTS:
        if any(robot.find(path) is not None for path in paths):
            read(robot, said)
    return said


def unread_words(robot: Element, *read: Element) -> tuple[str, ...]:
    """Return what of a <robot> nobody reads, once no word in it looks misspelt.

    Parameters
    ----------
    robot : Element
    *read : Element
        What is read though URDF's words do not know it, beside plugins that tie joints.
    """
    if next(robot.iter("plugin"), None) is None:
        return URDF_WORDS.unread(robot, *read)
    plugins = (*filter(is_mimic_plugin, robot.iterfind(PLUGINS)), *unread_harmless(robot))
    return (*URDF_WORDS.unread(robot, *read, *plugins), *misread_mimics(robot))


class CutTree(NamedTuple):
    """The URDF of a model file, which has no loops, and what it says beyond the standard."""

    urdf: Urdf
    said: Said


def read_cut_tree(path: Path) -> CutTree:
    """Read and check a URDF file of at most 20 MB, whose joints may follow each other.

    Raises
    ------
    ModelFileError
        The message starts with the file's path and names the element at fault.
    """
    with at_file(str(path)):
        robot = parse_xml(read_text(path, MAXIMAL_URDF))
        unread = unread_words(robot)
        said = take_said(robot)
        return CutTree(Urdf.of(robot, str(path), (*unread, *said.unread)), said)
