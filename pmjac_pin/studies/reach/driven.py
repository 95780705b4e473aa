"""Driven: a machine driven by what a caller wants of it, its tools or some of its joints.

Driven by its tools it is a mechanism like any other. A chain of virtual joints leads from the world
to where each tool is to be (`tool_chain`), a loop joins the chain's end to the tool, the chain's
joints are the motors and the old motors passive. Then its direct kinematics is the inverse
kinematics of the machine: `close` stays on the working mode as it stays on the assembly mode
elsewhere, `assembly_modes` are the working modes, and it is singular where the machine loses
freedoms of its tools.

Of a configuration of the one, `lifted` makes that of the other, and `original` takes it back; q of
the machine comes first in q, the chains' joints behind it. `values` are the motor values that put
the tools where they are to be.

    goals = read_goals(mechanism, target, tool, task)  # `targets`
    driven = driven_by(mechanism, goals)               # None where no rows tell the tools' poses
    start = driven.lifted(mechanism.home)
    there = driven.mechanism.close(driven.values(goals, mechanism.home), guess=start)
    driven.original(there)

Driven by joints, q stays what it is. `ToolPath` in `tool_path` goes the straight way with limits
and what the motors hold looked at.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import pinocchio as pin

from pmjac_pin.closing.nearby_poses import nearby
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, ClosureError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.loop_spec import FrameLoop, Loop, PointLoop
from pmjac_pin.studies.led_machine import LedMachine
from pmjac_pin.studies.reach.chosen_chains import chosen_chains
from pmjac_pin.studies.reach.gimbal import gimbal_for
from pmjac_pin.studies.reach.goal import Goal, JointGoal, ToolGoal, tool_at
from pmjac_pin.studies.reach.tool_chain import ToolChain
from pmjac_pin.values.arrays import Array

ChoiceOfRows: TypeAlias = Callable[[Mechanism, Sequence[ToolGoal]], tuple[ToolChain, ...] | None]

_RIGID = 1e-9  # of the characteristic length


@dataclass(frozen=True, eq=False)
class Driven:
    """A machine driven by what is wanted of it.

    Attributes
    ----------
    whole : Mechanism
        The machine itself.
    mechanism : Mechanism
        Driven by its tools, or by some of its joints.
    chains : tuple of ToolChain
        Of each tool; none where joints drive.
    """

    whole: Mechanism
    mechanism: Mechanism
    chains: tuple[ToolChain, ...]

    def lifted(self, configuration: Configuration) -> Configuration:
        """Return the machine's pose as one of the machine that is driven."""
        entries = [configuration.q, *_chain_entries(self.whole, configuration.q, self.chains)]
        return self.mechanism.configuration(np.concatenate(entries))

    def original(self, configuration: Configuration) -> Configuration:
        """Return the pose of the machine itself."""
        return self.whole.configuration(configuration.q[: self.whole.nq])

    def values(self, goals: Sequence[Goal], start: Configuration) -> Array:
        """Return the motor values that meet the goals, from a pose of the machine.

        Where an axis is to point somewhere, the tool is turned there the shortest way from there.
        """
        if not self.chains:
            return np.concatenate([goal.values for goal in goals if isinstance(goal, JointGoal)])
        coordinates = self.mechanism.coordinates
        entries = {
            joint.name: joint.entries(*moved).tolist()
            for chain, moved in self._moved(goals, start)
            for joint in chain.joints
            if joint.driven
        }
        q = coordinates.q(entries, self.mechanism.home.q)
        return coordinates.values(q)[self.mechanism.problem.partition.actuated]

    def _moved(
        self, goals: Sequence[Goal], start: Configuration
    ) -> Iterator[tuple[ToolChain, tuple[Array, Array]]]:
        """Yield each chain, and how its tool is to slide and turn since home."""
        tools = [goal for goal in goals if isinstance(goal, ToolGoal)]
        for chain, goal in zip(self.chains, tools, strict=True):
            _, here = tool_at(self.whole, chain.tool, start.q)
            yield chain, chain.moved(goal.pose_from(here))


def driven_by(
    mechanism: Mechanism, goals: Sequence[Goal], chains: ChoiceOfRows = chosen_chains
) -> Driven | None:
    """Return the machine driven by what is wanted; of tools made once for their tasks.

    Parameters
    ----------
    mechanism : Mechanism
    goals : sequence of Goal
    chains : callable
        Which rows of the tools' tasks drive: `chosen_chains`, those in which they can move;
        `whole_chains`, all of them: nothing can be followed by it, but it closes where all that is
        wanted holds; `single_chains`, so that each motor has one freedom: its assembly modes are
        the working modes, and proofs and homotopies take it.

    Returns
    -------
    Driven or None
        None where no rows of the tasks tell the tools' poses: those of a four-bar's coupler, say,
        none of whose coordinates determines the others.
    """
    if tools := [goal for goal in goals if isinstance(goal, ToolGoal)]:
        return _driven_by_tools(mechanism, tools, chains)
    joints = [name for goal in goals if isinstance(goal, JointGoal) for name in goal.joints]
    try:
        return Driven(mechanism, mechanism.driven_by(joints), ())
    except ClosureError:
        return None


