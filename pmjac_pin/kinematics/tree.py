"""Tree: poses of bodies and motions of freedoms, over any number type.

Everything is seen from a base, a body that carries what is asked for or the world: what moves
the base moves nothing here.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra import Algebra, Number
from pmjac_pin.algebra.jets import Columns
from pmjac_pin.kinematics.dimensions import Placements
from pmjac_pin.kinematics.frame_jets import Freedom, Riding, Twisted
from pmjac_pin.kinematics.places import Place, Pose, standing, steps, through
from pmjac_pin.model.frames import Frame
from pmjac_pin.model.joint_kind import JointKind, JointMotion, rotation_of
from pmjac_pin.model.linkage import Edge, edges_of


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A joint and the body behind it.

    Attributes
    ----------
    edge : Edge
    entries : slice
        Of q.
    column : int
        Of its first freedom in v.
    from_base, from_parent : tuple of Place
        What leads to its motion: from its parent's frame, and from that body's own moved one.
    after : tuple of Place
        What leads from its moved frame to its body's.
    """

    edge: Edge
    entries: slice
    column: int
    from_base: tuple[Place, ...]
    from_parent: tuple[Place, ...]
    after: tuple[Place, ...]

    @property
    def kind(self) -> JointKind:
        """The kind of the joint."""
        return self.edge.kind


class Tree:
    """The joints of a model.

    Parameters
    ----------
    model : pin.Model
    placed : callable, optional
        What is taken for each placement.
    dimensions : Placements, optional
        Where joints and frames are; as the model has them when None.

    Attributes
    ----------
    links : mapping of int to Link
        By Pinocchio's index of the joint, which is that of its body.
    """

    __slots__ = ("_dimensions", "_placed", "_supports", "_ways", "links")

    def __init__(
        self,
        model: pin.Model,
        placed: Callable[[pin.SE3], Any] = lambda place: place,
        dimensions: Placements | None = None,
    ) -> None:
        self._placed, self._dimensions = placed, dimensions
        edges = {
            edge.child: replace(edge, before=self._before(edge), after=placed(edge.after))
            for edge in edges_of(model).values()
        }
        self._supports: list[tuple[int, ...]] = [tuple(support) for support in model.supports]
        self.links: dict[int, Link] = {}
        self._ways: dict[tuple[bool, int], tuple[Place, ...]] = {}
        for joint in list(model.joints)[1:]:
            edge = edges[joint.id]
            parent = edges.get(edge.parent)
            self.links[joint.id] = Link(
                edge=edge,
                entries=slice(joint.idx_q, joint.idx_q + joint.nq),
                column=joint.idx_v,
                from_base=steps(edge.before),
                from_parent=steps(parent.after, edge.before) if parent else (),
                after=steps(edge.after),
            )

    def _before(self, edge: Edge) -> Any:
        if self._dimensions is None:
            return self._placed(edge.before)
        return self._dimensions.of_joint(edge.child) * edge.after.inverse()

    def _frame_place(self, frame: Frame) -> Any:
        if self._dimensions is None:
            return self._placed(frame.placement)
        return self._dimensions.of_frame(frame)

    def base(self, *frames: Frame) -> int:
        """Return the last body that carries all of these frames; 0 for the world."""
        first, *others = (self._supports[frame.joint] for frame in frames)
        return max(body for body in first if all(body in other for other in others))

    def chain(self, base: int, body: int) -> list[Link]:
        """Return the joints between a base and a body, the nearest to the base first."""
        support = self._supports[body]
        return [self.links[joint] for joint in support[support.index(base) + 1 :]]

    def way(self, base: int, frame: Frame) -> tuple[Place, ...]:
        """Return what leads to a frame from its body's moved frame, or from the base."""
        key = (frame.joint == base, frame.index)
        if key not in self._ways:
            after = () if frame.joint == base else (self.links[frame.joint].edge.after,)
            self._ways[key] = steps(*after, self._frame_place(frame))
        return self._ways[key]


