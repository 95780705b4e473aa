"""In which ways a tool can move at all: the generic rank of a task, and which rows it can tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pmjac_pin.closing.nearby_poses import nearby
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.studies.reach.goal import ToolGoal, tool_at
from pmjac_pin.values.arrays import Array, norm

_ROUNDED = 1e-6  # of motions that are of about size 1: as where ranks are judged
_WELL = 1e-2  # of the largest: a block that tells a pose so badly is not asked to


@dataclass(frozen=True, slots=True, eq=False)
class ToolMotions:
    """The twists that closed motions give several tools, at home and poses near it.

    Attributes
    ----------
    linear, angular : tuple of tuple of ndarray
        By pose, then by tool: what counts of their motions, shapes (k, d) and (a, d), in m for
        each unit of the d scaled motions.
    """

    linear: tuple[tuple[Array, ...], ...]
    angular: tuple[tuple[Array, ...], ...]

    @property
    def rows(self) -> int:
        """How many rows there are."""
        return sum(map(len, self.linear[0])) + sum(map(len, self.angular[0]))

    @property
    def rank(self) -> int:
        """How many of these the tools can move in independently, in general."""
        return max(
            _rank(np.vstack([*linear, *angular]))
            for linear, angular in zip(self.linear, self.angular, strict=True)
        )

    def ways(self, tool: int) -> tuple[Array, Array]:
        """Return orthonormal columns of all linear and all angular ways of a tool's, at all poses.

        Shapes (k, ·) and (a, ·), in the axes of the rows.
        """
        return _span([one[tool] for one in self.linear]), _span([one[tool] for one in self.angular])

    def tells(self, blocks: Sequence[Array]) -> bool:
        """Tell whether these rows (·, d), of home, determine all others, and that well."""
        values = factorise(np.vstack(blocks), 1.0).singular_values
        rank = self.rank
        return len(values) >= rank > 0 and bool(values[rank - 1] > _WELL * values[0])


def tool_motions(mechanism: Mechanism, goals: Sequence[ToolGoal]) -> ToolMotions:
    """Return how the tools of these goals move, of their tasks' rows those that count."""
    problem, home = mechanism.problem, mechanism.home.q
    partition = problem.partition
    linear, angular = [], []
    for q in (home, *nearby(problem, home)):
        _, constraint = problem.evaluate(q)
        motions = partition.column_scale[:, None] * partition.factorise_all(constraint).null_space
        straight, turning = [], []
        for goal in goals:
            twists, pose = tool_at(mechanism, goal.tool, q)
            straight.append(goal.task.linear @ twists[:3] @ motions)
            turns = goal.task.angular(pose.rotation) @ twists[3:] @ motions
            turning.append(partition.length * turns)
        linear.append(tuple(straight))
        angular.append(tuple(turning))
    return ToolMotions(tuple(linear), tuple(angular))


def _rank(rows: Array) -> int:
    return factorise(rows, max(1.0, norm(rows)), _ROUNDED).rank


def _span(blocks: Sequence[Array]) -> Array:
    stacked = np.hstack(blocks)
    factors = factorise(stacked, max(1.0, norm(stacked)), _ROUNDED)
    return factors.left[:, : factors.rank]
