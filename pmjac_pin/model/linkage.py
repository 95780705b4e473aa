"""Linkage: a Pinocchio model taken apart into bodies and joints, and hung up another way.

A joint is an edge between two bodies, with a kind, a place on each and no preferred direction:

    child's pose = parent's pose · before · motion(value) · after

The motions of one degree of freedom are along or about z. A tree can be rebuilt from its edges
with some of them turned round, exchanged or of another kind.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.joint_form import frame_along
from pmjac_pin.model.joint_kind import JointKind
from pmjac_pin.model.joint_kinds import kind_named, known_kind, pitch_of
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import LARGEST

_OVER = pin.SE3(np.diag([1.0, -1.0, -1.0]), np.zeros(3))  # half a turn about x: z becomes −z


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """A joint between two bodies.

    Attributes
    ----------
    name : str
    kind : JointKind
    parent, child : int
        Bodies; 0 is the world.
    before, after : pin.SE3
    limits : tuple of ndarray, shapes (nq,), or None
        The lower and the upper ones, as Pinocchio has them.
    pitch : float
        How far a screw slides, m/rad.
    """

    name: str
    kind: JointKind
    parent: int
    child: int
    before: pin.SE3
    after: pin.SE3
    limits: tuple[Array, Array] | None = None
    pitch: float = 0.0

    def entries(self, parent: pin.SE3, child: pin.SE3) -> tuple[float, ...]:
        """Return Pinocchio's nq entries for this joint where its two bodies are at these poses."""
        motion = (parent * self.before).actInv(child * self.after.inverse())
        return self.kind.entries(motion, self.pitch)

    @property
    def bounds(self) -> tuple[float, float]:
        """The limits of a joint with one entry in q; infinite for others."""
        if self.limits is None or self.kind.nq != 1:
            return -math.inf, math.inf
        lower, upper = (float(limit[0]) for limit in self.limits)
        # Pinocchio writes the largest double where there is no limit.
        return lower if lower > -LARGEST else -math.inf, upper if upper < LARGEST else math.inf

    def turned(self) -> Edge:
        """Return the joint seen from its child; what moves along and about z keeps its values."""
        over = _OVER if self.kind.axial else pin.SE3.Identity()
        return replace(
            self,
            parent=self.child,
            child=self.parent,
            before=self.after.inverse() * over,
            after=over * self.before.inverse(),
            limits=self.limits if self.kind.axial else None,
        )


def turned_to(axis: Sequence[float] | Array) -> pin.SE3:
    """Return a rotation that takes z to a unit vector.

    Examples
    --------
    >>> turned_to([1.0, 0.0, 0.0]).rotation.round(12)[:, 2].tolist()
    [1.0, 0.0, 0.0]
    """
    return pin.SE3(frame_along(np.asarray(axis, dtype=float)))


def edges_of(model: pin.Model) -> dict[str, Edge]:
    """Return the joints of a model by name; body k is what Pinocchio's joint k carries.

    Raises
    ------
    ArgumentError
        A joint of a kind that is not known here.
    """
    edges, data = {}, model.createData()
    pin.computeJointJacobians(model, data, pin.neutral(model))
    for joint in list(model.joints)[1:]:
        name, index = model.names[joint.id], joint.id
        kind = known_kind(joint, name)
        turn = turned_to(_axis(model, data, joint)) if kind.nv == 1 else pin.SE3.Identity()
        entries = slice(joint.idx_q, joint.idx_q + joint.nq)
        edges[name] = Edge(
            name,
            kind,
            int(model.parents[index]),
            index,
            model.jointPlacements[index] * turn,
            turn.inverse(),
            (model.lowerPositionLimit[entries].copy(), model.upperPositionLimit[entries].copy()),
            pitch_of(joint),
        )
    return edges


#: What a model says of each velocity.
_OF_MOTORS = (
    "armature",
    "damping",
    "lowerDryFrictionLimit",
    "lowerEffortLimit",
    "lowerVelocityLimit",
    "rotorGearRatio",
    "rotorInertia",
    "upperDryFrictionLimit",
    "upperEffortLimit",
    "upperVelocityLimit",
)


