"""The poses of a tree over boxes of joint values, with derivatives that ride along.

No derivative is a difference of two poses, which would be much wider than itself.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from pmjac_pin.algebra import Number
from pmjac_pin.algebra.boxes import BOXES
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.model.joint_kind import JointMotion, Waves


class IntervalTree:
    """The joints of a tree that boxes speak of, and those whose values are given.

    Parameters
    ----------
    tree : Tree
    unknowns : sequence of str
        Joints of one degree of freedom: the columns of a box.
    given : mapping of str to float
        The other joints' values, m or rad.

    Attributes
    ----------
    given : mapping of str to float
    unknowns : tuple of str
    tree : Tree
    columns : tuple of int
        The unknowns' columns of v.
    """

    __slots__ = ("_places", "columns", "given", "tree", "unknowns")

    def __init__(self, tree: Tree, unknowns: Sequence[str], given: Mapping[str, float]) -> None:
        self.tree = tree
        self.unknowns, self.given = tuple(unknowns), given
        self._places = {name: place for place, name in enumerate(unknowns)}
        columns = {link.edge.name: link.column for link in self.tree.links.values()}
        self.columns = tuple(columns[name] for name in unknowns)

    def poses(self, box: Intervals, rates: bool) -> Poses:
        """Return the poses over boxes (b, k) of the unknowns' values, m or rad."""

        def value(name: str) -> Intervals:
            place = self._places.get(name)
            return BOXES.constant(self.given[name]) if place is None else box[None, :, place]

        return self.at(BOXES, value, rates)

    def at(self, algebra: Waves, value: Callable[[str], Number], rates: bool) -> Poses:
        """Return the poses at numbers of each joint."""

        def motion(link: Link) -> JointMotion:
            return link.kind.at(algebra, value(link.edge.name), link.edge.pitch)

        return Poses(self.tree, algebra, motion, self.columns if rates else ())
