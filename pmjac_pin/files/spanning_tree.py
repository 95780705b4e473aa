"""Cutting a graph of links and joints into a tree and loops, always at the same joints.

The rule, where `first` joints come before the others, and each in the order of the file:

1. A link that directed joints lead to from the root keeps the first joint that leads to it,
   unless other links could then not be reached any more.
2. What is left over, such as a platform that is the parent of all its joints, is taken joint by
   joint as it comes within reach; a joint is turned round only where none leads there forwards.
3. All other joints are cut.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Branch:
    """A joint of the tree.

    Attributes
    ----------
    joint : int
        Its place in the sequence that was given.
    above, below : str
        The link nearer to the root, and the link that the joint carries.
    turned : bool
        The joint's parent is `below`: it moves its parent against its child.
    """

    joint: int
    above: str
    below: str
    turned: bool


@dataclass(frozen=True)
class SpanningTree:
    """What `spanning_tree` found.

    Attributes
    ----------
    root : str
    branches : tuple of Branch
        From the root outwards: the link above each is the root or below an earlier one.
    cut : tuple of int
        The joints that close loops, by their place in the sequence, in its order.
    apart : tuple of str
        Links that no chain of joints joins to the root.
    """

    root: str
    branches: tuple[Branch, ...]
    cut: tuple[int, ...]
    apart: tuple[str, ...]


def spanning_tree(
    links: Sequence[str],
    joints: Sequence[tuple[str, str]],
    root: str | None = None,
    first: Collection[int] = (),
) -> SpanningTree:
    """Choose which joints of a graph make a tree; the others close loops.

    Parameters
    ----------
    links : sequence of str
    joints : sequence of (str, str)
        The parent and the child of each joint, in the order of the file; both are in `links`.
    root : str, optional
        The link that is held; when None the first link that is no joint's child, or the first
        link of all where every one is.
    first : collection of int, optional
        Joints, by their place in the sequence, that are cut last: motors.

    Examples
    --------
    A four-bar whose coupler is the child of two joints:

    >>> joints = [("a", "b"), ("a", "d"), ("b", "c"), ("d", "c")]
    >>> spanning_tree("abcd", joints).cut
    (3,)
    >>> spanning_tree("abcd", joints, first=[3]).cut
    (2,)
    """
    if root is None:
        children = {child for _, child in joints}
        root = next((link for link in links if link not in children), links[0])
    order = sorted(range(len(joints)), key=lambda number: number not in first)
    above = _leading(joints, order, root)
    kept = {candidates[0] for candidates in above.values()}
    kept |= set(_joined({root, *above}, joints, order))
    branches = tuple(_from_root(joints, kept, root))
    reached = {root, *(branch.below for branch in branches)}
    return SpanningTree(
        root=root,
        branches=branches,
        cut=tuple(k for k, (parent, _) in enumerate(joints) if k not in kept and parent in reached),
        apart=tuple(link for link in links if link not in reached),
    )


def _leading(
    joints: Sequence[tuple[str, str]], order: Sequence[int], root: str
) -> dict[str, list[int]]:
    """Return the one joint that leads to each link that joints lead to from the root: rule 1."""
    above: dict[str, list[int]] = {}
    for number in order:
        above.setdefault(joints[number][1], []).append(number)
    above.pop(root, None)
    reached = _led_to(joints, above, root)
    above = {link: candidates for link, candidates in above.items() if link in reached}
    for link, candidates in above.items():
        if len(candidates) > 1:
            above[link] = [
                next(
                    number
                    for number in candidates
                    if len(_led_to(joints, {**above, link: [number]}, root)) == len(reached)
                )
            ]
    return above


def _led_to(
    joints: Sequence[tuple[str, str]], above: Mapping[str, Sequence[int]], root: str
) -> set[str]:
    below: dict[str, list[str]] = {}
    for link, candidates in above.items():
        for number in candidates:
            below.setdefault(joints[number][0], []).append(link)
    found, waiting = {root}, [root]
    while waiting:
        new = [link for link in below.get(waiting.pop(), ()) if link not in found]
        found.update(new)
        waiting += new
    return found


def _joined(
    reached: set[str], joints: Sequence[tuple[str, str]], order: Sequence[int]
) -> Iterator[int]:
    """Yield the joints that join what is not reached yet to what is: rule 2."""
    reached = set(reached)
    while True:
        ends = [(number, joints[number]) for number in order]
        forwards = (k for k, (one, other) in ends if one in reached and other not in reached)
        backwards = (k for k, (one, other) in ends if other in reached and one not in reached)
        number = next(forwards, next(backwards, None))
        if number is None:
            return
        reached.update(joints[number])
        yield number


def _from_root(
    joints: Sequence[tuple[str, str]], kept: Collection[int], root: str
) -> Iterator[Branch]:
    """Yield the kept joints, each seen from the root, nearest first."""
    at: dict[str, list[int]] = {}
    for number in sorted(kept):
        for link in joints[number]:
            at.setdefault(link, []).append(number)
    seen, level = {root}, [root]
    while level:
        above = level.pop(0)
        for number in at.get(above, ()):
            parent, child = joints[number]
            below = child if parent == above else parent
            if below not in seen:
                seen.add(below)
                level.append(below)
                yield Branch(number, above, below, turned=below == parent)