class Poses:
    """Where bodies are at some numbers.

    Parameters
    ----------
    tree : Tree
    algebra : Algebra
    motion : callable
        Link ↦ how it moves.
    riding : collection of int
        Columns whose derivatives go through the same products as the poses.
    """

    __slots__ = ("_bodies", "_freedoms", "_motion", "_motions", "_riding", "algebra", "tree")

    def __init__(
        self,
        tree: Tree,
        algebra: Algebra,
        motion: Callable[[Link], JointMotion],
        riding: Collection[int] = (),
    ) -> None:
        self.tree, self.algebra = tree, algebra
        self._motion, self._riding = motion, frozenset(riding)
        self._motions: dict[int, JointMotion] = {}
        self._bodies: dict[tuple[int, int], tuple[Pose, Columns]] = {}
        self._freedoms: dict[tuple[int, int], list[Freedom]] = {}

    def motion(self, link: Link) -> JointMotion:
        """Return how a joint moves."""
        body = link.edge.child
        if body not in self._motions:
            self._motions[body] = self._motion(link)
        return self._motions[body]

    def body(self, base: int, body: int) -> tuple[Pose, Columns]:
        """Return a body's frame behind its joint's motion, and the freedoms whose rates ride."""
        key = (base, body)
        if key not in self._bodies:
            self._bodies[key] = self._body(base, body)
        return self._bodies[key]

    def riding(self, base: int, frame: Frame) -> Riding:
        """Return a frame, with derivatives that ride along."""
        pose, columns = self.body(base, frame.joint)
        way = self.tree.way(base, frame)
        return Riding(self.algebra, through(self.algebra, pose, way), columns)

    def twisted(self, base: int, frame: Frame) -> Twisted:
        """Return a frame, with derivatives by all freedoms between it and the base."""
        pose, _ = self.body(base, frame.joint)
        pose = through(self.algebra, pose, self.tree.way(base, frame))
        return Twisted(self.algebra, pose, self.freedoms(base, frame.joint))

    def freedoms(self, base: int, body: int) -> list[Freedom]:
        """Return what the freedoms between a base and a body move it by."""
        if body == base:
            return []
        key = (base, body)
        if key not in self._freedoms:
            above = self.freedoms(base, self.tree.links[body].edge.parent)
            self._freedoms[key] = above + self.own_freedoms(base, body)
        return self._freedoms[key]

    def own_freedoms(self, base: int, body: int) -> list[Freedom]:
        """Return what the freedoms of a body's own joint move it by."""
        (pose, _), link = self.body(base, body), self.tree.links[body]
        kind, slides, column = link.kind, link.kind.slides, link.column
        return [
            *(
                Freedom(column + k, pose[axis], None, 0.0)
                for k, axis in enumerate(kind.along[:slides])
            ),
            *(
                Freedom(column + slides + k, pose[axis], pose.p, link.edge.pitch)
                for k, axis in enumerate(kind.about)
            ),
        ]

    def before(self, base: int, link: Link) -> tuple[Pose, Columns]:
        """Return where a joint's motion begins, and the freedoms whose rates ride there."""
        parent = link.edge.parent
        pose, columns = self.body(base, parent)
        places = link.from_base if parent == base else link.from_parent
        return through(self.algebra, pose, places), columns

    def _body(self, base: int, body: int) -> tuple[Pose, Columns]:
        if body == base:
            return standing(self.algebra), ()
        link = self.tree.links[body]
        pose, columns = self.before(base, link)
        pose = moved(pose, link.kind, self.motion(link))
        own = [k for k in range(link.kind.nv) if link.column + k in self._riding]
        if not own:
            return pose, columns
        pose = with_rates(self.algebra, self._reached(pose, link), pose, link, own)
        return pose, (*columns, *(link.column + k for k in own))

    def _reached(self, pose: Pose, link: Link) -> Pose:
        """Return all poses that a joint whose rates ride is taken to have about this one."""
        return pose


def moved(pose: Pose, kind: JointKind, motion: JointMotion) -> Pose:
    """Return pose · M, M the motion of a joint."""
    x, y, z, p = pose
    for axis, slide in zip(kind.along, motion.slides, strict=True):
        p = p + pose[axis] * slide
    if len(motion.turn) == 2:
        c, s = motion.turn
        x, y = x * c + y * s, y * c - x * s
    elif motion.turn:
        columns = zip(*rotation_of(motion.turn), strict=True)
        x, y, z = (x * a + y * b + z * c for a, b, c in columns)
    return Pose(x, y, z, p)


def with_rates(algebra: Algebra, pose: Pose, slid: Pose, link: Link, own: Sequence[int]) -> Pose:
    """Return a pose with the derivatives X ξ^ by some of its joint's own freedoms.

    Slides are along the axes of another pose, which turns move no more.
    """
    here, along = (Pose(*(column[..., :1, :] for column in one)) for one in (pose, slid))
    nothing = algebra.constant(np.zeros(3))
    rates = [_own_rates(algebra, here, along, link, k) for k in own]
    columns = (
        algebra.join([column, *(rate.get(k, nothing) for rate in rates)])
        for k, column in enumerate(pose)
    )
    return Pose(*columns)


def _own_rates(
    algebra: Algebra, pose: Pose, slid: Pose, link: Link, freedom: int
) -> Mapping[int, Number]:
    """Return the columns of X ξ^ that are not zero."""
    kind = link.kind
    if freedom < kind.slides:
        return {3: slid[kind.along[freedom]]}
    axis = kind.about[freedom - kind.slides]
    j, k = (axis + 1) % 3, (axis + 2) % 3
    rates = {j: pose[k], k: -pose[j]}
    if kind.screw:
        rates[3] = algebra.times(link.edge.pitch * np.eye(3), pose[axis])
    return rates
