"""The joints of a URDF, which have to make one tree of its links."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from pmjac_pin.errors import ModelFileError

MAXIMAL_DEPTH = 150  # joints in a row: Pinocchio recurses, and 250 overflow a stack of 512 kB
_CUT_THE_LOOP = "cut the loop: remove one of them and declare it as [[loop]] in the model file"


@dataclass(frozen=True)
class UrdfJoint:
    """A joint as the URDF declares it: its name, type, parent link and child link."""

    name: str
    type: str
    parent: str
    child: str


def joints_of(robot: Element) -> tuple[UrdfJoint, ...]:
    """Return the joints of a checked robot in file order."""
    return tuple(
        UrdfJoint(
            name=joint.get("name", ""),
            type=joint.get("type", ""),
            parent=joint.find("parent").get("link", ""),  # type: ignore[union-attr]
            child=joint.find("child").get("link", ""),  # type: ignore[union-attr]
        )
        for joint in robot.iterfind("joint")
    )


def check_tree(links: Collection[str], joints: Sequence[UrdfJoint]) -> None:
    """Refuse all but one tree of links, and one too deep for Pinocchio's recursion."""
    above: dict[str, UrdfJoint] = {}
    below: dict[str, list[str]] = {}
    for joint in joints:
        if (other := above.setdefault(joint.child, joint)) is not joint:
            both = f"two joints, {other.name!r} and {joint.name!r}"
            raise ModelFileError(f"link {joint.child!r} is the child of {both}; {_CUT_THE_LOOP}")
        below.setdefault(joint.parent, []).append(joint.child)
    level = roots = [link for link in links if link not in above]
    rest = set(links)
    for _ in range(MAXIMAL_DEPTH + 1):
        rest.difference_update(level)
        level = [child for link in level for child in below.get(link, ())]
    if level:
        raise ModelFileError(f"a chain of more than {MAXIMAL_DEPTH} joints is too long to be read")
    if rest:
        cycle = ", ".join(map(repr, _cycle(above, min(rest))))
        raise ModelFileError(f"a cycle of joints: {cycle}; {_CUT_THE_LOOP}")
    if len(roots) > 1:
        some = ", ".join(map(repr, roots[:5])) + (", ..." if len(roots) > 5 else "")
        todo = "join them by joints, fixed ones if need be"
        raise ModelFileError(f"{len(roots)} links are no joint's child: {some}; {todo}")


def _cycle(above: Mapping[str, UrdfJoint], link: str) -> list[str]:
    """Return the joints of the cycle above a link that no root reaches, from parent to child."""
    for _ in above:
        link = above[link].parent
    cycle = [above[link]]
    while cycle[-1].parent != link:
        cycle.append(above[cycle[-1].parent])
    return [joint.name for joint in reversed(cycle)]
