"""Driven: a machine driven by what a caller wants of it, its tools or some of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ClosureError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.reach.driven_by_tool import (
    DrivenByTool,
    driven_by_tool,
    searched_by_tool,
    welded_to_tool,
)
from pmjac_pin.studies.reach.goal import Goal, JointGoal, ToolGoal
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, eq=False)
class DrivenByJoints:
    """A machine driven by some of its joints: its q stays what it is.

    Attributes
    ----------
    whole : Mechanism
        The machine itself.
    mechanism : Mechanism
        Driven by these joints.
    """

    whole: Mechanism
    mechanism: Mechanism

    def lifted(self, configuration: Configuration) -> Configuration:
        """Return the pose as one of the machine driven by its joints."""
        return self.mechanism.configuration(configuration.q)

    def original(self, configuration: Configuration) -> Configuration:
        """Return the pose of the machine itself."""
        return self.whole.configuration(configuration.q)

    def values(self, goals: Sequence[Goal], _: Configuration) -> Array:
        """Return the joints' values."""
        joints = [goal.values for goal in goals if isinstance(goal, JointGoal)]
        return np.concatenate(joints)


Driven: TypeAlias = DrivenByTool | DrivenByJoints


def driven_by(mechanism: Mechanism, goals: Sequence[Goal]) -> Driven | None:
    """Return the machine driven by what is wanted; None where no choice of rows tells its pose."""
    if tools := _tool_goals(goals):
        return driven_by_tool(mechanism, tools)
    return _driven_by_joints(mechanism, goals)


def held_by(mechanism: Mechanism, goals: Sequence[Goal]) -> Driven | None:
    """Return the machine that closes where all that is wanted holds; None where there is none."""
    if tools := _tool_goals(goals):
        return welded_to_tool(mechanism, tools)
    return _driven_by_joints(mechanism, goals)


def searched_by(mechanism: Mechanism, goals: Sequence[Goal]) -> Driven | None:
    """Return the machine whose assembly modes are the working modes; None where there is none."""
    if tools := _tool_goals(goals):
        return searched_by_tool(mechanism, tools)
    return _driven_by_joints(mechanism, goals)


def _tool_goals(goals: Sequence[Goal]) -> list[ToolGoal]:
    return [goal for goal in goals if isinstance(goal, ToolGoal)]


def _driven_by_joints(mechanism: Mechanism, goals: Sequence[Goal]) -> DrivenByJoints | None:
    joints = [name for goal in goals if isinstance(goal, JointGoal) for name in goal.joints]
    try:
        return DrivenByJoints(mechanism, mechanism.driven_by(joints))
    except ClosureError:
        return None
