"""Extended URDF: a URDF and a YAML file beside it, as published by LAAS-CNRS.

The YAML file tells which frames coincide, which joints are motors, and which joints of the URDF
are balls, universal joints or welds in truth.

Reference: V. Batto, L. De Matteis, N. Mansard, "Extended URDF: Accounting for parallel mechanism
in robot description", 2025; the repository Gepetto/example-parallel-robots.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from pmjac_pin.errors import ModelFileError, did_you_mean
from pmjac_pin.files.foreign_model import ForeignModel
from pmjac_pin.files.joint_dialects import WITHOUT_LIMIT, listed
from pmjac_pin.files.text_file import at_file, read_text
from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.files.urdf.checks import check_size, checked_names
from pmjac_pin.files.urdf.closure_yaml import ClosureFile, read_closure_yaml
from pmjac_pin.files.urdf.looped_urdf import read_robot
from pmjac_pin.files.urdf.robot import MAXIMAL_URDF
from pmjac_pin.files.user_path import is_file
from pmjac_pin.files.xml_text import parse_xml, written
from pmjac_pin.model.loop_spec import FrameLoop, Loop, PointLoop

_AXIS_VECTORS: Mapping[str, str] = {"X": "1 0 0", "Y": "0 1 0", "Z": "0 0 1"}
_CLOSURES: Mapping[str, type[PointLoop | FrameLoop]] = {"point": PointLoop, "frame": FrameLoop}
_DEFAULT_STEM = "robot"


def closure_yaml_beside(path: Path) -> Path | None:
    """Return the YAML file that makes a URDF an extended one: of its name, or robot.yaml."""
    for beside in (path.with_suffix(".yaml"), path.with_name(f"{_DEFAULT_STEM}.yaml")):
        if is_file(beside):
            return beside
    return None


def read_extended_urdf(path: Path, motors: Collection[str] = ()) -> ForeignModel:
    """Read a URDF with the YAML file beside it.

    Loops join the frames that the file names: a link's, or that of the link that a joint of
    this name moves. Motors are all joints whose name contains an entry of `name_mot`.

    Parameters
    ----------
    path : Path
        The URDF; `closure_yaml_beside` finds the other one.
    motors : collection of str, optional
        Joints that are not to be cut, beside those of the file.

    Raises
    ------
    ModelFileError
        The message starts with the path of the file at fault.
    """
    if (beside := closure_yaml_beside(path)) is None:
        raise ModelFileError(f"{path}: there is no robot.yaml beside it", path=str(path))
    closures, unused_keys = read_closure_yaml(beside)
    with at_file(str(path)):
        robot = parse_xml(read_text(path, MAXIMAL_URDF))
        links, joints = robot.findall("link"), robot.findall("joint")
        check_size(links, joints)
        checked_names(joints)
        own = tuple(checked_names(links))
        carriers = _carriers(joints, own)
    with at_file(str(beside)):
        loops = _closure_loops(closures, carriers)
        replaced = _replace_joints(robot, closures.replacements())
        moving = [joint for joint in robot.iterfind("joint") if joint.get("type") != "fixed"]
        named = _named_motors(closures.name_mot, [joint.get("name", "") for joint in moving])
        if closures.floats():
            _float_base(robot)
    with at_file(str(path)):
        joined = [name for loop in loops for name in loop.ends]
        added = {link.get("name", "") for link in robot.iterfind("link")} - set(own)
        model = read_robot(robot, path, {*motors, *named}, joined=joined, added=added)
    return replace(
        model,
        name=path.parent.absolute().name if path.stem == _DEFAULT_STEM else path.stem,
        loops=(*loops, *model.loops),
        actuated=named,
        notes=(
            *model.notes,
            *replaced,
            *(f"{beside.name}: {key!r} is not used" for key in unused_keys if _of_rotors(key)),
        ),
        unread=(
            *model.unread,
            *(f"not read: {key!r} of {beside.name}" for key in unused_keys if not _of_rotors(key)),
        ),
    )


def _of_rotors(key: str) -> bool:
    """Whether a key that is not used tells of rotors, which have no bearing on kinematics."""
    return "rotor" in str(key)


def _carriers(joints: Sequence[Element], links: Sequence[str]) -> dict[str, str]:
    """Return the link that each frame is of: a link's own, and a joint's child."""
    carriers = {}
    for joint in joints:
        child = joint.find("child")
        link = "" if child is None else child.get("link", "")
        if link in links:
            carriers[joint.get("name", "")] = link
    return {**carriers, **{link: link for link in links}}


def _closure_loops(closures: ClosureFile, carriers: Mapping[str, str]) -> list[Loop]:
    loops: list[Loop] = []
    for pair, kind in zip(closures.closed_loop, closures.kinds(), strict=True):
        for name in pair:
            if name not in carriers:
                hint = did_you_mean(name, carriers)
                raise ModelFileError(f"`closed_loop`: unknown frame {name[:60]!r}{hint}")
        first, second = (carriers[name] for name in pair)
        if first == second:
            both = f"the frames {pair[0]!r} and {pair[1]!r}"
            raise ModelFileError(f"`closed_loop`: {both} are one, of link {first!r}")
        loops.append(_CLOSURES[kind](frames=(first, second)))
    return loops


def _named_motors(parts: Sequence[str], joints: Sequence[str]) -> tuple[str, ...]:
    """Return the joints whose name contains one of these, in the order of the parts."""
    found: dict[str, None] = {}
    for part in parts:
        named = [name for name in joints if part and part in name]
        if not named:
            hint = did_you_mean(part, joints)
            raise ModelFileError(f"`name_mot`: no joint that moves is named {part[:60]!r}{hint}")
        given = [name for name in named if name not in parts]
        found.update(dict.fromkeys([part] if part in named else given))
    others = (name for name in joints if name not in found and any(part in name for part in parts))
    return (*found, *others)


def _replace_joints(robot: Element, replacements: Mapping[str, str]) -> list[str]:
    """Make each joint what the file says it is; return a note for each kind."""
    joints = {joint.get("name", ""): joint for joint in robot.iterfind("joint")}
    done: dict[str, list[str]] = {}
    for name, kind in replacements.items():
        if name not in joints:
            raise ModelFileError(
                f"`joint_name`: unknown joint {name[:60]!r}{did_you_mean(name, joints)}"
            )
        joint = joints[name]
        for tag in ("axis", "limit", "dynamics", "mimic"):
            for element in joint.findall(tag):
                joint.remove(element)
        if universal := re.fullmatch("UJOINT_([XYZ])([XYZ])", kind):
            _replace_by_two(robot, joint, universal[1], universal[2])
        elif kind in ("SPHERICAL", "FIXED"):
            joint.set("type", kind.lower())
        else:
            raise ModelFileError(
                f"`joint_type`: unknown {kind[:60]!r}; SPHERICAL, FIXED and UJOINT_XY, ... are read"
            )
        done.setdefault(kind, []).append(name)
    return [f"{kind} instead of the URDF's joint: {listed(names)}" for kind, names in done.items()]


def _replace_by_two(robot: Element, joint: Element, first: str, second: str) -> None:
    """Make a universal joint of two hinges, about axes of the joint's own frame, on a cross."""
    if first == second:
        raise ModelFileError(f"`joint_type`: UJOINT_{first}{second} has twice the same axis")
    name, position = joint.get("name", ""), list(robot).index(joint)
    links = {link.get("name", "") for link in robot.iterfind("link")}
    cross = unused_name(f"{name}_cross", links)
    SubElement(robot, "link", name=cross)
    following = Element("joint", name=f"{name}_{second}")
    robot.insert(position + 1, following)
    child = joint.findall("child")
    for element in child:
        joint.remove(element)
    joint.set("name", f"{name}_{first}")
    SubElement(joint, "child", link=cross)
    SubElement(following, "parent", link=cross)
    following.extend(child)
    limits = {"lower": written([-WITHOUT_LIMIT]), "upper": written([WITHOUT_LIMIT])}
    for hinge, axis in ((joint, first), (following, second)):
        hinge.set("type", "revolute")
        SubElement(hinge, "axis", xyz=_AXIS_VECTORS[axis])
        SubElement(hinge, "limit", limits, effort="0", velocity="0")


def _float_base(robot: Element) -> None:
    """Hang the base, the link that no joint leads to, on a floating joint."""
    links = [link.get("name", "") for link in robot.iterfind("link")]
    led_to = {child.get("link") for child in robot.iterfind("joint/child")}
    bases = [link for link in links if link not in led_to]
    if len(bases) != 1:
        raise ModelFileError(f"`free_flyer` needs one base, the URDF has {len(bases)}")
    world = unused_name("world", set(links))
    joints = {joint.get("name", "") for joint in robot.iterfind("joint")}
    robot.insert(0, Element("link", name=world))
    floating = SubElement(robot, "joint", name=unused_name("free_flyer", joints), type="floating")
    SubElement(floating, "parent", link=world)
    SubElement(floating, "child", link=bases[0])
