"""Recut: the same mechanism with its loops cut at another joint.

The joint that is cut becomes a loop closure of its kind. What hung on it is held by one of the
loops that led there, which becomes a joint of the tree; the joints between the two are turned
round. Motor rates and tool twists do not notice: J_eq is invariant to the cut.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from msgspec.structs import replace

from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.closing.machine_size import shifted_model
from pmjac_pin.errors import ArgumentError, quoted, unknown_name
from pmjac_pin.files.unused_name import unused_name
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.linkage import Edge, build, edges_of
from pmjac_pin.model.loop_joint import Anchor, LoopJoint, loop_joint
from pmjac_pin.model.loop_spec import FrameLoop, JointLoop, Loop, resolved_loop
from pmjac_pin.model.spec import JointValue, MechanismSpec
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import check_kind

_ALL = 6  # freedoms: such a joint holds nothing


@dataclass(frozen=True, slots=True, eq=False)
class _Cut:
    """A joint taken out of the tree: the loop that replaces it, and the loop's frames."""

    loops: tuple[Loop, ...]
    frames: dict[str, tuple[int, pin.SE3]]
    edges: tuple[Edge, ...]  # what stays of a joint that must keep its value


def recut(mechanism: Mechanism, joint: str) -> Mechanism:
    """Return the same mechanism with its loops cut at another joint.

    The joint becomes a loop closure of its kind, and a loop that led to it a joint. A motor,
    or a geared joint, keeps its value: it is cut behind its hub, which is welded again. So is a
    joint of a kind that no loop closure is of: a screw, whose turns count.
    J_eq does not change; K, K* and their shapes do.

    Parameters
    ----------
    mechanism : Mechanism
    joint : str
        A joint of the tree that is part of a loop.

    Returns
    -------
    Mechanism
        With the same motors, tool and poses; parameters are fixed at their values. A passive
        joint that is cut has no limits any more; `notes` say so. Where a rod between two balls
        becomes a link, its spin is a passive motion more, and counts in `mobility`.

    Raises
    ------
    UnknownNameError
        No such joint.
    ArgumentError
        The joint is in no loop, or cannot be taken apart.

    Examples
    --------
    >>> import numpy as np, pmjac_pin as pj
    >>> mechanism = pj.load("four_bar")
    >>> recut = pj.recut(mechanism, "phi1")
    >>> recut.rows[:5]
    ('phi1_child-phi1_parent x', 'phi1_child-phi1_parent y', 'phi1_child-phi1_parent z',
     'phi1_child-phi1_parent tilt 1', 'phi1_child-phi1_parent tilt 2')
    >>> bool(np.allclose(recut.home.jacobian().J_eq, mechanism.home.jacobian().J_eq))
    True
    """
    check_kind(mechanism, Mechanism)
    poses = {name: mechanism.pose(name).q for name in mechanism.poses}
    notes = (*mechanism.notes, *_lost(mechanism, joint))
    parts = build_parts(*_recut(mechanism, joint, poses), {}, mechanism.urdf)
    return Mechanism(parts, notes=notes, unread=mechanism.unread)


def _lost(mechanism: Mechanism, joint: str) -> list[str]:
    """Say what a joint which becomes a loop closure has no more there; a motor keeps its own."""
    coordinates = mechanism.coordinates
    if not isinstance(joint, str) or joint not in coordinates.names:
        return []
    if _keeps_its_value(mechanism.spec, joint):
        return []
    lost, notes = coordinates.columns([joint]), []
    if not np.isinf([coordinates.lower[lost], coordinates.upper[lost]]).all():
        notes.append(f"joint {joint!r} is cut: a loop closure has no limits, so its own are lost")
    if mechanism.model.armature[lost].any():
        notes.append(f"joint {joint!r} is cut: its armature is lost, and no mass matrix has it")
    return notes


