"""A loop closure as a joint of the tree: what holds its two frames together when it is not cut."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import pinocchio as pin

from pmjac_pin.model.joint_kinds import kind_named
from pmjac_pin.model.linkage import Edge
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class Anchor:
    """A frame on a body."""

    body: int
    place: pin.SE3


@dataclass(frozen=True, slots=True, eq=False)
class LoopJoint:
    """The joints that replace a loop closure, and where the body between them is.

    Attributes
    ----------
    edges : tuple of Edge
        One; or two, with a body without mass between them.
    parent, child : Anchor
        The loop's two frames.
    between : callable or None
        The child's frame seen from the parent's, 4×4 ↦ where the body between is, seen from that.
    """

    edges: tuple[Edge, ...]
    parent: Anchor
    child: Anchor
    between: Callable[[Array], Array] | None = None

    def entries(self, poses: Mapping[int, pin.SE3]) -> dict[str, tuple[float, ...]]:
        """Return Pinocchio's entries for these joints where the bodies are at these poses."""
        known = dict(poses)
        if self.between is not None:
            first, second = (
                poses[anchor.body] * anchor.place for anchor in (self.parent, self.child)
            )
            seen = self.between(first.actInv(second).homogeneous)
            known[self.edges[0].child] = first * pin.SE3(seen)
        return {
            edge.name: edge.entries(known[edge.parent], known[edge.child]) for edge in self.edges
        }


def loop_joint(
    loop: LoopBetweenFrames,
    values: Mapping[str, float],
    parent: Anchor,
    child: Anchor,
    *,
    name: str,
    link: int,
) -> LoopJoint:
    """Return the joints that keep a loop closed.

    Parameters
    ----------
    loop : LoopBetweenFrames
    values : mapping of str to float
        The parameters' values.
    parent, child : Anchor
        The loop's two frames.
    name : str
        For the joints.
    link : int
        The number of the body between two of them.
    """
    form = loop.form(values)
    ends, between = [parent.body, child.body], form.middle
    ends[1:1] = [link] * (len(form.steps) - 1)
    steps = [(step, pin.SE3(step.before), pin.SE3(step.after)) for step in form.steps]
    steps[0] = (steps[0][0], parent.place * steps[0][1], steps[0][2])
    steps[-1] = (*steps[-1][:2], steps[-1][2] * child.place.inverse())
    edges = [
        Edge(
            *(f"{name}_{step.suffix}" if step.suffix else name, kind_named(step.kind)),
            *(start, end, before, after),
        )
        for (step, before, after), (start, end) in zip(steps, pairwise(ends), strict=True)
    ]
    return LoopJoint(tuple(edges), parent, child, between)