def build(
    model: pin.Model, edges: Iterable[Edge], extra: Mapping[str, tuple[int, pin.SE3]]
) -> pin.Model:
    """Return a model of the bodies and frames of `model`, hung up by these edges.

    Parameters
    ----------
    model : pin.Model
        Its bodies, frames and inertias are taken, and of joints by the same names what is said of
        their motors; its joints are not.
    edges : iterable of Edge
        A tree from body 0. Bodies beyond those of `model` have no mass; those that no edge
        leads to are left out.
    extra : mapping of str to (int, pin.SE3)
        Further frames: the body that carries it, and its place there.
    """
    tree = pin.Model()
    tree.name, tree.gravity = model.name, model.gravity
    carriers = _hang(tree, list(edges))
    for body in range(1, model.njoints):
        if body not in carriers:
            continue
        joint, place = carriers[body]
        tree.appendBodyToJoint(joint, model.inertias[body], place)
    for frame in list(model.frames)[1:]:
        if frame.parentJoint not in carriers:
            continue
        # The joint that a frame was named after may be turned round or gone: it is what stays
        # of it, and as a joint's frame it gives way to a link of the same name.
        kind = pin.FrameType.FIXED_JOINT if frame.type == pin.FrameType.JOINT else frame.type
        _add_frame(tree, frame.name, carriers[frame.parentJoint], frame.placement, kind)
    for name, (body, place) in extra.items():
        _add_frame(tree, name, carriers[body], place, pin.FrameType.OP_FRAME)
    _copy_motors(model, tree)
    return tree


def _copy_motors(model: pin.Model, tree: pin.Model) -> None:
    """Copy rotors, friction and limits of joints that both models have, of the same freedoms."""
    for name in list(tree.names)[1:]:
        if not model.existJointName(name):
            continue
        one, other = model.joints[model.getJointId(name)], tree.joints[tree.getJointId(name)]
        if one.nv == other.nv:
            for what in _OF_MOTORS:
                values = getattr(model, what)[one.idx_v : one.idx_v + one.nv]
                getattr(tree, what)[other.idx_v : other.idx_v + other.nv] = values


def with_spherical(model: pin.Model, names: Iterable[str]) -> pin.Model:
    """Return the model with these joints, which have six degrees of freedom, only turning.

    Raises
    ------
    ArgumentError
        A joint that is not `floating`.
    """
    pitches = dict.fromkeys(names, 0.0)
    return _with(model, pitches, "spherical", "floating", lambda kind: kind.name == "free")


def with_helical(model: pin.Model, pitches: Mapping[str, float]) -> pin.Model:
    """Return the model with these joints, which turn, sliding as they turn.

    Parameters
    ----------
    model : pin.Model
    pitches : mapping of str to float
        How far along their axes, m/rad.

    Raises
    ------
    ArgumentError
        A joint that is neither `revolute` nor `continuous`.
    """
    return _with(model, pitches, "helical", "revolute or continuous", lambda kind: kind.endless)


def _with(
    model: pin.Model,
    pitches: Mapping[str, float],
    name: str,
    written: str,
    fits: Callable[[JointKind], bool],
) -> pin.Model:
    """Return the model with these joints of another kind, which a URDF has no word for."""
    edges, kind = edges_of(model), kind_named(name)
    for joint, pitch in pitches.items():
        if joint not in edges or not fits(edges[joint].kind):
            wanted = f"`{name}` names joints that the URDF writes as {written}"
            raise ArgumentError(f"{wanted}, got {quoted(joint)}")
        limits = edges[joint].limits if edges[joint].kind.nq == kind.nq else None
        edges[joint] = replace(edges[joint], kind=kind, limits=limits, pitch=pitch)
    return build(model, edges.values(), {})


def _hang(tree: pin.Model, edges: list[Edge]) -> dict[int, tuple[int, pin.SE3]]:
    """Add the joints depth first; return each body's joint and its place in that."""
    children: dict[int, list[Edge]] = {}
    for edge in edges:
        children.setdefault(edge.parent, []).append(edge)
    carriers = {0: (0, pin.SE3.Identity())}
    waiting = children.get(0, [])[::-1]
    while waiting:
        edge = waiting.pop()
        joint, place = carriers[edge.parent]
        if not edge.kind.nv:
            carriers[edge.child] = (joint, place * edge.before * edge.after)
        else:
            kind = edge.kind
            none = np.full(kind.nv, np.inf)
            limits = edge.limits or (np.full(kind.nq, -np.inf), np.full(kind.nq, np.inf))
            own, at = kind.built(edge.pitch), place * edge.before
            added = tree.addJoint(joint, own, at, edge.name, none, none, *limits)
            carriers[edge.child] = (added, edge.after)
        waiting += children.get(edge.child, [])[::-1]
    return carriers


def _add_frame(
    tree: pin.Model, name: str, carrier: tuple[int, pin.SE3], place: pin.SE3, kind: pin.FrameType
) -> None:
    tree.addFrame(pin.Frame(name, carrier[0], carrier[1] * place, kind), False)


def _axis(model: pin.Model, data: pin.Data, joint: pin.JointModel) -> Array:
    """Return a joint's axis in its own frame; not all of Pinocchio's joints show theirs."""
    motion = pin.getJointJacobian(model, data, joint.id, pin.LOCAL).reshape(6, -1)[:, joint.idx_v]
    axis = motion[3:] if motion[3:].any() else motion[:3]
    return np.asarray(axis / np.linalg.norm(axis))
