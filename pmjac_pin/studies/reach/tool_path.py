"""ToolPath: the straight way of a tool, the machine driven by it, and what ends that way.

It is followed by the guarded continuation of `close` on the machine driven by its tool, so it stays
on the working mode. At poses along it the machine's own motors are looked at: joints beyond their
limits end the way where they reach these, and so does a pose at which the motors lose the tool.
That they never do is seen by driving the machine itself by its motors from the start to the end,
or from each pose looked at to the next: that has to lead to the same poses. Where they lead to the
end on a way of their own, past singular poses that the tool's straight way meets, that is told.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

import numpy as np
import pinocchio as pin
from scipy.optimize import minimize_scalar

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ClosureError
from pmjac_pin.rates.factorisation import RANK_TOLERANCE
from pmjac_pin.studies.reach.driven import Driven
from pmjac_pin.studies.reach.goal import Goal
from pmjac_pin.values.arrays import Array, norm

#: What ended the way: its target, a joint's limit, a pose where motors lose the tool, or one where
#: the tool loses a freedom.
EndOfWay = Literal["target", "limit", "lost by its motors", "end of the mode"]

_BETWEEN_LOOKS = 0.25  # lengths or rad, of all joints: between poses that are looked at
_FEWEST, _MOST = 4, 64
_ONE_POSE = 1e-6  # lengths or rad
_LEAST_OF_A_WAY = 1e-12  # of the way
_BISECTIONS = 60
_BESIDE_SINGULAR = 1e-4  # relative singular value of K*
_LOOK_BACK, _LOOK_AHEAD = 1e-3, 4.0  # shares of what is left, and of how far it should be


@dataclass(frozen=True, eq=False)
class Stop:
    """Where a way ended.

    Attributes
    ----------
    configuration : Configuration
        Of the machine itself.
    share : float
        Of the way.
    end : str
    joints : tuple of str
        At their limits.
    """

    configuration: Configuration
    share: float
    end: EndOfWay
    joints: tuple[str, ...] = ()


@dataclass(eq=False)
class ToolPath:
    """The straight way of a machine driven by its tool, from a closed pose towards goals."""

    driven: Driven
    goals: Sequence[Goal]
    start: Configuration
    _known: dict[float, Configuration] = field(default_factory=dict)
    _displacement: Array = field(init=False)

    def __post_init__(self) -> None:
        lifted = self.driven.lifted(self.start)
        mechanism = self.driven.mechanism
        motors = mechanism.problem.partition.actuated
        values = self.driven.values(self.goals, self.start)
        self._known[0.0] = lifted
        motion = np.zeros(mechanism.nv)
        motion[motors] = mechanism.coordinates.motion_to(lifted.q, motors, values)
        self._displacement, self._values = motion, values

    def values(self, share: float) -> Array:
        """Return the motor values of the machine driven by its tool, part of the way."""
        mechanism = self.driven.mechanism
        if share == 1.0:
            return self._values
        q = pin.integrate(
            mechanism.kinematics.model, self._known[0.0].q, share * self._displacement
        )
        return mechanism.coordinates.values(q)[mechanism.problem.partition.actuated]

    def at(self, share: float) -> Configuration:
        """Return the machine's pose part of the way."""
        if share not in self._known:
            before = self._known[max(one for one in self._known if one < share)]
            close, values = self.driven.mechanism.close, self.values(share)
            self._known[share] = close(values, guess=before, enforce_limits=False)
        return self.driven.original(self._known[share])

    def walked(self, limits: bool) -> Stop:
        """Return where the way ends."""
        whole = self._followed()
        samples = self._samples(whole.share)
        stop = self._limited(samples, whole) if limits else whole
        lost = self._lost([one for one in samples if one < stop.share], stop)
        return lost or stop

    def _followed(self) -> Stop:
        """Return where the continuation ends."""
        try:
            return Stop(self.at(1.0), 1.0, "target")
        except ClosureError as error:
            reached, share = error.reached, float(error.share or 0.0)
            if reached is None:
                return Stop(self.start, 0.0, "end of the mode")
            self._known[share] = reached
            return Stop(self.driven.original(reached), share, "end of the mode")

    def _samples(self, share: float, fewest: int = _FEWEST) -> list[float]:
        """Return shares of poses to look at, up to one."""
        mechanism = self.driven.mechanism
        apart = mechanism.problem.difference(self._known[0.0].q, self._known[share].q)
        partition = mechanism.problem.partition
        lengths = norm(apart / partition.column_scale) / partition.length
        count = int(min(max(math.ceil(lengths / _BETWEEN_LOOKS), fewest), _MOST))
        shares = [share * k / count for k in range(1, count)] if share > 0.0 else []
        return [0.0, *shares, share]

    def _limited(self, samples: Sequence[float], whole: Stop) -> Stop:
        """Return where the first joint reaches its limit, or the end of the whole way."""
        before = 0.0
        for share in samples:
            beyond = self.at(share).limits_violated
            if beyond and share == 0.0:
                return Stop(self.start, 0.0, "limit", tuple(beyond))
            if beyond:
                return self._at_limit(before, share)
            before = share
        return whole

    def _at_limit(self, inside: float, outside: float) -> Stop:
        """Return the last pose within limits, by halving."""
        names: tuple[str, ...] = ()
        for _ in range(_BISECTIONS):
            middle = 0.5 * (inside + outside)
            if outside - inside <= _LEAST_OF_A_WAY or not inside < middle < outside:
                break
            inside, outside = (inside, middle) if self._beyond(middle) else (middle, outside)
        names = tuple(self.at(outside).limits_violated)
        return Stop(self.at(inside), inside, "limit", names)

    def _beyond(self, share: float) -> bool:
        return bool(self.at(share).limits_violated)

    def _lost(self, samples: Sequence[float], stop: Stop) -> Stop | None:
        """Return where the motors lose the tool on the way to a stop; None where they never do."""
        if leads(self.start, stop.configuration):
            return None
        shares = [*samples, stop.share]
        for one, other in pairwise(shares):
            if not leads(self.at(one), self.at(other)):
                found = self._last_driven(one, other)
                if found is not None:
                    return Stop(self.at(found), found, "lost by its motors")
        return None

    def turns_over(self, stop: Stop) -> bool:
        """Tell whether the straight way to a stop passes poses at which the motors lose the tool.

        There det K* changes its sign, and motors do not lead from before to behind.
        """
        if not self.start.mechanism.problem.partition.passive.size:
            return False
        poses = [self.at(share) for share in self._samples(stop.share, 1)]
        rates = [_passive_rates(pose) for pose in poses]
        return any(
            _changes_sign(*both) and not leads(*ends)
            for both, ends in zip(pairwise(rates), pairwise(poses), strict=True)
        )

    def _last_driven(self, one: float, other: float) -> float | None:
        """Return up to where motors lead the machine along; None where they do all the way.

        Beside a singular pose the branches that meet there are not told apart, so no such pose
        counts as led to: the last one before leads to it.
        """
        end = other
        for _ in range(_BISECTIONS):
            middle = 0.5 * (one + other)
            if other - one <= _LEAST_OF_A_WAY or not one < middle < other:
                break
            pose = self.at(middle)
            if _sigma(pose) > _BESIDE_SINGULAR and leads(self.at(one), pose):
                one = middle
                if leads(pose, self.at(end)):
                    return None
            else:
                other = middle
        return self._singular_after(one, end)

    def _singular_after(self, share: float, end: float) -> float:
        """Return where K* is singular close after a share, or the share."""
        near = _sigma(self.at(share))
        before = max(0.0, share - _LOOK_BACK * (end - share))
        slope = (_sigma(self.at(before)) - near) / (share - before) if share > before else 0.0
        if not slope > 0.0:
            return share
        bounds = (share, min(end, share + _LOOK_AHEAD * near / slope))
        found = minimize_scalar(
            lambda one: _sigma(self.at(float(one))),
            bounds=bounds,
            method="bounded",
            options={"xatol": _LEAST_OF_A_WAY},
        )
        return float(found.x) if found.fun < RANK_TOLERANCE else share


