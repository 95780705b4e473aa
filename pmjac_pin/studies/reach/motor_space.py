"""Motor space: targets as functions of the motors, the loops closed again at every step.

Every step is a path of `close` from the pose before, so that a walk stays on the assembly mode.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ClosureError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.studies.reach.goal import Goal, gaps_of
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.ties import pivots

#: Of the largest singular value: a tool's motion by the motors that counts as none.
NO_MOTION = 1e-8

_INTO_A_LIMIT = 1.0 + 1e-12  # of a step: where it ends is clipped


@dataclass(frozen=True, slots=True, eq=False)
class MotorSpace:
    """The motors of a machine, of which none is tied to the others, and what is wanted.

    Motors are counted by their natural rates, in m: x = θ / scale.

    Attributes
    ----------
    mechanism : Mechanism
    goals : sequence of Goal
    limits : bool
        Whether limits are kept.
    """

    mechanism: Mechanism
    goals: Sequence[Goal]
    limits: bool

    @property
    def length(self) -> float:
        """The characteristic length, m."""
        return self.mechanism.characteristic_length

    @property
    def scale(self) -> Array:
        """Of the motors, shape (n,)."""
        return self.mechanism.problem.partition.motor_scale

    def system(self, configuration: Configuration) -> tuple[Array, Array]:
        """Return the gaps (rows,), m, and how fast unit motions of the motors close them."""
        mechanism = self.mechanism
        partition, q = mechanism.problem.partition, configuration.q
        _, constraint = mechanism.problem.evaluate(q)
        motions = partition.column_scale[:, None] * partition.factorise_all(constraint).null_space
        motors = motions[partition.actuated] / self.scale[:, None]
        gap, rates = gaps_of(self.goals, mechanism, q).in_metres(self.length)
        factors = factorise(motors, norm(motors), NO_MOTION)
        return gap, rates @ motions @ factors.inverse(factors.rank)

    def moved(self, configuration: Configuration, step: Array) -> Configuration | None:
        """Return the pose a step of the motors away, m, within limits; None where there is none."""
        mechanism, partition = self.mechanism, self.mechanism.problem.partition
        values = configuration.actuated + self.scale * step
        if self.limits:
            lower, upper = self._room
            values = np.clip(values, lower, upper)
        try:
            found = mechanism.close(values, guess=configuration, enforce_limits=False)
        except ClosureError:
            return None
        if self.limits and set(found.limits_violated) - set(configuration.limits_violated):
            return None
        moved = mechanism.problem.difference(configuration.q, found.q) / partition.column_scale
        return found if norm(moved) < self.length else None

    @property
    def _room(self) -> tuple[Array, Array]:
        columns = self.mechanism.problem.partition.actuated
        coordinates = self.mechanism.coordinates
        return coordinates.lower[columns], coordinates.upper[columns]

    def free(self, configuration: Configuration, step: Array) -> Array:
        """Return which motors a step may move, where limits do not hold them: bool, shape (n,)."""
        held = (self.barriers(configuration) * step > 0.0).any(axis=0)
        return np.asarray(~held)

    def barriers(self, configuration: Configuration) -> Array:
        """Return the limits that motors are at, each as the step outwards, shape (k, n)."""
        axes = np.eye(len(configuration.actuated))
        if not self.limits:
            return axes[:0]
        (lower, upper), values = self._room, configuration.actuated
        return np.vstack([axes[values >= upper], -axes[values <= lower]])

    def up_to_limits(self, configuration: Configuration, step: Array) -> Array:
        """Return a step, shortened to where it takes the first motor to a limit."""
        if not self.limits:
            return step
        (lower, upper), values = self._room, configuration.actuated
        left = np.where(step > 0.0, upper - values, lower - values) / self.scale
        going = (left != 0.0) & (step != 0.0)
        share = float(np.min(left[going] / step[going], initial=1.0))
        shortened: Array = step * min(1.0, share * _INTO_A_LIMIT)
        return shortened


def with_leading_motors(mechanism: Mechanism) -> Mechanism:
    """Return the machine with as many motors as freedoms: those that lead, where some are tied."""
    partition, home = mechanism.problem.partition, mechanism.home.q
    freedoms = mechanism.nv - partition.constraint_rank
    if len(partition.actuated) <= freedoms:
        return mechanism
    _, constraint = mechanism.problem.evaluate(home)
    motions = partition.factorise_all(constraint).null_space
    leading = pivots(motions[partition.actuated].T, freedoms)
    names = [mechanism.spec.actuated[k] for k in leading.tolist()]
    return mechanism.driven_by(names)
