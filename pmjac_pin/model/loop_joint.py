"""A loop closure as a joint of the tree: what holds its two frames together when it is not cut."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from pmjac_pin.model.linkage import Edge, Kind, aligned
from pmjac_pin.model.loop_spec import (
    CylindricalLoop,
    DistanceLoop,
    FrameLoop,
    Loop,
    PlanarLoop,
    PointLoop,
    PrismaticLoop,
    RevoluteLoop,
    SphericalLoop,
    UniversalLoop,
)

_KINDS: Mapping[type, Kind] = {
    PointLoop: "spherical",
    SphericalLoop: "spherical",
    FrameLoop: "fixed",
    RevoluteLoop: "revolute",
    PrismaticLoop: "prismatic",
    PlanarLoop: "planar",
}


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
        (pose of the parent's frame, pose of the child's) ↦ pose of the body between.
    """

    edges: tuple[Edge, ...]
    parent: Anchor
    child: Anchor
    between: Callable[[pin.SE3, pin.SE3], pin.SE3] | None = None

    def entries(self, poses: Mapping[int, pin.SE3]) -> dict[str, tuple[float, ...]]:
        """Return Pinocchio's entries for these joints where the bodies are at these poses."""
        known = dict(poses)
        if self.between is not None:
            first, second = (
                poses[anchor.body] * anchor.place for anchor in (self.parent, self.child)
            )
            known[self.edges[0].child] = self.between(first, second)
        return {
            edge.name: edge.entries(known[edge.parent], known[edge.child]) for edge in self.edges
        }


def loop_joint(
    loop: Loop,
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
    loop : Loop
        Not a joint loop.
    values : mapping of str to float
        The parameters' values.
    parent, child : Anchor
        The loop's two frames.
    name : str
        For the joints.
    link : int
        The number of the body between two of them.
    """
    match loop:
        case UniversalLoop():
            return _universal(loop, parent, child, name, link)
        case CylindricalLoop():
            return _cylindrical(loop, parent, child, name, link)
        case DistanceLoop():
            return _rod(loop.resolved_length(values), parent, child, name, link)
    kind = _KINDS[type(loop)]
    turn = aligned(loop.axis) if hasattr(loop, "axis") else pin.SE3.Identity()
    before, after = parent.place * turn, (child.place * turn).inverse()
    edge = Edge(name, kind, parent.body, child.body, before, after)
    return LoopJoint((edge,), parent, child)


def _universal(
    loop: UniversalLoop, parent: Anchor, child: Anchor, name: str, link: int
) -> LoopJoint:
    """Return a cross that turns about z of one frame, and carries the other's axis as its x."""
    one, other = map(aligned, loop.axes)

    def between(first: pin.SE3, second: pin.SE3) -> pin.SE3:
        x, y, _ = ((first * one).actInv(second * other)).rotation[:, 2]
        return first * one * _about_z(math.atan2(y, x))

    before, after = parent.place * one, (child.place * other).inverse()
    turns = (
        Edge(f"{name}_1", "continuous", parent.body, link, before, pin.SE3.Identity()),
        Edge(f"{name}_2", "continuous", link, child.body, aligned([1.0, 0.0, 0.0]), after),
    )
    return LoopJoint(turns, parent, child, between)


def _cylindrical(
    loop: CylindricalLoop, parent: Anchor, child: Anchor, name: str, link: int
) -> LoopJoint:
    along = aligned(loop.axis)

    def between(first: pin.SE3, second: pin.SE3) -> pin.SE3:
        x, y, _ = ((first * along).actInv(second * along)).rotation[:, 0]
        return first * along * _about_z(math.atan2(y, x))

    before, after = parent.place * along, (child.place * along).inverse()
    no = pin.SE3.Identity()
    motions = (
        Edge(f"{name}_turn", "continuous", parent.body, link, before, no),
        Edge(f"{name}_slide", "prismatic", link, child.body, no, after),
    )
    return LoopJoint(motions, parent, child, between)


def _rod(length: float, parent: Anchor, child: Anchor, name: str, link: int) -> LoopJoint:
    """Return a rod along z with a ball at each end: its spin about itself moves nothing else."""

    def between(first: pin.SE3, second: pin.SE3) -> pin.SE3:
        along = second.translation - first.translation
        turn = aligned(along / np.linalg.norm(along)).rotation
        return pin.SE3(turn, first.translation)

    far, after = pin.SE3(np.eye(3), np.array([0.0, 0.0, length])), child.place.inverse()
    balls = (
        Edge(f"{name}_near", "spherical", parent.body, link, parent.place, pin.SE3.Identity()),
        Edge(f"{name}_far", "spherical", link, child.body, far, after),
    )
    return LoopJoint(balls, parent, child, between)


def _about_z(angle: float) -> pin.SE3:
    return pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, angle), np.zeros(3))
