"""BoxProblem: the direct kinematics of a mechanism as equations over boxes of passive values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.kinematics.loops import pair_of
from pmjac_pin.kinematics.tree import Tree
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import Frame
from pmjac_pin.model.linkage import Edge, edges_of
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.studies.modes.box_domain import NoBoxesError, box_domain
from pmjac_pin.studies.modes.box_equations import BoxEquations
from pmjac_pin.studies.modes.floating_body import (
    FloatingInPlane,
    FloatingTriangle,
    Held,
    held,
    placed,
)
from pmjac_pin.studies.modes.interval_loops import BoxRows, IntervalLoops, PairRows, tolerances
from pmjac_pin.studies.modes.interval_tree import IntervalTree
from pmjac_pin.studies.modes.recorded_loops import recorded
from pmjac_pin.values.arrays import Array, Mask

_FREE = 6  # freedoms of a body that nothing holds


@dataclass(frozen=True, slots=True, eq=False)
class Floating:
    """A floating joint that is no unknown: its body follows from what holds it."""

    edge: Edge
    plane: Frame | None
    holds: tuple[Held, ...]


@dataclass(frozen=True, slots=True, eq=False)
class BoxProblem:
    """The loop equations at given motor values, over boxes of k unknowns.

    Attributes
    ----------
    names : tuple of str
        The unknowns: passive joints of one degree of freedom.
    loops : BoxEquations
    domain : Intervals, shape (k,)
        All values that the unknowns can have; for angles without limits, one full turn.
    endless : ndarray of bool, shape (k,)
        Whose values are the same after a full turn.
    scale : ndarray, shape (k,)
        1 rad, or the mechanism's characteristic length in m.
    floating : tuple of Floating
    """

    names: tuple[str, ...]
    loops: BoxEquations
    domain: Intervals
    endless: Mask
    scale: Array
    floating: tuple[Floating, ...]


def box_problem(mechanism: Mechanism, motors: Mapping[str, float], limits: bool) -> BoxProblem:
    """Return the equations of a mechanism at these motor values.

    Parameters
    ----------
    mechanism : Mechanism
    motors : mapping of str to float
        Each motor joint's value, m or rad.
    limits : bool
        Keep within the passive joints' limits.

    Raises
    ------
    NoBoxesError
        Geared joints; passive joints of several degrees of freedom that are not held at points;
        slides without a bound; passive joints that the motors leave free.
    """
    model, partition = mechanism.kinematics.model, mechanism.problem.partition
    edges = edges_of(model)
    if partition.isolated:
        raise NoBoxesError("no pose near home closes: what joints can do in general is not known")
    if partition.passive_rank < partition.passive.size:
        where = "at every pose" if partition.full else "at home and all poses near it"
        raise NoBoxesError(f"passive joints can move with all motors locked, {where}")
    if not partition.passive.size:
        raise NoBoxesError("no joint is passive: the motors alone have to close the loops")
    several = [edge for edge in edges.values() if edge.kind.nv > 1]
    names = tuple(
        name for name, edge in edges.items() if name not in motors and edge not in several
    )
    tree = IntervalTree(model, names, motors)
    rows, floating = _rows_over_boxes(mechanism, tree.tree, edges, several)
    domain, endless = box_domain(mechanism, motors, [edges[name] for name in names], rows, limits)
    slides = np.array([not edges[name].kind.turns for name in names], dtype=bool)
    return BoxProblem(
        names=names,
        loops=recorded(IntervalLoops(tree, rows)),
        domain=domain,
        endless=endless,
        scale=np.where(slides, partition.length, 1.0),
        floating=floating,
    )


def _rows_over_boxes(
    mechanism: Mechanism, tree: Tree, edges: Mapping[str, Edge], several: Sequence[Edge]
) -> tuple[list[BoxRows], tuple[Floating, ...]]:
    """Return all rows, and the floating joints that are no longer in them."""
    closed, length = mechanism.problem.tolerance, mechanism.problem.partition.length
    rows: list[BoxRows] = []
    bodies = {edge.child: edge for edge in several}
    holds: dict[int, list[Held]] = {body: [] for body in bodies}
    for loop in mechanism.spec.loops:
        if isinstance(loop, JointLoop):
            raise NoBoxesError(f"joints {loop.joints[0]!r} and {loop.joints[1]!r} are geared")
        pair = pair_of(mechanism.kinematics.model, tree, loop, mechanism.parameters)
        blocks = [block for _, block in pair.blocks]
        first, second = pair.first, pair.second
        if first.joint in bodies or second.joint in bodies:
            turned = second.joint in bodies
            own, other = (second, first) if turned else (first, second)
            hold = held(own, other, blocks, loop.ends[turned])
            if hold is None or other.joint in bodies:
                raise NoBoxesError(_not_at_points(bodies[own.joint]))
            holds[own.joint].append(hold)
            continue
        label = "-".join(loop.ends)
        names = tuple(f"{label} {row}" for block in blocks for row in block.names)
        sizes = tuple(size for block in blocks for size in tolerances(block, closed, length))
        rows.append(PairRows(pair, names, sizes))
    floating = []
    for body, edge in bodies.items():
        plane = Frame(-1 - body, edge.parent, edge.before) if _in_plane(edge) else None
        carries = any(other.parent == body for other in edges.values())
        found = None if carries else _held_rows(edge, plane, holds[body], closed, closed / length)
        if found is None:
            raise NoBoxesError(_not_at_points(edge))
        rows.append(found)
        floating.append(Floating(edge, plane, tuple(holds[body])))
    return rows, tuple(floating)


def _held_rows(
    edge: Edge, plane: Frame | None, holds: Sequence[Held], closed: float, tilted: float
) -> BoxRows | None:
    """Return the rows that stand for a floating body and its loops, None where none do."""
    if plane is not None:
        return FloatingInPlane.of(edge, plane, holds, closed, tilted)
    return FloatingTriangle.of(edge, holds, closed) if edge.kind.nv == _FREE else None


def _in_plane(edge: Edge) -> bool:
    """Tell whether a joint slides along x and y and turns about z."""
    return (edge.kind.along, edge.kind.about) == ((0, 1), (2,))


def _not_at_points(edge: Edge) -> str:
    kind, wanted = edge.kind.name, "three points of a free body, or points of a body in a plane"
    return (
        f"passive joint {edge.name!r} is {kind}: of several degrees of freedom, and its loops "
        f"do not just hold {wanted}"
    )


def given_values(mechanism: Mechanism, values: Array) -> Mapping[str, float]:
    """Return the motors' values by name.

    Raises
    ------
    NoBoxesError
        A motor joint of several degrees of freedom.
    """
    model = mechanism.kinematics.model
    for name in mechanism.spec.actuated:
        joint = model.joints[model.getJointId(name)]
        if joint.nv != 1:
            raise NoBoxesError(f"motor {name!r} has {joint.nv} degrees of freedom")
    return dict(zip(mechanism.spec.actuated, values.tolist(), strict=True))


def start(mechanism: Mechanism, problem: BoxProblem, q: Array, values: Array) -> Array:
    """Return q with the unknowns at these values, and floating bodies where they are held."""
    columns = mechanism.coordinates.columns(problem.names)
    q = mechanism.coordinates.with_values(q, columns, values)
    model, data = mechanism.kinematics.model, mechanism.kinematics.placed(q)
    for floating in problem.floating:
        edge = floating.edge
        frames = [data.oMi[hold.other.joint] * hold.other.placement for hold in floating.holds]
        if floating.plane is not None:
            frames.append(data.oMi[floating.plane.joint] * floating.plane.placement)
        entries = edge.entries(data.oMi[edge.parent], placed(edge, floating.holds, frames))
        joint = model.joints[model.getJointId(edge.name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = entries
    return q
