"""Which joints of a graph with loops stay in the tree, and which are cut."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from pmjac_pin.urdf_checks import UrdfJoint


def cut_joints(
    links: Sequence[str], joints: Sequence[UrdfJoint], motors: Collection[str] = ()
) -> tuple[UrdfJoint, ...]:
    """Return the joints that close loops, in file order.

    A link keeps the first joint that leads to it, motors before the others and then in file
    order, unless links could then not be reached from the base any more. The base is the link
    that no joint leads to; the file's first, where a cycle leads to each.

    Parameters
    ----------
    links : sequence of str
        In file order.
    joints : sequence of UrdfJoint
        In file order.
    motors : collection of str
        Joints that are cut last.

    Examples
    --------
    >>> names = {"a": "AB", "b": "BC", "c": "AC"}
    >>> joints = [UrdfJoint(name, "revolute", *ends) for name, ends in names.items()]
    >>> [joint.name for joint in cut_joints("ABC", joints)]
    ['c']
    >>> [joint.name for joint in cut_joints("ABC", joints, motors="c")]
    ['b']
    """
    leading: dict[str, list[UrdfJoint]] = {}
    for joint in sorted(joints, key=lambda joint: joint.name not in motors):
        leading.setdefault(joint.child, []).append(joint)
    bases = [link for link in links if link not in leading] or list(links[:1])
    for base in bases:
        leading.pop(base, None)
    reached = _reached(bases, leading)
    for link, candidates in leading.items():
        for joint in candidates if len(candidates) > 1 else ():
            leading[link] = [joint]
            if _reached(bases, leading) == reached:
                break
            # Without this joint the others still reach what they did with it.
            leading[link] = candidates
    kept = {candidates[0].name for candidates in leading.values()}
    return tuple(joint for joint in joints if joint.name not in kept)


def _reached(bases: Sequence[str], leading: dict[str, list[UrdfJoint]]) -> set[str]:
    """Return the links that a path of joints leads to."""
    below: dict[str, list[str]] = {}
    for link, candidates in leading.items():
        for joint in candidates:
            below.setdefault(joint.parent, []).append(link)
    reached, waiting = set(bases), list(bases)
    while waiting:
        for link in below.get(waiting.pop(), ()):
            if link not in reached:
                reached.add(link)
                waiting.append(link)
    return reached
