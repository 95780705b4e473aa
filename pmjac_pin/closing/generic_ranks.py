"""Generic ranks: those of the branch of the configuration space that a pose lies on.

Loops may close in several families of poses, branches, which meet at singular poses or nowhere, and
not all of them need have the same ranks: a rhombus with its arms folded together turns about its
tip, with the motors locked, and on its other branch it does not. Home's ranks say nothing of a pose
on a branch of more rank: what is idle at home moves with the motors there, and what is tied at home
is free. On a branch the rank is nowhere more than the generic one, and that shows where a pose does
not belong: by ranks that it has, or by those that it gets where it is moved a little.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import chain, islice

import numpy as np

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.damped_closure import assemble
from pmjac_pin.closing.idle_motions import rank_changes
from pmjac_pin.closing.nearby_poses import FARTHEST, nearby, reach_of_joints
from pmjac_pin.kinematics.pinocchio import Kinematics
from pmjac_pin.rates.partition import LoopRates
from pmjac_pin.values.arrays import Array

_BESIDE_REST = 1e-3  # of the length or rad: where the tool may move that rests at a pose
_ENOUGH = 3  # poses of the generic rank from which it is tried whether all joints can move


def ranked(problem: ClosureProblem, kinematics: Kinematics, q: Array) -> ClosureProblem:
    """Return the problem with the generic ranks of a closed pose and of those near it."""
    partition = replace(problem.partition, size=0.0)
    problem = replace(problem, partition=partition)
    poses = [q, *nearby(problem, q)]
    snapshots = [kinematics.snapshot(pose) for pose in poses]
    partition = partition.sized(snapshot.constraint_jacobian for snapshot in snapshots)
    rows = partition.tool_rows
    judged = [
        partition.at_pose(snapshot.constraint_jacobian, snapshot.judged_jacobian(rows))
        for snapshot in snapshots
    ]
    generic = partition.with_ranks_of(judged)
    problem = replace(problem, partition=generic)
    regular = (
        near
        for near, pose in zip(poses, judged, strict=True)
        if pose.motion.whole.rank == generic.constraint_rank
    )
    reach = _farthest(problem, islice(regular, _ENOUGH))
    return replace(problem, partition=replace(generic, reach=reach))


def on_branch_of(
    problem: ClosureProblem, kinematics: Kinematics, q: Array, rates: LoopRates
) -> ClosureProblem:
    """Return the problem with the generic ranks of the branch that a closed pose lies on.

    Parameters
    ----------
    problem : ClosureProblem
        With home's ranks: the same is returned where no more than these are met.
    kinematics : Kinematics
    q : ndarray, shape (nq,)
    rates : LoopRates
        There, by the problem's partition.
    """
    partition = problem.partition
    if not (
        _exceeds(problem, rates)
        # Where K* can have more than at home, it may get another rank beside the pose.
        or (not partition.full and rank_changes(problem, q, rates))
        or (not partition.tool_full and _tool_may_exceed(problem, kinematics, q, rates))
    ):
        return problem
    found = ranked(problem, kinematics, q)
    more = any(
        there > here
        for there, here in zip(
            found.partition.generic_ranks, problem.partition.generic_ranks, strict=True
        )
    )
    return found if more else problem


def _exceeds(problem: ClosureProblem, rates: LoopRates) -> bool:
    """Tell whether a rank at a pose is more than the generic one."""
    partition, passive = problem.partition, rates.passive
    if passive.rank != partition.passive_rank:
        return passive.rank > partition.passive_rank or _exceeds_in_all(problem, rates)
    if passive.rank == len(rates.scaled):
        return False
    # [K K*] has more where K* cannot follow K.
    followed = rates.not_followed <= partition.rank_tolerance * rates.size
    if partition.constraint_rank == passive.rank and followed:
        return False
    return _exceeds_in_all(problem, rates)


def _exceeds_in_all(problem: ClosureProblem, rates: LoopRates) -> bool:
    partition = problem.partition
    return partition.factorise(rates.scaled, rates.size).rank > partition.constraint_rank


def _tool_may_exceed(
    problem: ClosureProblem, kinematics: Kinematics, q: Array, rates: LoopRates
) -> bool:
    """Tell whether the tool moves in more ways than at home, at a pose of home's ranks or beside.

    Where [K K*] drops, branches meet, and what the tool seems to do is of none.
    """
    partition = problem.partition
    whole = partition.factorise(rates.scaled, rates.size)
    if whole.rank < partition.constraint_rank:
        return False
    strides = _BESIDE_REST * partition.length * partition.column_scale[:, None] * whole.null_space
    displaced = (problem.integrate(q, way * v) for v in strides.T for way in (1.0, -1.0))
    beside = (assemble(problem, there, np.ones(len(strides)), limit=50) for there in displaced)
    closed = chain([q], (pose.q for pose in beside if pose.gap <= problem.tolerance))
    return any(_tool_rank(problem, kinematics, pose) > partition.tool_rank for pose in closed)


def _tool_rank(problem: ClosureProblem, kinematics: Kinematics, q: Array) -> int:
    """Return the rank of the tool's motion at a closed pose; 0 where [K K*] drops."""
    partition, snapshot = problem.partition, kinematics.snapshot(q)
    whole = partition.factorise_all(snapshot.constraint_jacobian)
    if whole.rank < partition.constraint_rank:
        return 0
    tool = partition.tool_motion(snapshot.judged_jacobian(partition.tool_rows))
    return tool.commanded(whole, partition.gap, partition.actuated).seen_rank()


def _farthest(problem: ClosureProblem, poses: Iterable[Array]) -> float:
    """Return how far all joints can be displaced from one of these poses: enough is enough."""
    farthest = 0.0
    for q in poses:
        farthest = max(farthest, reach_of_joints(problem, q))
        if farthest >= FARTHEST:
            break
    return farthest