def _recut(
    mechanism: Mechanism, joint: str, poses: Mapping[str, Array]
) -> tuple[pin.Model, MechanismSpec]:
    model, spec = mechanism.kinematics.model, mechanism.spec
    if not isinstance(joint, str) or joint not in mechanism.coordinates.names:
        raise unknown_name("joint", joint, mechanism.coordinates.names)
    edges = edges_of(model)
    loose = _behind(edges.values(), edges[joint].child)
    opened, held = _held_by(mechanism, joint, loose)
    turned = _turned_round(edges, held.edges[-1].child, edges[joint].child)
    cut = _cut(edges[joint], model.njoints + 1, _keeps_its_value(spec, joint), _frame_names(model))
    stay = [turned.get(name, edge) for name, edge in edges.items() if name != joint]
    tree = shifted_model(
        build(model, [*stay, *cut.edges, *held.edges], cut.frames), mechanism.place
    )
    loops = [resolved_loop(loop, mechanism.parameters) for loop in spec.loops if loop is not opened]

    def pose(q: Array) -> dict[str, JointValue]:
        values = mechanism.coordinates.pose(q) | _new_values(model, q, held, turned)
        return {name: value for name, value in values.items() if tree.existJointName(name)}

    recut = replace(
        spec,
        loops=(*loops, *cut.loops),
        passive=None,
        spherical=(),
        helical={},
        armature={},
        parameters={},
        poses={name: pose(q) for name, q in poses.items()},
    )
    return tree, recut


def _keeps_its_value(spec: MechanismSpec, joint: str) -> bool:
    """Tell whether a joint's value is in the equations: a motor's, or a geared joint's."""
    geared = [name for loop in spec.loops if isinstance(loop, JointLoop) for name in loop.joints]
    return joint in (*spec.actuated, *geared)


def _behind(edges: Iterable[Edge], body: int) -> set[int]:
    """Return a body and all that hangs on it."""
    loose = {body}
    for edge in edges:  # parents come before their children in Pinocchio's order
        if edge.parent in loose:
            loose.add(edge.child)
    return loose


def _held_by(mechanism: Mechanism, joint: str, loose: set[int]) -> tuple[Loop, LoopJoint]:
    """Return the first loop that holds what hung on the joint, and the joint that it becomes."""
    model, name = mechanism.kinematics.model, mechanism.spec.name
    for loop in mechanism.spec.loops:
        if isinstance(loop, JointLoop):
            continue
        ends = [find_frame(model, frame) for frame in loop.frames]
        first, second = (Anchor(end.joint, end.placement) for end in ends)
        if (first.body in loose) == (second.body in loose):
            continue
        seen = loop
        if first.body in loose:
            first, second = second, first
            seen = loop.exchanged
        label = unused_name("-".join(loop.frames), set(model.names))
        values = mechanism.parameters
        return loop, loop_joint(seen, values, first, second, name=label, link=model.njoints)
    why = "cut there, nothing would hold what it carries"
    raise ArgumentError(f"{name}: joint {quoted(joint)} is in no loop: {why}")


def _turned_round(edges: Mapping[str, Edge], start: int, end: int) -> dict[str, Edge]:
    """Return the joints between two bodies, the second an ancestor, each turned round."""
    below = {edge.child: edge for edge in edges.values()}
    turned = {}
    while start != end:
        edge = below[start]
        turned[edge.name] = edge.turned()
        start = edge.parent
    return turned


def _cut(edge: Edge, hub: int, keeps_its_value: bool, taken: set[str]) -> _Cut:
    """Return what a joint becomes: a loop, or what it moves a hub, and the hub is welded."""
    one, other = (unused_name(f"{edge.name}_{side}", taken) for side in ("child", "parent"))
    on_child = (edge.child, edge.after.inverse())
    loop = edge.kind.loop
    if keeps_its_value or (loop is None and edge.kind.nv < _ALL):
        driven = dataclasses.replace(edge, child=hub, after=pin.SE3.Identity())
        frames = {one: on_child, other: (hub, pin.SE3.Identity())}
        return _Cut((FrameLoop(frames=(one, other)),), frames, (driven,))
    frames = {one: on_child, other: (edge.parent, edge.before)}
    return _Cut((loop(frames=(one, other)),) if loop else (), frames, ())


def _frame_names(model: pin.Model) -> set[str]:
    return {frame.name for frame in model.frames}


def _new_values(
    model: pin.Model, q: Array, held: LoopJoint, turned: Mapping[str, Edge]
) -> dict[str, JointValue]:
    """Return the entries of the joints that are new, and of those whose value turned round."""
    data = model.createData()
    pin.forwardKinematics(model, data, q)
    poses = {body: pose.copy() for body, pose in enumerate(data.oMi)}
    changed: dict[str, JointValue] = dict(held.entries(poses))
    for name, edge in turned.items():
        changed[name] = edge.entries(poses[edge.parent], poses[edge.child])
    return changed
