"""Rows over boxes: what proofs know of a mechanism whatever its motor values, written once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

from pmjac_pin.kinematics.loops import pair_of
from pmjac_pin.kinematics.tree import Tree
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import Frame
from pmjac_pin.model.linkage import Edge, edges_of
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.studies.modes.box_domain import NoBoxesError
from pmjac_pin.studies.modes.floating_body import (
    FloatingInPlane,
    FloatingTriangle,
    Held,
    held,
)
from pmjac_pin.studies.modes.interval_loops import BoxRows, IntervalLoops, PairRows, tolerances
from pmjac_pin.studies.modes.interval_tree import IntervalTree
from pmjac_pin.studies.modes.recorded_loops import BoxProgram, recorded

_FREE = 6  # freedoms of a body that nothing holds


@dataclass(frozen=True, slots=True, eq=False)
class Floating:
    """A floating joint that is no unknown: its body follows from what holds it."""

    edge: Edge
    plane: Frame | None
    holds: tuple[Held, ...]


@dataclass(frozen=True, slots=True, eq=False)
class RowsOverBoxes:
    """The loop equations of a mechanism over boxes of k unknowns.

    Attributes
    ----------
    unknowns : tuple of Edge
        Passive joints of one degree of freedom.
    tree : Tree
    blocks : tuple of BoxRows
    floating : tuple of Floating
    program : BoxProgram or None
        The same recorded, where there is a kernel that runs it.
    """

    unknowns: tuple[Edge, ...]
    tree: Tree
    blocks: tuple[BoxRows, ...]
    floating: tuple[Floating, ...]
    program: BoxProgram | None

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the unknowns."""
        return tuple(edge.name for edge in self.unknowns)


_KNOWN: WeakKeyDictionary[Mechanism, RowsOverBoxes] = WeakKeyDictionary()


def rows_over_boxes(mechanism: Mechanism) -> RowsOverBoxes:
    """Return the equations of a mechanism.

    Parameters
    ----------
    mechanism : Mechanism

    Raises
    ------
    NoBoxesError
        Geared joints; passive joints of several degrees of freedom that are not held at points;
        passive joints that the motors leave free.
    """
    if mechanism not in _KNOWN:
        _KNOWN[mechanism] = _of_mechanism(mechanism)
    return _KNOWN[mechanism]


def _of_mechanism(mechanism: Mechanism) -> RowsOverBoxes:
    model, partition = mechanism.kinematics.model, mechanism.problem.partition
    edges, motors = edges_of(model), mechanism.spec.actuated
    if partition.isolated:
        raise NoBoxesError("no pose near home closes: what joints can do in general is not known")
    if partition.idles:
        where = "at every pose" if partition.full else "at home and all poses near it"
        raise NoBoxesError(f"passive joints can move with all motors locked, {where}")
    if not partition.passive.size:
        raise NoBoxesError("no joint is passive: the motors alone have to close the loops")
    several = [edge for edge in edges.values() if edge.kind.nv > 1]
    unknowns = [edge for name, edge in edges.items() if name not in motors and edge not in several]
    tree = Tree(model)
    blocks, floating = _rows_over_boxes(mechanism, tree, edges, several)
    names, anywhere = [edge.name for edge in unknowns], dict.fromkeys(motors, 0.0)
    program = recorded(IntervalLoops(IntervalTree(tree, names, anywhere), blocks))
    return RowsOverBoxes(tuple(unknowns), tree, tuple(blocks), floating, program)


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
