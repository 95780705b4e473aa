"""Cutting a graph of links and joints into a tree and loops, always at the same joints.

The rule, in the order of the file:

1. A joint stays in the tree, from its parent to its child, if no earlier joint has that child
   and if it closes no cycle. So of several joints with one child the first keeps it.
2. What is left over: a joint that joins two parts which nothing joins so far stays in the tree
   all the same, turned round where it has to be.
3. All others are cut.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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
    links: Sequence[str], joints: Sequence[tuple[str, str]], root: str | None = None
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

    Examples
    --------
    A four-bar whose coupler is the child of two joints:

    >>> tree = spanning_tree("abcd", [("a", "b"), ("a", "d"), ("b", "c"), ("d", "c")])
    >>> tree.root, tree.cut, [branch.below for branch in tree.branches]
    ('a', (3,), ['b', 'd', 'c'])
    """
    children = {child for _, child in joints}
    if root is None:
        root = next((link for link in links if link not in children), links[0])
    kept = _kept(links, joints, root)
    branches = _from_root(joints, kept, root)
    reached = {root, *(branch.below for branch in branches)}
    return SpanningTree(
        root=root,
        branches=branches,
        cut=tuple(k for k in range(len(joints)) if k not in kept and joints[k][1] in reached),
        apart=tuple(link for link in links if link not in reached),
    )


def _kept(links: Iterable[str], joints: Sequence[tuple[str, str]], root: str) -> set[int]:
    """Return the joints of the tree: rule 1, then rule 2."""
    parts = _Parts(links)
    kept, taken = set(), {root}
    for number, (parent, child) in enumerate(joints):
        if child not in taken and parts.merge(parent, child):
            taken.add(child)
            kept.add(number)
    kept.update(number for number, ends in enumerate(joints) if parts.merge(*ends))
    return kept


def _from_root(joints: Sequence[tuple[str, str]], kept: set[int], root: str) -> tuple[Branch, ...]:
    """Return the kept joints that the root reaches, each seen from there, nearest first."""
    at: dict[str, list[int]] = {}
    for number in sorted(kept):
        for link in joints[number]:
            at.setdefault(link, []).append(number)
    branches: list[Branch] = []
    seen, level = {root}, [root]
    while level:
        above = level.pop(0)
        for number in at.get(above, ()):
            parent, child = joints[number]
            below = child if parent == above else parent
            if below not in seen:
                seen.add(below)
                level.append(below)
                branches.append(Branch(number, above, below, turned=below == parent))
    return tuple(branches)


class _Parts:
    """Links in parts that grow together (union-find)."""

    def __init__(self, links: Iterable[str]) -> None:
        self._up = {link: link for link in links}

    def merge(self, one: str, other: str) -> bool:
        """Make one part of the two links' parts; False if they are in one already."""
        one, other = self._top(one), self._top(other)
        self._up[other] = one
        return one != other

    def _top(self, link: str) -> str:
        while self._up[link] != link:
            self._up[link] = self._up[self._up[link]]
            link = self._up[link]
        return link
