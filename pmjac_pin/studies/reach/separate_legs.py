"""Separate legs: with its tool held a parallel machine falls apart, each leg is searched alone.

The body of the tool is hung on the chain that says where the tool is, by the loop that held it
there (`recut`). Then the loops that share no joint any more have nothing to do with each other: the
working modes are all combinations of what each of them allows, 2·2·2 of a Delta, and what is proven
of each is proven of all.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from pmjac_pin.closing.assembly import build_parts
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, ClosureError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.linkage import build, edges_of
from pmjac_pin.model.loop_spec import FrameLoop, JointLoop
from pmjac_pin.model.tool_spec import NO_TOOL
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.modes.aim import Aim
from pmjac_pin.studies.modes.assembly_modes import AssemblyModes
from pmjac_pin.studies.modes.closed_pose import closed_pose
from pmjac_pin.studies.modes.find import find_modes
from pmjac_pin.studies.modes.modes_found import ModesFound
from pmjac_pin.studies.reach.driven import Driven
from pmjac_pin.studies.reach.motor_values_alike import of_other_values
from pmjac_pin.studies.recut import recut
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.groups import sharing_groups

_MOST_COMBINATIONS = 4096
_WEAKEST_LAST = ("proof", "tolerance", "statistics", "nothing")  # the weakest last


def modes_by_legs(
    driven: Driven, values: Array, rng: np.random.Generator, limits: bool, aim: Aim
) -> ModesFound | None:
    """Return the poses at a target; None where the machine does not fall apart into legs."""
    legs = separate_legs(driven)
    if not legs:
        return None
    named = dict(zip(driven.mechanism.spec.actuated, values.tolist(), strict=True))
    found = []
    for leg in legs:
        modes = find_modes(leg, {name: named[name] for name in leg.spec.actuated}, rng, limits, aim)
        poses = _distinct_poses(driven.whole, leg, modes)
        found.append(ModesFound(poses, modes.starts, modes.evidence))
    if math.prod(len(one) for one in found) > _MOST_COMBINATIONS:
        return None
    combined = itertools.product(*found)
    rows = (_together(driven, values, each) for each in combined)
    closed = [closed_pose(driven.mechanism, q, limits) for q in rows]
    together = tuple(one for one in closed if one is not None)
    return ModesFound(
        together, sum(one.starts for one in found), _of_the_weakest(found, len(together))
    )


def separate_legs(driven: Driven) -> list[Mechanism]:
    """Return the legs of a machine driven by its tool, each a mechanism; none if it has but one."""
    joint = _carrier(driven) if driven.chains else ""
    if not joint or not _is_welded(driven):
        return []
    try:
        hung = recut(driven.mechanism, joint)
    except (ArgumentError, ClosureError):  # it cannot be taken apart there
        return []
    groups = _groups_of_loops(hung)
    if len(groups) < 2:
        return []
    if sum(len(columns) for columns, _ in groups) < hung.problem.partition.passive.size:
        return []  # joints in no loop
    return [_machine_of(hung, loops) for _, loops in groups]


def _carrier(driven: Driven) -> str:
    """Return the joint of the tree that carries the one tool's body; none where that is none."""
    model, frames = driven.mechanism.kinematics.model, driven.chains[0].tool.names
    body = find_frame(model, frames[0]).joint
    return model.names[body] if body and len(driven.chains) == len(frames) == 1 else ""


def _is_welded(driven: Driven) -> bool:
    """Tell whether the loop that holds the tool leaves it no freedom."""
    return isinstance(driven.mechanism.spec.loops[0], FrameLoop)


def _groups_of_loops(hung: Mechanism) -> list[tuple[set[int], list[int]]]:
    """Return the loops in groups that share no passive joint, each behind its passive columns."""
    passive = set(hung.problem.partition.passive.tolist())
    columns = [passive & set(moving.tolist()) for moving in hung.kinematics.loops.moving]
    # A loop that no passive joint is left in fits, or the pose that is put together does not close.
    return [
        (moved, group)
        for group in sharing_groups(columns)
        if (moved := set().union(*(columns[number] for number in group)))
    ]


