"""SearchProblem: the passive joints at given motor values, over many poses at once.

Where the mechanism has legs, they are rods here and their joints are found afterwards.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from pmjac_pin.closing.scales import column_scale, row_scale
from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.kinematics.many import ManyLoops, ManyPoses
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.linkage import Edge, build, edges_of
from pmjac_pin.model.loop_spec import DistanceLoop, JointLoop, Loop
from pmjac_pin.model.tool_spec import Tool
from pmjac_pin.rates.partition import Partition
from pmjac_pin.studies.modes.leg_reach import reached
from pmjac_pin.studies.modes.legs import Leg, find_legs, names_of
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class SearchProblem:
    """A tree, its loops, and what is unknown.

    Attributes
    ----------
    model : pin.Model
    base : ndarray, shape (nq,)
        The home pose, with the motors at their values.
    tree : ManyPoses
    loops : ManyLoops
    closures : tuple of Loop
        What `loops` are made of.
    values : mapping of str to float
        The parameters' values.
    passive : tuple of (slice, Edge)
        Each unknown joint's entries in q.
    partition : Partition
        The mechanism's, or with rods in place of the legs.
    tolerance : float
        The gap in m that counts as closed.
    tool : Tool
        Its frames are in `model`.
    sensed : frozenset of str
        The joints whose axes have a sense: motors, and what is geared.
    """

    model: pin.Model
    base: Array
    tree: ManyPoses
    loops: ManyLoops
    closures: tuple[Loop, ...]
    values: Mapping[str, float]
    passive: tuple[tuple[slice, Edge], ...]
    partition: Partition
    tolerance: float
    tool: Tool
    sensed: frozenset[str]

    @property
    def length(self) -> float:
        """The characteristic length, m."""
        return self.partition.length

    @property
    def idle(self) -> int:
        """How many degrees of freedom idle at every pose."""
        return self.partition.passive.size - self.partition.passive_rank


def search_problem(mechanism: Mechanism, base: Array) -> tuple[SearchProblem, list[Leg]]:
    """Return the problem of a mechanism with its motors as in `base`, and the legs left out."""
    legs = find_legs(mechanism, base)
    if legs:
        return _without(mechanism, legs, base), legs
    model, loops = mechanism.kinematics.model, mechanism.spec.loops
    return _bounded_problem(mechanism, model, loops, mechanism.problem.partition, base), legs


def with_legs(
    mechanism: Mechanism, legs: list[Leg], problem: SearchProblem, base: Array, q: Array
) -> Array:
    """Return the whole mechanism's q for one of the problem's, its legs reaching their ends."""
    if not legs:
        return q
    whole = _copied(problem.model, q, mechanism.kinematics.model, base)
    for leg in legs:
        whole = reached(mechanism, leg, whole)
    return whole


def without_legs(mechanism: Mechanism, problem: SearchProblem, q: Array) -> Array:
    """Return the problem's q for one of the whole mechanism's."""
    return _copied(mechanism.kinematics.model, q, problem.model, problem.base)


def _without(mechanism: Mechanism, legs: list[Leg], base: Array) -> SearchProblem:
    """Return the problem with rods in place of the legs."""
    gone = set(names_of(legs))
    whole, everything = mechanism.kinematics.model, mechanism.spec.loops
    edges = [edge for name, edge in edges_of(whole).items() if name not in gone]
    centres = {
        f"centre of {'-'.join(leg.loop.ends)}": (leg.body, pin.SE3(np.eye(3), leg.centre))
        for leg in legs
    }
    model = build(whole, edges, centres)
    ended = [leg.loop for leg in legs]
    rods = [
        DistanceLoop(frames=(leg.frame, centre), length=leg.length)
        for leg, centre in zip(legs, centres, strict=True)
    ]
    stay = [loop for loop in everything if not any(loop is end for end in ended)]
    sizes = dict(zip(map(id, everything), mechanism.problem.partition.loop_sizes, strict=True))
    loops, kept = [*stay, *rods], [sizes[id(loop)] for loop in (*stay, *ended)]
    q = _copied(whole, base, model, pin.neutral(model))
    partition = _with_rods(mechanism, model, loops, kept)
    return _bounded_problem(mechanism, model, loops, partition, q)


def _with_rods(
    mechanism: Mechanism,
    model: pin.Model,
    loops: Sequence[Loop],
    sizes: Sequence[float],
) -> Partition:
    """Return the partition of a model that has rods, of these sizes, in place of legs."""
    partition, coordinates = mechanism.problem.partition, JointCoordinates(model)
    system, motors = LoopSystem(model, loops, mechanism.parameters), mechanism.spec.actuated
    columns = column_scale(system, coordinates.rotational, partition.length, sizes)
    rows = row_scale(system, columns, partition.length, sizes)
    driven, passive = (
        coordinates.columns(name for name in coordinates.names if (name in motors) is moved)
        for moved in (True, False)
    )
    return replace(
        partition,
        actuated=driven,
        passive=passive,
        row_scale=rows,
        column_scale=columns,
        # The rows that a rod has less than the leg in its place are independent of all others.
        passive_rank=partition.passive_rank - partition.row_scale.size + rows.size,
        size=0.0,  # that of the legs says nothing of rods
    )


def _bounded_problem(
    mechanism: Mechanism,
    model: pin.Model,
    loops: Sequence[Loop],
    partition: Partition,
    base: Array,
) -> SearchProblem:
    tree, edges = ManyPoses(model), edges_of(model)
    geared = [name for loop in loops if isinstance(loop, JointLoop) for name in loop.ends]
    entries = []
    for name in edges:
        if name not in mechanism.spec.actuated:
            joint = model.joints[model.getJointId(name)]
            entries.append((slice(joint.idx_q, joint.idx_q + joint.nq), edges[name]))
    return SearchProblem(
        model=model,
        base=base,
        tree=tree,
        loops=ManyLoops(model, tree, loops, mechanism.parameters),
        closures=tuple(loops),
        values=mechanism.parameters,
        passive=tuple(entries),
        partition=partition,
        tolerance=mechanism.problem.tolerance,
        tool=mechanism.spec.tool,
        sensed=frozenset([*mechanism.spec.actuated, *geared]),
    )


def _copied(source: pin.Model, q: Array, target: pin.Model, base: Array) -> Array:
    """Return `base` of one model with the values that another's q gives to the same joints."""
    result = base.copy()
    for joint in list(source.joints)[1:]:
        name = source.names[joint.id]
        if target.existJointName(name):
            other = target.joints[target.getJointId(name)]
            entries = q[joint.idx_q : joint.idx_q + joint.nq]
            result[other.idx_q : other.idx_q + other.nq] = entries
    return result
