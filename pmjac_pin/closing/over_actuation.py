"""Over-actuation: where loops forbid some motor rates, some motors lead and the others are led.

The loops of a machine with more motors than freedom decide what the last of them do. A straight
line in all motor values is left by the loops at once, even where the values at its end fit. So as
many motors as may move at will walk straight, and the led ones must arrive by themselves. Whether
they do, the walk alone can say; how the motors are tied to each other is known before it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pmjac_pin.closing.closed import Closed, closed_point
from pmjac_pin.closing.closure_problem import ROUNDING, ClosureProblem
from pmjac_pin.closing.step_guard import StepGuard
from pmjac_pin.closing.straight_path import Followed, beside, follow
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.values.arrays import Array, Index, norm
from pmjac_pin.values.ties import pivots

_NO_RATE = 1e-9  # of the largest ratio between rates of motors, or of one to one
_AT_A_FOLD = 1e-12  # relative singular value of K*: that of rounding, on no side of a fold


def walk_led(
    problem: ClosureProblem,
    coordinates: JointCoordinates,
    guard: StepGuard,
    point: Closed,
    values: Array,
) -> Followed:
    """Walk motors of which some are led to their values from a closed pose, on its assembly mode.

    Where they do not arrive at their values, the path ends where it began, and `strayed` says where
    they were led to.

    Parameters
    ----------
    problem : ClosureProblem
        With the generic ranks of the branch that the path begins on.
    coordinates : JointCoordinates
    guard : StepGuard
    point : Closed
    values : ndarray, shape (n,)
        Of the motors, at the end of the path.
    """
    partition, motors = problem.partition, problem.partition.actuated
    displacement = coordinates.motion_to(point.q, motors, values)
    if norm(displacement / partition.motor_scale) <= ROUNDING * partition.length:
        stays = coordinates.with_values(point.q, motors, values)
        return Followed(closed_point(problem, stays), 1.0, 0)
    driven = lead(problem, point)
    columns = driven.problem.partition.actuated

    def at_target(q: Array) -> Array:
        return coordinates.with_values(q, columns, values[driven.leading])

    start = closed_point(driven.problem, point.q)
    path = follow(driven.problem, guard, start, displacement[driven.leading], at_target)
    if path.share < 1.0:
        return path._replace(point=closed_point(problem, path.point.q))
    q = coordinates.with_values(path.point.q, motors, values)
    arrived = beside(problem, path.point.q, q)
    if arrived is None:
        return Followed(point, 0.0, path.iterations, strayed=path.point.q)
    if not _is_led_there(driven.problem, guard, path, arrived):
        return path._replace(point=point, share=0.0, strayed=path.point.q)
    return Followed(arrived, 1.0, path.iterations)


def _is_led_there(
    driven: ClosureProblem, guard: StepGuard, path: Followed, arrived: Closed
) -> bool:
    """Tell whether a pose right beside the end of a path is on the same side of each fold of it.

    The way between them, with the leading motors at rest, is covered then as a step is. At a fold
    itself both sides are one pose.
    """
    partition, there = driven.partition, closed_point(driven, arrived.q)
    if not there.factors.exceeds(partition.passive_rank, _AT_A_FOLD * there.factors.size):
        return True
    at_rest = np.zeros(partition.column_scale.size)
    return path.proven and guard.covers(driven, path.point, there, at_rest, at_rest)


@dataclass(frozen=True, slots=True, eq=False)
class Lead:
    """Which motors lead, and the loops with the led ones passive.

    Attributes
    ----------
    problem : ClosureProblem
    leading, led : ndarray of int
        Among the motors.
    ratios : ndarray, shape (led, leading)
        Rates of the led motors, m/s or rad/s, for each unit of a leading one's.
    """

    problem: ClosureProblem
    leading: Index
    led: Index
    ratios: Array


def lead(problem: ClosureProblem, point: Closed) -> Lead:
    """Return which motors lead on a path from a closed pose: all, where loops forbid nothing."""
    partition = problem.partition
    count = partition.constraint_rank - partition.passive_rank
    motors = np.arange(partition.actuated.size)
    if count <= 0:
        return Lead(problem, motors, motors[:0], np.zeros((0, motors.size)))
    # What K* cannot follow, motors that are led must: those that can do it best.
    left = point.factors.left[:, partition.passive_rank :].T @ point.scaled[:, partition.actuated]
    led = pivots(left, count)
    leading = np.setdiff1d(motors, led)
    ratios = -partition.factorise(left[:, led], point.factors.size).solve(left[:, leading])
    scale = partition.motor_scale
    names = partition.actuated_names
    parted = replace(
        partition,
        actuated=partition.actuated[leading],
        passive=np.concatenate([partition.passive, partition.actuated[led]]),
        actuated_names=tuple(names[k] for k in leading),
        passive_names=partition.passive_names + tuple(names[k] for k in led),
        passive_rank=partition.constraint_rank,
    )
    by_motor = scale[led, None] * ratios / scale[leading]
    return Lead(replace(problem, partition=parted), leading, led, by_motor)


def ties_in_words(problem: ClosureProblem, point: Closed) -> str:
    """Say how the loops tie motors to each other; "" where all may move at will.

    Nothing is said of a singular pose either: what is tied beside it is not known there.
    """
    partition = problem.partition
    driven = lead(problem, point)
    if not driven.led.size or point.factors.rank < partition.passive_rank:
        return ""
    names = partition.actuated_names
    leaders = [names[k] for k in driven.leading]
    ties = [
        _tie(names[k], dict(zip(leaders, ratios, strict=True)))
        for k, ratios in zip(driven.led, driven.ratios.tolist(), strict=True)
    ]
    count = len(ties)
    if not leaders:
        return f"over-actuated by {count}, the loops let no motor move: here {'; '.join(ties)}"
    return f"over-actuated by {count}, the loops tie motors to each other: here {'; '.join(ties)}"


def _tie(led: str, ratios: Mapping[str, float]) -> str:
    """Say at what rate a motor is led, leaving out what rounding makes of nothing."""
    least = _NO_RATE * max(1.0, *map(abs, ratios.values()), 0.0)
    parts = [
        f"{ratio:+.3g} that of {name!r}" for name, ratio in ratios.items() if abs(ratio) > least
    ]
    return f"the rate of {led!r} is {' and '.join(parts)}" if parts else f"{led!r} cannot move"
