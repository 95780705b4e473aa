"""WorkingModes: all motor values that put a tool at a target, and what that rests on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import overload

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.modes.aim import Aim
from pmjac_pin.studies.modes.assembly_modes import AssemblyModes
from pmjac_pin.studies.modes.closed_pose import generator
from pmjac_pin.studies.modes.find import find_modes
from pmjac_pin.studies.reach.driven import searched_by
from pmjac_pin.studies.reach.goal import Goal, is_met
from pmjac_pin.studies.reach.targets import Target, ToolName, read_goals
from pmjac_pin.studies.reach.task import Task
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.checks import as_flag, check_kind

_SAME_MOTORS = 1e-6  # rad or characteristic lengths: motor values that count as one


@dataclass(frozen=True, eq=False)
class WorkingModes(Sequence[Configuration]):
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

    configurations: tuple[Configuration, ...]
    starts: int
    evidence: Evidence

    @property
    def actuated(self) -> Array:
        """The motor values of each mode, shape (k, n), m or rad."""
        return np.array([one.actuated for one in self.configurations])

    @overload
    def __getitem__(self, index: int) -> Configuration: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Configuration, ...]: ...
    def __getitem__(self, index: int | slice) -> Configuration | tuple[Configuration, ...]:
        return self.configurations[index]

    def __len__(self) -> int:
        return len(self.configurations)

    def __iter__(self) -> Iterator[Configuration]:
        return iter(self.configurations)

    def __repr__(self) -> str:
        return f"WorkingModes({len(self)} modes, {self.evidence})"


def working_modes(
    mechanism: Mechanism,
    target: Target,
    *,
    tool: ToolName = None,
    task: Task | None = None,
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
    target, tool, task
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
    goals = read_goals(mechanism, target, tool, task)
    driven = searched_by(mechanism, goals)
    if driven is None:
        raise ArgumentError(f"{mechanism.name} cannot be driven by its tool: its home is singular")
    partition = driven.mechanism.problem.partition
    if driven.mechanism.nv > partition.constraint_rank + len(partition.actuated):
        raise ArgumentError("the target leaves the machine freedom: there are no separate modes")
    aim = Aim(unseen, confidence, most_starts, as_flag(proof, "proof"), None)
    values = driven.values(goals, mechanism.home)
    modes = find_modes(driven.mechanism, values, generator(rng), as_flag(limits, "limits"), aim)
    poses = [driven.original(one) for one in _by_motors(mechanism, modes)]
    return _by_order(mechanism, goals, poses, modes)


def _by_motors(mechanism: Mechanism, modes: AssemblyModes) -> Iterator[Configuration]:
    """Yield each pose that has other motor values than those before it in its mode."""
    for ways in modes.poses:
        known: list[Configuration] = []
        for one in ways:
            if not any(_same_motors(mechanism, one, other) for other in known):
                known.append(one)
                yield one


def _same_motors(mechanism: Mechanism, one: Configuration, other: Configuration) -> bool:
    partition, columns = mechanism.problem.partition, mechanism.problem.partition.actuated
    there = mechanism.coordinates.values_of(other.q[: mechanism.nq], columns)
    apart = mechanism.coordinates.motion_to(one.q[: mechanism.nq], columns, there)
    turns = mechanism.coordinates.rotational[columns]
    apart = np.where(turns, np.remainder(apart + np.pi, 2.0 * np.pi) - np.pi, apart)
    return norm(apart / partition.motor_scale) <= _SAME_MOTORS * partition.length


def _by_order(
    mechanism: Mechanism, goals: Sequence[Goal], poses: list[Configuration], modes: AssemblyModes
) -> WorkingModes:
    """Return the poses that meet all rows of the target, by their motor values."""
    met = [one for one in poses if is_met(goals, mechanism, one.q)]
    met.sort(key=lambda one: tuple((np.round(one.actuated, 6) + 0.0).tolist()))
    evidence = modes.evidence
    if len(met) < len(poses):
        statement = f"{evidence.statement}; of {len(poses)} poses {len(met)} meet all of the target"
        evidence = replace(evidence, statement=statement)
    return WorkingModes(tuple(met), modes.starts, evidence)
