"""Which of a task's rows drive a machine: those in which its tools move; the others must fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.studies.reach.gimbal import PLAIN_GIMBAL
from pmjac_pin.studies.reach.goal import ToolGoal, tool_at
from pmjac_pin.studies.reach.tool_chain import ChainTurning, ToolChain
from pmjac_pin.studies.reach.tool_motions import ToolMotions, tool_motions
from pmjac_pin.values.arrays import Array


def chosen_chains(mechanism: Mechanism, goals: Sequence[ToolGoal]) -> tuple[ToolChain, ...] | None:
    """Return the chains of rows that tell the tools' poses, None where no choice of rows does.

    All rows of the tasks, where the tools move in all of them independently. Where they do not: the
    axes along and about which they move at all, as of a planar machine asked for a pose in space;
    or the orientations alone, or the positions alone, where the other rows follow from these.
    """
    motions = tool_motions(mechanism, goals)
    homes = _homes(mechanism, goals)
    if not motions.rank:
        return None
    if motions.rows == motions.rank:
        return whole_chains(mechanism, goals)
    ways = [motions.ways(k) for k in range(len(goals))]
    split = [
        _split(*one, *way) for one, way in zip(zip(goals, homes, strict=True), ways, strict=True)
    ]
    chains = [one for one in split if one is not None]
    if len(chains) == len(split) and sum(map(_driven_rows, chains)) == motions.rank:
        return tuple(chains)
    return _one_block(motions, goals, homes)


def _driven_rows(chain: ToolChain) -> int:
    """Return how many rows of a task drive a chain."""
    driven = sum(int(joint.joint.nv) for joint in chain.joints if joint.driven)
    return driven - (chain.turning == "pointing")  # a ball says more than where an axis points


def whole_chains(mechanism: Mechanism, goals: Sequence[ToolGoal]) -> tuple[ToolChain, ...]:
    """Return the chains of all rows of the tasks."""
    homes = _homes(mechanism, goals)
    return tuple(_of_all_rows(goal, home) for goal, home in zip(goals, homes, strict=True))


def single_chains(mechanism: Mechanism, goals: Sequence[ToolGoal]) -> tuple[ToolChain, ...]:
    """Return the chosen chains, or those of all rows, of joints with one freedom each."""
    chains = chosen_chains(mechanism, goals) or whole_chains(mechanism, goals)
    return tuple(
        replace(chain, singly=True, gimbal=PLAIN_GIMBAL, turning=_held_turning(chain, goal))
        for chain, goal in zip(chains, goals, strict=True)
    )


def _held_turning(chain: ToolChain, goal: ToolGoal) -> ChainTurning:
    """Return what of a tool's turn is commanded: that it has none, where it never turns."""
    never = chain.turning == "free" and goal.task.turning == "orientation"
    return "none" if never and chain.slides == 3 else chain.turning


def _homes(mechanism: Mechanism, goals: Sequence[ToolGoal]) -> list[pin.SE3]:
    return [tool_at(mechanism, goal.tool, mechanism.home.q)[1] for goal in goals]


def _of_all_rows(goal: ToolGoal, home: pin.SE3) -> ToolChain:
    """Return the chain of all rows of a task."""
    task = goal.task
    points = goal.tool.points and task.turning == "free"
    turning: ChainTurning = "swivel" if points else task.turning
    slides = len(task.directions)
    axes = _completed(task.linear.T)
    return ToolChain(goal.tool, home, axes, slides, slides < 3, turning, np.array(task.axis))


def _split(goal: ToolGoal, home: pin.SE3, linear: Array, angular: Array) -> ToolChain | None:
    """Return the chain of the ways in which a tool moves: linear (k, ·) and angular (a, ·)."""
    task, axis = goal.task, np.array(goal.task.axis)
    turning, count = task.turning, angular.shape[1]
    chosen: ChainTurning
    if not count:
        chosen = "swivel" if goal.tool.points else "free"
    elif count == len(angular):
        chosen = turning
    elif count == 1 and turning == "orientation":
        chosen, axis = "hinge", angular[:, 0]
    else:
        return None
    axes = _completed(task.linear.T @ linear)
    floats = len(task.directions) < 3
    return ToolChain(goal.tool, home, axes, linear.shape[1], floats, chosen, axis)


def _one_block(
    motions: ToolMotions, goals: Sequence[ToolGoal], homes: Sequence[pin.SE3]
) -> tuple[ToolChain, ...] | None:
    """Return the chains of all orientations alone, or of all positions, if one tells the other."""
    none = np.zeros((0, 0))
    if sum(map(len, motions.angular[0])) == motions.rank and motions.tells(motions.angular[0]):
        return tuple(
            ToolChain(
                goal.tool, home, np.eye(3), 0, True, goal.task.turning, np.array(goal.task.axis)
            )
            for goal, home in zip(goals, homes, strict=True)
        )
    split = [
        _split(goal, home, motions.ways(k)[0], none)
        for k, (goal, home) in enumerate(zip(goals, homes, strict=True))
    ]
    chains = [one for one in split if one is not None]
    if sum(map(_driven_rows, chains)) == motions.rank and motions.tells(motions.linear[0]):
        return tuple(chains)
    return None


def _completed(columns: Array) -> Array:
    """Return a rotation (3, 3) whose first columns are these, orthonormal already."""
    if not columns.shape[1]:
        return np.eye(3)
    axes = np.column_stack([columns, factorise(columns.T, 1.0).null_space])
    if np.linalg.det(axes) < 0.0:
        axes[:, -1] *= -1.0
    return np.asarray(axes)
