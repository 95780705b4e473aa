"""Reach: the motor values that put a tool at a target, on the branch of a guess."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pmjac_pin.closing.motor_values import MotorValues, motor_values
from pmjac_pin.configuration import Configuration
from pmjac_pin.direct_kinematics import Guess, start_of
from pmjac_pin.errors import ClosureError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.reach.driven import Driven, driven_by, held_by
from pmjac_pin.studies.reach.elsewhere import poses_at_target
from pmjac_pin.studies.reach.goal import Goal, Miss, gaps_of
from pmjac_pin.studies.reach.least_motion import least_motion
from pmjac_pin.studies.reach.motor_space import MotorSpace, led
from pmjac_pin.studies.reach.nearest import trail_to_nearest
from pmjac_pin.studies.reach.reached import Reached, Status
from pmjac_pin.studies.reach.targets import Target, ToolName, read_goals
from pmjac_pin.studies.reach.task import Task
from pmjac_pin.studies.reach.tool_path import Stop, ToolPath, same_pose
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_flag, check_kind

_ENOUGH = 1e-9  # of the characteristic length, or rad: a target that is met
_TOLERANCES = 4.0  # of the machine: far from the origin, nothing is closer


def reach(
    mechanism: Mechanism,
    target: Target,
    *,
    tool: ToolName = None,
    task: Task | None = None,
    guess: Guess = "home",
    limits: bool = True,
    posture: MotorValues | None = None,
) -> Reached:
    """Find the motor values that put a tool at a target: inverse kinematics by continuation.

    The tool goes straight to its target, the machine driven by it as by a motor, and stays on the
    guess's working mode as `close` stays on its assembly mode. On the way joints have to keep their
    limits, and motors must not lose the tool: that the machine's own motors lead it there is seen
    by driving it. Rows of the target in which the tool cannot move must fit. Where the straight
    way ends before, or no choice of rows tells the tool's pose, the motors go on downhill, to
    where the tool is nearest, a rad counted as the characteristic length; and closed poses at the
    target are looked for from seeded starts.

    Parameters
    ----------
    mechanism : Mechanism
    target : pin.SE3, array_like (4, 4) or (3,), mapping, or a sequence of these
        A pose, or a position, in the world; coordinates "x", "y", "z" and "angle" (of the tool's x
        axis about z) by name; values of joints by their names; or a target for each of several
        tools, in their order or by their names.
    tool : str, three str, or a sequence of several tools, optional
        The mechanism's own when None.
    task : Task, optional
        What of the target counts: the position where it is one, all of a pose by default.
    guess : str, Configuration or mapping of str to float
        Where to start, as of `Mechanism.close`.
    limits : bool
        Keep within the limits of all joints.
    posture : array_like, shape (n,), or mapping of str to float, optional
        Motor values to be as near to as the target allows, where it leaves freedom; those of the
        guess when None. Motors are counted by their natural rates.

    Returns
    -------
    Reached
        With a status; what cannot be reached is no error.

    Raises
    ------
    ArgumentError, UnknownNameError, NoToolError
        A target, tool, task or posture that is none.
    ClosureError
        The guess does not close.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> arm = pj.load("serial_2r")
    >>> there = pj.reach(arm, {"x": 1.0, "y": 1.0})
    >>> there.status, there.actuated.round(4).tolist()
    ('reached', [...])
    >>> pj.reach(arm, {"x": 3.0, "y": 0.0}).status
    'out of reach'
    """
    check_kind(mechanism, Mechanism)
    goals = read_goals(mechanism, target, tool, task)
    start = start_of(mechanism, guess, mechanism.home.actuated)
    wanted = start.actuated
    if posture is not None:
        wanted = motor_values(mechanism.spec, mechanism.coordinates, posture)
    return _Reach(mechanism, goals, start, as_flag(limits, "limits"), wanted).answer()


@dataclass(frozen=True, eq=False)
class _Reach:
    """One question, from a closed pose."""

    mechanism: Mechanism
    goals: Sequence[Goal]
    start: Configuration
    limits: bool
    wanted: Array

    @cached_property
    def _space(self) -> MotorSpace:
        return MotorSpace(led(self.mechanism), self.goals, self.limits)

    @cached_property
    def _driven(self) -> Driven | None:
        return driven_by(self.mechanism, self.goals)

    def answer(self) -> Reached:
        """Go straight; where that ends, downhill; where that ends, look elsewhere."""
        path = None if self._driven is None else self._path(self._driven)
        if path is None:
            return self._beyond(Stop(self.start, 0.0, "end of the mode"))
        stop = path.walked(self.limits)
        match stop.end:
            case "limit":
                return self._at_limit(stop)
            case "lost by its motors":
                return self._singular(stop)
            case "target" if self._meets(stop.configuration):
                return self._arrived(stop.configuration)
            case _:
                return self._beyond(stop)

    def _path(self, driven: Driven) -> ToolPath | None:
        try:
            return ToolPath(driven, self.goals, self.start)
        except ClosureError:  # far from home, chains that stand for a task do not close
            return None

    def _miss(self, configuration: Configuration) -> Miss:
        return gaps_of(self.goals, self.mechanism, configuration.q).miss

    def _meets(self, configuration: Configuration) -> bool:
        mechanism, miss = self.mechanism, self._miss(configuration)
        length, closed = mechanism.characteristic_length, _TOLERANCES * mechanism.tolerance
        return (
            miss.linear <= _ENOUGH * length + closed
            and miss.angular <= _ENOUGH + closed / length
        )

    def _arrived(self, configuration: Configuration, how: str = "straight") -> Reached:
        """Return the target, after a self-motion where it leaves one."""
        space = self._space
        gap, rates = space.system(self._own(configuration))
        if np.linalg.matrix_rank(rates, tol=1e-9 * np.linalg.norm(rates)) < rates.shape[1]:
            wanted = self.wanted[self._own_motors]
            found = self._back(least_motion(space, self._own(configuration), wanted).configuration)
            configuration = found if self._meets(found) else configuration
        message = f"the target is met, {how}"
        return self._told("reached", configuration, 1.0, message)

    @property
    def _own_motors(self) -> list[int]:
        names = self._space.mechanism.actuated
        return [self.mechanism.actuated.index(name) for name in names]

    def _own(self, configuration: Configuration) -> Configuration:
        """Return a pose of the machine as one by the motors that lead."""
        mechanism = self._space.mechanism
        if mechanism is self.mechanism:
            return configuration
        return mechanism.configuration(configuration.q)

    def _back(self, configuration: Configuration) -> Configuration:
        if configuration.mechanism is self.mechanism:
            return configuration
        return self.mechanism.configuration(configuration.q)

    def _at_limit(self, stop: Stop) -> Reached:
        told = ", ".join(
            f"{name!r} at {self._limit_of(stop.configuration, name)}" for name in stop.joints
        )
        message = f"after {100.0 * stop.share:.4g} % of the way joints reach limits: {told}"
        return self._told("at a limit", stop.configuration, stop.share, message, stop.joints)

    def _limit_of(self, configuration: Configuration, name: str) -> str:
        value = configuration.joint_values[name]
        return f"{value:.6g}"

    def _singular(self, stop: Stop) -> Reached:
        message = f"after {100.0 * stop.share:.4g} % of the way the motors lose the tool"
        return self._told("singular", stop.configuration, stop.share, message)

    def _beyond(self, stop: Stop) -> Reached:
        """Go on by the motors, to where the tool is nearest; look elsewhere if that is not enough."""
        trail = list(trail_to_nearest(self._space, self._own(stop.configuration)))
        nearest = self._back(trail[-1])
        if self._meets(nearest):
            if self._tells_no_branch(stop) or self._connected(trail):
                return self._arrived(nearest, "by a way around")
            return self._elsewhere(stop, nearest)
        found = list(self._found_elsewhere())
        for one in found:
            if self._is_led_to(one) and self._tells_no_branch(stop):
                return self._arrived(one, "where the motors of the guess lead")
        if found:
            return self._elsewhere(stop, found[0])
        miss = self._miss(nearest)
        parts = [f"{miss.linear:.6g} m"] * (miss.linear > 0.0)
        parts += [f"{miss.angular:.6g} rad"] * (miss.angular > 0.0)
        message = f"out of reach: around there the nearest is {' and '.join(parts)} from it"
        return self._told("out of reach", nearest, stop.share, message)

    def _tells_no_branch(self, stop: Stop) -> bool:
        """Tell whether working modes are none of the tool's: no rows tell its pose as it goes."""
        if self._driven is None or stop.end == "target":
            return True
        # From a singular pose, several begin.
        return not stop.share and self._driven.lifted(self.start).singularity().kind != "regular"

    def _connected(self, trail: Sequence[Configuration]) -> bool:
        """Tell whether the tool leads the machine along a trail, on one working mode."""
        assert self._driven is not None
        driven = self._driven
        poses = [self._back(one) for one in trail]
        for one, other in zip(poses, poses[1:], strict=False):
            lifted = driven.lifted(other)
            values = lifted.actuated
            try:
                found = driven.mechanism.close(
                    values, guess=driven.lifted(one), enforce_limits=False
                )
            except ClosureError:
                return False
            if not same_pose(found, lifted):
                return False
        return True

    def _found_elsewhere(self) -> Iterator[Configuration]:
        """Yield closed poses at the target, from seeded starts."""
        held = held_by(self.mechanism, self.goals)
        for found in poses_at_target(held, self.goals, self.start) if held else ():
            if self._meets(found) and not (self.limits and found.limits_violated):
                yield found

    def _is_led_to(self, found: Configuration) -> bool:
        try:
            there = self.mechanism.close(
                found.actuated, guess=self.start, enforce_limits=self.limits
            )
        except ClosureError:
            return False
        return same_pose(there, found)

    def _elsewhere(self, stop: Stop, found: Configuration) -> Reached:
        message = (
            f"after {100.0 * stop.share:.4g} % of the way this branch ends; the machine meets the "
            "target on another"
        )
        return self._told(
            "on another branch", stop.configuration, stop.share, message, elsewhere=found
        )

    def _told(
        self,
        status: Status,
        configuration: Configuration,
        share: float,
        message: str,
        joints: tuple[str, ...] = (),
        elsewhere: Configuration | None = None,
    ) -> Reached:
        miss = self._miss(configuration)
        rests = f"{miss.linear:.2g} m and {miss.angular:.2g} rad from the target"
        evidence = Evidence("tolerance", f"a closed pose, {rests}")
        return Reached(
            status, configuration, miss, share, message, evidence, joints, elsewhere
        )
