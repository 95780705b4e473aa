"""The poses of a tree over boxes of joint values, with derivatives that ride along.

No derivative is a difference of two poses, which would be much wider than itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pinocchio as pin

from pmjac_pin.algebra.boxes import BOXES
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.model.joint_kind import JointMotion


class IntervalTree:
    """The joints of a tree that boxes speak of, and those whose values are given.

    Parameters
    ----------
    model : pin.Model
    unknowns : sequence of str
        Joints of one degree of freedom: the columns of a box.
    given : mapping of str to float
        The other joints' values, m or rad.

    Attributes
    ----------
    tree : Tree
    columns : tuple of int
        The unknowns' columns of v.
    """

    __slots__ = ("_given", "_unknowns", "columns", "tree")

    def __init__(
        self, model: pin.Model, unknowns: Sequence[str], given: Mapping[str, float]
    ) -> None:
        self.tree = Tree(model)
        self._unknowns = {name: place for place, name in enumerate(unknowns)}
        self._given = {name: Intervals.exact([[value]]) for name, value in given.items()}
        columns = {link.edge.name: link.column for link in self.tree.links.values()}
        self.columns = tuple(columns[name] for name in unknowns)

    def poses(self, box: Intervals, rates: bool) -> Poses:
        """Return the poses over boxes (b, k) of the unknowns' values, m or rad."""

        def motion(link: Link) -> JointMotion:
            name = link.edge.name
            place = self._unknowns.get(name)
            value = self._given[name] if place is None else box[None, :, place]
            return link.kind.at(BOXES, value, link.edge.pitch)

        return Poses(self.tree, BOXES, motion, self.columns if rates else ())
