"""Driven: a machine driven by what a caller wants of it, its tools or some of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ClosureError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.reach.chosen_chains import chosen_chains
from pmjac_pin.studies.reach.driven_by_tool import ChoiceOfRows, DrivenByTool, driven_by_tool
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


def driven_by(
    mechanism: Mechanism, goals: Sequence[Goal], chains: ChoiceOfRows = chosen_chains
) -> Driven | None:
    """Return the machine driven by what is wanted; None where that does not tell its pose.

    Parameters
    ----------
    mechanism : Mechanism
    goals : sequence of Goal
    chains : callable
        Which rows of the tools' tasks drive: `chosen_chains`, those in which they can move;
        `whole_chains`, all of them: nothing can be followed by it, but it closes where all that is
        wanted holds; `single_chains`, so that each motor has one freedom: its assembly modes are
        the working modes, and proofs and homotopies take it.
    """
    if tools := [goal for goal in goals if isinstance(goal, ToolGoal)]:
        return driven_by_tool(mechanism, tools, chains)
    joints = [name for goal in goals if isinstance(goal, JointGoal) for name in goal.joints]
    try:
        return DrivenByJoints(mechanism, mechanism.driven_by(joints))
    except ClosureError:
        return None
