"""WorkingModes: all motor values that put a tool at a target, and what that rests on."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.modes.aim import Aim
from pmjac_pin.studies.modes.closed_pose import generator
from pmjac_pin.studies.modes.find import find_modes
from pmjac_pin.studies.modes.modes_found import ModesFound
from pmjac_pin.studies.reach.chosen_chains import single_chains
from pmjac_pin.studies.reach.driven import driven_by
from pmjac_pin.studies.reach.goal import Goal, is_met
from pmjac_pin.studies.reach.motor_values_alike import of_other_values
from pmjac_pin.studies.reach.separate_legs import modes_by_legs
from pmjac_pin.studies.reach.targets import Target, ToolName, read_goals
from pmjac_pin.studies.reach.task import Task
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_flag, check_kind


@dataclass(frozen=True, eq=False, repr=False)
class WorkingModes(ModesFound):
    """The working modes of a machine at a target: a sequence of its Configurations, sorted alike.

    Attributes
    ----------
    configurations : tuple of Configuration
        Of the machine, each with its tools at their targets, by their motor values.
    starts : int
        How many random starts were tried.
    evidence : Evidence
        What it rests on that these are all.
    """

    @property
    def actuated(self) -> Array:
        """The motor values of each mode, shape (k, n), m or rad."""
        return np.array([one.actuated for one in self.configurations])


def working_modes(
    mechanism: Mechanism,
    target: Target,
    *,
    tool: ToolName = None,
    task: Task | None = None,
    mask: Sequence[bool] | None = None,
    rng: np.random.Generator | int | None = None,
    limits: bool = True,
    unseen: float = 2e-3,
    confidence: float = 0.99,
    most_starts: int = 200_000,
    proof: bool = True,
) -> WorkingModes:
    """Find all motor values that put a tool at a target: the solutions of inverse kinematics.

    They are the assembly modes of the machine driven by its tool, and are found as these are:
    `assembly_modes` says how, and what its arguments mean. Each pose is closed by the machine's own
    measure. Poses that differ by full turns of a motor are one; those of other motor values are
    others, though bodies that look the same may be turned over. A prismatic motor counts by its
    own sign: with its limits, as by default, a leg's length is not taken for its negative.

    Parameters
    ----------
    mechanism : Mechanism
    target, tool, task, mask
        As of `reach`.
    rng, limits, unseen, confidence, most_starts, proof
        As of `assembly_modes`.

    Returns
    -------
    WorkingModes
        A sequence of Configurations; `evidence` says what it rests on that these are all.

    Raises
    ------
    ArgumentError
        The target leaves the motors freedom: there are no separate modes.
    UnknownNameError, NoToolError
        As `reach`.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> bar = pj.load("five_bar")
    >>> modes = pj.working_modes(bar, bar.home.tool_pose().translation, rng=0)
    >>> len(modes), modes.evidence.kind
    (4, 'proof')
    """
    check_kind(mechanism, Mechanism)
    goals = read_goals(mechanism, target, tool, task, mask)
    driven = driven_by(mechanism, goals, single_chains)
    if driven is None:
        raise ArgumentError(f"{mechanism.name} cannot be driven by its tool: its home is singular")
    partition = driven.mechanism.problem.partition
    if driven.mechanism.nv > partition.constraint_rank + len(partition.actuated):
        raise ArgumentError("the target leaves the machine freedom: there are no separate modes")
    aim = Aim(unseen, confidence, most_starts, as_flag(proof, "proof"), None)
    values = driven.values(goals, mechanism.home)
    generated, within = generator(rng), as_flag(limits, "limits")
    by_legs = modes_by_legs(driven, values, generated, within, aim)
    if by_legs is not None:
        poses = [driven.original(one) for one in by_legs]
        return _by_order(goals, poses, by_legs.starts, by_legs.evidence)
    modes = find_modes(driven.mechanism, values, generated, within, aim)
    every = (driven.original(one) for one in itertools.chain.from_iterable(modes.poses))
    distinct = of_other_values(every, mechanism.spec.actuated)
    return _by_order(goals, distinct, modes.starts, modes.evidence)


def _by_order(
    goals: Sequence[Goal],
    poses: list[Configuration],
    starts: int,
    evidence: Evidence,
) -> WorkingModes:
    """Return the poses that meet all rows of the target, by their motor values."""
    met = [one for one in poses if is_met(goals, one.mechanism, one.q)]
    met.sort(key=lambda one: tuple((np.round(one.actuated, 6) + 0.0).tolist()))
    if len(met) < len(poses):
        statement = f"{evidence.statement}; of {len(poses)} poses {len(met)} meet all of the target"
        evidence = replace(evidence, statement=statement)
    return WorkingModes(tuple(met), starts, evidence)