def _sigma(pose: Configuration) -> float:
    """Return the relative singular value of K* that the rank rests on."""
    return pose.singularity().smallest


def _changes_sign(one: tuple[Array, Array], other: tuple[Array, Array]) -> bool:
    """Tell whether det K* differs in its sign at two poses near each other.

    K* may be of any shape and rank: K*₁ᵀ K*₂ + N₁ N₁ᵀ N₂ N₂ᵀ, with N what idles, is regular between
    near poses as long as K* keeps its rank.
    """
    (first, idle), (second, idle_then) = one, other
    related = first.T @ second + idle @ (idle.T @ idle_then) @ idle_then.T
    return bool(np.linalg.slogdet(related)[0] < 0.0)


def _passive_rates(pose: Configuration) -> tuple[Array, Array]:
    """Return K*, without dimension, and what idles."""
    mechanism = pose.mechanism
    partition = mechanism.problem.partition
    loops = partition.loop_rates(mechanism.kinematics.snapshot(pose.q).constraint_jacobian)
    return loops.scaled[:, partition.passive], loops.passive.right[partition.passive_rank :].T


def leads(one: Configuration, other: Configuration) -> bool:
    """Tell whether its motors lead a machine from one closed pose to another, limits aside."""
    try:
        found = one.mechanism.close(other.actuated, guess=one, enforce_limits=False)
    except ClosureError:
        return False
    return same_pose(found, other)


def same_pose(one: Configuration, other: Configuration) -> bool:
    """Tell whether two closed poses of a machine are the same, but for what idles."""
    mechanism = one.mechanism
    partition = mechanism.problem.partition
    apart = mechanism.problem.difference(one.q, other.q) / partition.column_scale
    if norm(apart) <= _ONE_POSE * partition.length:
        return True
    # What tells modes apart is imported where the joints' values do not do.
    from pmjac_pin.studies.modes.recognition import Recognition  # noqa: PLC0415

    return Recognition([one]).index(other) is not None
