"""The URDF of a model file with what the standard has no word for: gears and ball joints.

Gears are <coupling>, and <mimic> in all ways.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.gazebo_plugins import is_mimic_plugin, misread_mimics, unread_harmless
from pmjac_pin.files.joint_dialects import floating_balls
from pmjac_pin.files.text_file import at_file, read_text
from pmjac_pin.files.unread_springs import spring_notes, sprung_joints
from pmjac_pin.files.urdf.control_mimics import doubtful
from pmjac_pin.files.urdf.couplings import take_couplings
from pmjac_pin.files.urdf.loop_elements import idle_mimics, read_gears
from pmjac_pin.files.urdf.robot import MAXIMAL_URDF, Urdf
from pmjac_pin.files.urdf.ties import PLUGINS, take_mimics
from pmjac_pin.files.urdf.vocabulary import URDF_WORDS
from pmjac_pin.files.xml_text import parse_xml
from pmjac_pin.model.loop_spec import JointLoop, Loop

_SAME_RATIO = 1e-12  # relative: a ratio and its inverse, both as decimals


@dataclass(frozen=True)
class GearedUrdf:
    """A URDF, with the gears and the ball joints that it declared.

    Attributes
    ----------
    urdf : Urdf
        Without gears; its ball joints are floating.
    gears : tuple of JointLoop
    spherical : tuple of str
        The names of the ball joints.
    notes : tuple of str
        One sentence for each decision that was taken.
    """

    urdf: Urdf
    gears: tuple[JointLoop, ...]
    spherical: tuple[str, ...]
    notes: tuple[str, ...]


def read_geared_urdf(path: Path) -> GearedUrdf:
    """Read and check a URDF file of at most 20 MB, whose joints may follow each other.

    Raises
    ------
    ModelFileError
        The message starts with the file's path and names the element at fault.
    """
    with at_file(str(path)):
        robot = parse_xml(read_text(path, MAXIMAL_URDF))
        unread, joints = _unread_gears(robot), robot.findall("joint")
        take_mimics(robot, joints)
        followers = [joint.get("name", "") for joint in joints if joint.find("mimic") is not None]
        notes, balls = idle_mimics(joints), floating_balls(joints)
        notes += spring_notes(sprung_joints(robot))
        gears = (*read_gears(joints), *take_couplings(robot, joints))
        urdf = Urdf.of(robot, str(path), (*unread, *doubtful(robot, followers)))
    return GearedUrdf(urdf, gears, tuple(balls), tuple(notes))


def _unread_gears(robot: Element) -> tuple[str, ...]:
    plugins = filter(is_mimic_plugin, robot.iterfind(PLUGINS))
    skipped = (*plugins, *unread_harmless(robot))
    return (*URDF_WORDS.unread(robot, *skipped), *misread_mimics(robot))


def with_gears(loops: Sequence[Loop], gears: Sequence[JointLoop]) -> tuple[Loop, ...]:
    """Return a model file's loops with those gears of its URDF that it does not state itself.

    Raises
    ------
    ModelFileError
        It gears the same two joints otherwise.

    Examples
    --------
    >>> stated = JointLoop(joints=("b", "a"), ratio=0.5, offset=-1.0)
    >>> with_gears([stated], [JointLoop(joints=("a", "b"), ratio=2.0, offset=2.0)]) == (stated,)
    True
    """
    stated = [loop for loop in loops if isinstance(loop, JointLoop)]
    return (*loops, *(gear for gear in gears if not _is_stated(gear, stated)))


def _is_stated(gear: JointLoop, stated: Sequence[JointLoop]) -> bool:
    """Whether a model file states a gear, from whichever side."""
    same_pair = [loop for loop in stated if set(loop.joints) == set(gear.joints)]
    for loop in same_pair:
        if not _same_equation(loop, gear):
            leader, follower = gear.joints
            raise ModelFileError(
                f"joint {follower!r} follows {leader!r} otherwise by its URDF "
                f"({_gear_words(gear)}) than by the [[loop]] of the model file "
                f"({_gear_words(loop)}); change one of them"
            )
    return bool(same_pair)


def _same_equation(loop: JointLoop, gear: JointLoop) -> bool:
    if loop.joints == gear.joints:
        pairs = ((loop.ratio, gear.ratio), (loop.offset, gear.offset))
    else:  # q_a = r·q_b + o and q_b = s·q_a + p
        pairs = ((loop.ratio * gear.ratio, 1.0), (loop.ratio * gear.offset, -loop.offset))
    return all(math.isclose(one, other, rel_tol=_SAME_RATIO) for one, other in pairs)


def _gear_words(gear: JointLoop) -> str:
    leader, follower = gear.joints
    return f"{follower} = {gear.ratio!r} {leader} + {gear.offset!r}"
