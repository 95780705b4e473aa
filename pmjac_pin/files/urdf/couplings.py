"""URDF+'s <coupling>: a transmission that ties the turns of two links.

With the angles of the links as seen from the last link that carries both, it says
angle of the successor = ratio · angle of the predecessor. Both are counted along the axes of
their own joints, so that a ratio above zero of equal axes turns both the same way.

Reference: M. Chignoli et al., "URDF+: An Enhanced URDF for Robots with Kinematic Loops", 2024, and
its implementation, ROAM-Lab-ND/generalized_rbda, `ClusterTreeParsing.cpp`: of the row of
constraints the predecessor's entry is the ratio, the successor's −1.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError
from pmjac_pin.files.joint_dialects import listed
from pmjac_pin.files.urdf.checks import VELOCITIES, checked_end
from pmjac_pin.files.urdf.joint_tree import MAXIMAL_DEPTH
from pmjac_pin.files.xml_text import label, numbers, only
from pmjac_pin.model.loop_spec import JointLoop

TAG = "coupling"
_COUPLING_ENDS = ("predecessor", "successor")


def take_couplings(robot: Element, joints: Sequence[Element]) -> tuple[JointLoop, ...]:
    """Take the <coupling> elements out of a robot; return them as gears.

    Parameters
    ----------
    robot : Element
    joints : sequence of Element
        Its joints, all of them.

    Raises
    ------
    ModelFileError
        One that does not tie the values of two joints.
    """
    couplings = robot.findall(TAG)
    if not couplings:
        return ()
    links = [link.get("name", "") for link in robot.iterfind("link")]
    gears = [_coupling_loop(coupling, joints, links) for coupling in couplings]
    for coupling in couplings:
        robot.remove(coupling)
    return tuple(gears)


def follower(gear: JointLoop, independent: Mapping[str, bool]) -> str:
    """Return which of two joints that a coupling ties follows the other.

    Independent is the one that says so, then the one that says nothing; of two alike the first.

    Parameters
    ----------
    gear : JointLoop
    independent : mapping of str to bool
        What the file says of its joints.
    """
    first, second = gear.joints
    says = [(independent.get(name, True), name in independent) for name in gear.joints]
    return first if says[1] > says[0] and gear.ratio else second


def _coupling_loop(
    coupling: Element, joints: Sequence[Element], links: Collection[str]
) -> JointLoop:
    where = label(coupling)
    ends = [checked_end(where, coupling, tag, links) for tag in _COUPLING_ENDS]
    chains = [_joints_to_base(where, joints, end) for end in ends]
    shared = {id(joint) for joint in chains[0]} & {id(joint) for joint in chains[1]}
    first, second = (
        _only_joint(where, end, [joint for joint in chain if id(joint) not in shared])
        for end, chain in zip(ends, chains, strict=True)
    )
    element = only(where, coupling, "ratio")
    default = "1" if element is None else None
    (ratio,) = numbers(f"{where}, <ratio>", element, "value", default=default)
    return JointLoop(joints=(first, second), ratio=ratio)


def _joints_to_base(where: str, joints: Sequence[Element], link: str) -> list[Element]:
    """Return the joints from a link up to the base."""
    above: dict[str, list[Element]] = {}
    for joint in joints:
        if (child := joint.find("child")) is not None:
            above.setdefault(child.get("link", ""), []).append(joint)
    chain: list[Element] = []
    while (found := above.get(link)) is not None:
        if len(found) > 1 or len(chain) > MAXIMAL_DEPTH:
            got = "no tree of joints tells its angle"
            raise ModelFileError(f"{where}: link {link!r} is in a loop of joints, and {got}")
        chain += found
        parent = found[0].find("parent")
        link = "" if parent is None else parent.get("link", "")
    return chain


def _only_joint(where: str, link: str, chain: Sequence[Element]) -> str:
    """Return the joint that tells a link's angle, as seen from what carries both links."""
    moving = [joint for joint in chain if joint.get("type") != "fixed"]
    names = [joint.get("name", "") for joint in moving]
    if not moving:
        raise ModelFileError(f"{where}: nothing turns link {link!r} against the other link")
    if len(moving) > 1:
        got = f"the angle of link {link!r} is the sum of {listed(names[::-1])}"
        todo = "make the other link's joint several in a row, and let each follow one by <mimic>"
        raise ModelFileError(f"{where}: {got}; two joints are geared by one. Instead, {todo}")
    if VELOCITIES.get(moving[0].get("type", "")) != 1:
        raise ModelFileError(f"{where}: joint {names[0]!r} has more than one degree of freedom")
    return names[0]
