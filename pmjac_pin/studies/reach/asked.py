"""Asked: what `reach` is asked for, from which closed pose, and how an answer is told."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ClosureError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.studies.evidence import Evidence
from pmjac_pin.studies.reach.chosen_chains import whole_chains
from pmjac_pin.studies.reach.driven import Driven, driven_by
from pmjac_pin.studies.reach.elsewhere import poses_at_target
from pmjac_pin.studies.reach.goal import Goal, Miss, gaps_of, is_met
from pmjac_pin.studies.reach.least_motion import is_least_motion, least_motion
from pmjac_pin.studies.reach.motor_space import NO_MOTION, MotorSpace, with_leading_motors
from pmjac_pin.studies.reach.nearest import is_nearest, trail_to_nearest
from pmjac_pin.studies.reach.reached import Reached, ReachStatus
from pmjac_pin.studies.reach.tool_path import same_pose
from pmjac_pin.values.arrays import Array, norm

_POSES_BY_MOTORS = 9  # poses on a way of the motors


@dataclass(frozen=True, eq=False)
class Asked:
    """A question of `reach`.

    Attributes
    ----------
    mechanism : Mechanism
    goals : sequence of Goal
    start : Configuration
    limits : bool
    wanted : ndarray, shape (n,)
        Motor values to be near to, where the goals leave freedom.
    """

    mechanism: Mechanism
    goals: Sequence[Goal]
    start: Configuration
    limits: bool
    wanted: Array

    @cached_property
    def driven(self) -> Driven | None:
        """The machine driven by what is wanted; None where no rows of that tell its pose."""
        return driven_by(self.mechanism, self.goals)

    @cached_property
    def _space(self) -> MotorSpace:
        return MotorSpace(with_leading_motors(self.mechanism), self.goals, self.limits)

    def miss(self, configuration: Configuration) -> Miss:
        """Return how far a pose is from what is wanted."""
        return gaps_of(self.goals, self.mechanism, configuration.q).miss

    def meets(self, configuration: Configuration) -> bool:
        """Tell whether a pose is where it is wanted."""
        return is_met(self.goals, self.mechanism, configuration.q)

    def trail_downhill(self, start: Configuration) -> list[Configuration]:
        """Return the poses on the way, by the motors, to where a target is nearest."""
        trail = trail_to_nearest(self._space, self._by_leading_motors(start))
        return [_as_pose_of(self.mechanism, one) for one in trail]

    def is_nearest(self, configuration: Configuration) -> bool:
        """Tell whether the target is nearest here, of all poses around."""
        return is_nearest(self._space, self._by_leading_motors(configuration))

    def with_least_motion(self, configuration: Configuration) -> Configuration:
        """Return the pose at the target nearest to what is wanted of the motors."""
        here = self._by_leading_motors(configuration)
        rates = self._space.system(here)[1]
        if factorise(rates, norm(rates), NO_MOTION).rank == rates.shape[1]:
            return configuration
        found = _as_pose_of(self.mechanism, least_motion(self._space, here, self._wanted))
        if not self.meets(found):  # where limits or a singular pose ended the self-motion
            found = self.trail_downhill(found)[-1]
        return found if self.meets(found) else configuration

    def is_least_motion(self, configuration: Configuration) -> bool:
        """Tell whether no self-motion brings the motors nearer to what is wanted of them."""
        here = self._by_leading_motors(configuration)
        return is_least_motion(self._space, here, self._wanted)

    @property
    def _wanted(self) -> Array:
        names = self._space.mechanism.actuated
        return self.wanted[[self.mechanism.actuated.index(name) for name in names]]

    def _by_leading_motors(self, configuration: Configuration) -> Configuration:
        """Return a pose as one of the machine whose motors are not tied."""
        return _as_pose_of(self._space.mechanism, configuration)

    def poses_elsewhere(self) -> Iterator[Configuration]:
        """Yield closed poses at the target, from seeded starts, within limits."""
        held = driven_by(self.mechanism, self.goals, whole_chains)
        for found in poses_at_target(held, self.goals, self.start) if held else ():
            if self.meets(found) and not (self.limits and found.limits_violated):
                yield found

    def trail_by_motors(self, found: Configuration) -> list[Configuration]:
        """Return poses on the straight way of the motors from the start to a pose; none if it ends.

        Limits of the joints count on the way, too.
        """
        begin, mechanism = self.start, self.mechanism
        columns = mechanism.problem.partition.actuated
        apart = mechanism.coordinates.motion_to(begin.q, columns, found.actuated)
        if mechanism.coordinates.curved[columns].any():
            apart = found.actuated - begin.actuated
        trail = [begin]
        for share in np.linspace(0.0, 1.0, _POSES_BY_MOTORS)[1:]:
            values = begin.actuated + share * apart
            try:
                pose = mechanism.close(values, guess=trail[-1], enforce_limits=False)
            except ClosureError:
                return []
            if self.limits and set(pose.limits_violated) - set(begin.limits_violated):
                return []
            trail.append(pose)
        return trail if same_pose(trail[-1], found) else []

    def told(
        self,
        status: ReachStatus,
        configuration: Configuration,
        share: float,
        message: str,
        **more: tuple[str, ...] | Configuration,
    ) -> Reached:
        """Return the answer, with how far it is from what is wanted."""
        miss = self.miss(configuration)
        rests = f"{miss.linear:.2g} m and {miss.angular:.2g} rad from the target"
        evidence = Evidence("tolerance", f"a closed pose, {rests}")
        return Reached(status, configuration, miss, share, message, evidence, **more)  # type: ignore[arg-type]


def _as_pose_of(mechanism: Mechanism, configuration: Configuration) -> Configuration:
    same = configuration.mechanism is mechanism
    return configuration if same else mechanism.configuration(configuration.q)
