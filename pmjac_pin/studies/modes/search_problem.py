"""SearchProblem: the passive joints at given motor values, over many poses at once.

Where the mechanism has legs, they are rods here and their joints are found afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from pmjac_pin.closing.scales import column_scale, row_scale
from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.kinematics.many import ManyLoops, ManyPoses
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.linkage import Edge, build, edges_of
from pmjac_pin.model.loop_spec import DistanceLoop, Loop
from pmjac_pin.rates.partition import Partition
from pmjac_pin.studies.modes.leg_reach import reached
from pmjac_pin.studies.modes.legs import Leg, find_legs, names_of
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class SearchProblem:
    """A tree, its loops, and what is unknown.

    Attributes
    ----------
    mechanism : Mechanism
    whole : ndarray, shape (nq,)
        Its home pose, with the motors at their values.
    legs : tuple of Leg
        Those that rods stand for.
    model : pin.Model
        Without them.
    base : ndarray
        The same pose of it.
    tree : ManyPoses
    loops : ManyLoops
    closures : tuple of Loop
        What `loops` are made of: the legs' rods come last.
    passive : tuple of (slice, Edge)
        Each unknown joint's entries in q.
    partition : Partition
        The mechanism's, or with rods in place of the legs.
    """

    mechanism: Mechanism
    whole: Array
    legs: tuple[Leg, ...]
    model: pin.Model
    base: Array
    tree: ManyPoses
    loops: ManyLoops
    closures: tuple[Loop, ...]
    passive: tuple[tuple[slice, Edge], ...]
    partition: Partition

    @property
    def length(self) -> float:
        """The characteristic length, m."""
        return self.partition.length

    @property
    def idle(self) -> int:
        """How many degrees of freedom idle at every pose."""
        return self.partition.passive.size - self.partition.passive_rank

    def with_legs(self, q: Array) -> Array:
        """Return the whole mechanism's q for one of the problem's, its legs reaching their ends."""
        if not self.legs:
            return q
        whole = _copied(self.model, q, self.mechanism.kinematics.model, self.whole)
        for leg in self.legs:
            whole = reached(self.mechanism, leg, whole)
        return whole

    def without_legs(self, q: Array) -> Array:
        """Return the problem's q for one of the whole mechanism's."""
        return _copied(self.mechanism.kinematics.model, q, self.model, self.base)


def search_problem(mechanism: Mechanism, base: Array) -> SearchProblem:
    """Return the problem of a mechanism with its motors as in `base`."""
    legs, own = tuple(find_legs(mechanism, base)), base
    model, loops = mechanism.kinematics.model, mechanism.spec.loops
    partition = mechanism.problem.partition
    if legs:
        model, loops, partition = _with_rods(mechanism, legs)
        own = _copied(mechanism.kinematics.model, base, model, pin.neutral(model))
    entries = []
    for name, edge in edges_of(model).items():
        if name not in mechanism.spec.actuated:
            joint = model.joints[model.getJointId(name)]
            entries.append((slice(joint.idx_q, joint.idx_q + joint.nq), edge))
    tree = ManyPoses(model)
    return SearchProblem(
        mechanism=mechanism,
        whole=base,
        legs=legs,
        model=model,
        base=own,
        tree=tree,
        loops=ManyLoops(model, tree, loops, mechanism.parameters),
        closures=loops,
        passive=tuple(entries),
        partition=partition,
    )


def home_with(mechanism: Mechanism, values: Array) -> Array:
    """Return q of the home pose with the motors at these values."""
    columns = mechanism.problem.partition.actuated
    return mechanism.coordinates.with_values(mechanism.home.q, columns, values)


def _with_rods(
    mechanism: Mechanism, legs: Sequence[Leg]
) -> tuple[pin.Model, tuple[Loop, ...], Partition]:
    """Return the model, its loops and its partition with rods in place of the legs."""
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
    loops, kept = (*stay, *rods), [sizes[id(loop)] for loop in (*stay, *ended)]
    return model, loops, _partition_with_rods(mechanism, model, loops, kept)


def _partition_with_rods(
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