def _driven_by_tools(
    mechanism: Mechanism, goals: Sequence[ToolGoal], chains: ChoiceOfRows
) -> Driven | None:
    def made() -> Driven | None:
        chosen = chains(mechanism, goals)
        rigid = all(_is_rigid(mechanism, goal) for goal in goals)
        return _if_it_closes(mechanism, chosen, goals) if chosen and rigid else None

    key = (chains.__name__, *((goal.tool, goal.task) for goal in goals))
    return mechanism.made_once(key, made)


def driven_along(mechanism: Mechanism, goals: Sequence[ToolGoal], turned: Array) -> Driven | None:
    """Return the same driven by numbers: what turns any way does so by three hinges in turn.

    Parameters
    ----------
    mechanism : Mechanism
    goals : sequence of ToolGoal
        One.
    turned : ndarray, shape (N, 3, 3)
        How the tool is to be turned in the world, home included: the hinges do not lock there.

    Returns
    -------
    Driven or None
        None as of `driven_by`.

    Raises
    ------
    ArgumentError
        No three hinges turn so without a lock.
    """
    if (found := driven_by(mechanism, goals)) is None:
        return None
    (chain,) = found.chains
    if chain.turning != "orientation":
        return found
    here = chain.axes.T @ turned @ chain.home.rotation.T @ chain.axes
    if (gimbal := gimbal_for(here)) is None:
        message = "the tool turns about all axes by too much for any three hinges in turn"
        raise ArgumentError(f"{mechanism.name}: {message}: follow its path in parts")
    chains = (replace(chain, gimbal=gimbal),)
    return Driven(mechanism, _mechanism(mechanism, chains, goals), chains)


def _is_rigid(mechanism: Mechanism, goal: ToolGoal) -> bool:
    """Tell whether the points that span a tool stay at their distances."""
    if goal.tool.frame:
        return True
    home, problem = mechanism.home.q, mechanism.problem
    corners = [_spanning_points(mechanism, goal, q) for q in (home, *nearby(problem, home))]
    sides = [np.linalg.norm(one - np.roll(one, 1, axis=0), axis=1) for one in corners]
    return bool(np.ptp(sides, axis=0).max() <= _RIGID * problem.partition.length)


def _if_it_closes(
    mechanism: Mechanism, chains: tuple[ToolChain, ...], goals: Sequence[ToolGoal]
) -> Driven | None:
    try:
        return Driven(mechanism, _mechanism(mechanism, chains, goals), chains)
    except ClosureError:  # its home is singular
        return None


def _mechanism(
    mechanism: Mechanism, chains: Sequence[ToolChain], goals: Sequence[ToolGoal]
) -> Mechanism:
    led, home = LedMachine(mechanism), mechanism.home.q
    welds: list[Loop] = []
    for chain, goal in zip(chains, goals, strict=True):
        carrier = 0
        for joint in chain.joints:
            carrier = led.joint(carrier, joint.joint, joint.place, joint.name, driven=joint.driven)
        end = chain.end if chain.joints else chain.base * chain.end
        for frame, place in _held(mechanism, goal, home):
            target = led.frame(f"{frame} target", carrier, end * place)
            point = bool(goal.tool.points) or chain.turning == "free"
            welds.append((PointLoop if point else FrameLoop)(frames=(frame, target)))
    q = np.concatenate([home, *_chain_entries(mechanism, home, chains)])
    return led.closed(q, before=welds)


def _chain_entries(mechanism: Mechanism, q: Array, chains: Sequence[ToolChain]) -> list[Array]:
    """Return what the chains' joints are where the machine is at q."""
    found = []
    for chain in chains:
        moved = chain.moved(tool_at(mechanism, chain.tool, q)[1])
        found += [joint.entries(*moved) for joint in chain.joints]
    return found


def _held(mechanism: Mechanism, goal: ToolGoal, q: Array) -> list[tuple[str, pin.SE3]]:
    """Return the frames by which a tool is held, and where they are in it at q."""
    if goal.tool.frame:
        return [(goal.tool.frame, pin.SE3.Identity())]
    _, pose = tool_at(mechanism, goal.tool, q)
    corners = _spanning_points(mechanism, goal, q)
    return [
        (name, pin.SE3(np.eye(3), pose.actInv(corner)))
        for name, corner in zip(goal.tool.names, corners, strict=True)
    ]


def _spanning_points(mechanism: Mechanism, goal: ToolGoal, q: Array) -> Array:
    """Return the points that span a tool, by rows, in the world."""
    model, data = mechanism.kinematics.model, mechanism.kinematics.placed(q)
    places = [data.oMf[find_frame(model, name).index].translation for name in goal.tool.names]
    return np.array(places) + mechanism.place
