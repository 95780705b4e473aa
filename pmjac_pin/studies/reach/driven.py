"""Driven: a machine driven by what a caller wants of it, its tools or some of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ClosureError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.reach.driven_by_tool import DrivenByTool, driven_by_tool
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

    def lifted(self, configuration: Configuration, _: Sequence[Goal]) -> Configuration:
        """Return the pose as one of the machine driven by its joints."""
        return self.mechanism.configuration(configuration.q)

    def original(self, configuration: Configuration) -> Configuration:
        """Return the pose of the machine itself."""
        return self.whole.configuration(configuration.q)

    def values(self, goals: Sequence[Goal], _: Configuration) -> Array:
        """Return the joints' values."""
        [goal] = goals
        assert isinstance(goal, JointGoal)
        return goal.values


Driven: TypeAlias = DrivenByTool | DrivenByJoints


def driven_by(mechanism: Mechanism, goals: Sequence[Goal]) -> Driven | None:
    """Return the machine driven by what is wanted; None where no choice of rows tells its pose."""
    tools = [goal for goal in goals if isinstance(goal, ToolGoal)]
    if len(tools) == len(goals):
        return driven_by_tool(mechanism, tools)
    [joints] = goals
    assert isinstance(joints, JointGoal)
    try:
        return DrivenByJoints(mechanism, mechanism.driven_by(joints.joints))
    except ClosureError:
        return None