def _machine_of(hung: Mechanism, numbers: Sequence[int]) -> Mechanism:
    """Return the machine with these loops alone, and the joints that lead to them."""
    model, spec, edges = hung.kinematics.model, hung.spec, edges_of(hung.kinematics.model)
    loops = [spec.loops[number] for number in numbers]
    ends = [frame for loop in loops if not isinstance(loop, JointLoop) for frame in loop.ends]
    bodies = {find_frame(model, frame).joint for frame in ends}
    bodies |= {
        edges[name].child for loop in loops if isinstance(loop, JointLoop) for name in loop.ends
    }
    for edge in list(edges.values())[::-1]:  # children come after their parents
        if edge.child in bodies:
            bodies.add(edge.parent)
    kept = [edge for edge in edges.values() if edge.child in bodies]
    names = {edge.name for edge in kept}
    pose = {
        name: value for name, value in hung.coordinates.pose(hung.home.q).items() if name in names
    }
    leg = replace(
        spec,
        loops=tuple(loops),
        actuated=tuple(name for name in spec.actuated if name in names),
        passive=None,
        tool=NO_TOOL,
        poses={"home": pose},
    )
    return Mechanism(build_parts(build(model, kept, {}), leg, {}))


def _distinct_poses(
    whole: Mechanism, leg: Mechanism, modes: AssemblyModes
) -> tuple[Configuration, ...]:
    """Return the poses of a leg that have other values of the machine's motors each."""
    motors = [name for name in whole.spec.actuated if name in leg.coordinates.names]
    poses = itertools.chain.from_iterable(modes.poses)
    return tuple(of_other_values(poses, motors))


def _together(driven: Driven, values: Array, poses: Sequence[Configuration]) -> Array:
    """Return q with the motors at their values and each leg in its pose."""
    mechanism = driven.mechanism
    columns, coordinates = mechanism.problem.partition.actuated, mechanism.coordinates
    q = coordinates.with_values(mechanism.home.q, columns, values)
    for pose in poses:
        entries = pose.mechanism.coordinates.pose(pose.q)
        own = [name for name in entries if name not in mechanism.spec.actuated]
        q = coordinates.q({name: entries[name] for name in own if name in coordinates.names}, q)
    return _carried(driven, q)


def _carried(driven: Driven, q: Array) -> Array:
    """Return q with the tool's body where its chain holds it."""
    mechanism, carrier, frame = driven.mechanism, _carrier(driven), driven.chains[0].tool.names[0]
    model = mechanism.kinematics.model
    edge, tool = edges_of(model)[carrier], find_frame(model, frame)
    data = mechanism.kinematics.placed(q)
    held = driven.mechanism.spec.loops[0].ends[1]
    target = data.oMf[find_frame(model, held).index]
    entries = edge.entries(data.oMi[edge.parent].copy(), target * tool.placement.inverse())
    return mechanism.coordinates.q({carrier: entries}, q)


def _of_the_weakest(legs: Sequence[ModesFound], count: int) -> Evidence:
    """Return what all legs rest on, the weakest of them first."""
    ways = "·".join(str(len(one)) for one in legs)
    weakest = max((one.evidence for one in legs), key=lambda one: _WEAKEST_LAST.index(one.kind))
    statement = (
        f"{count}, of the {ways} combinations of what its legs allow, each for itself while the "
        f"tool is held; of one leg: {weakest.statement}"
    )
    unseen = [one.evidence.unseen for one in legs if one.evidence.unseen is not None]
    told = [one.evidence.confidence for one in legs if one.evidence.confidence is not None]
    return Evidence(
        weakest.kind,
        statement,
        max(unseen, default=None),
        1.0 - sum(1.0 - one for one in told) if told else None,
    )
