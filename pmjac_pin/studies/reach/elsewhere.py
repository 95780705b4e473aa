"""Closed poses at a target on whatever branch, from seeded starts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pmjac_pin.closing.damped_closure import assemble, motor_weights
from pmjac_pin.closing.held_motors import SHAKES, shaken
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ClosureError
from pmjac_pin.studies.reach.driven import Driven
from pmjac_pin.studies.reach.goal import Goal

_ITERATIONS = 50  # of least squares, from each start


def poses_at_target(
    driven: Driven, goals: Sequence[Goal], start: Configuration
) -> Iterator[Configuration]:
    """Yield closed poses of the machine with its tools at their targets, the nearer starts first.

    Parameters
    ----------
    driven : Driven
    goals : sequence of Goal
    start : Configuration
        Of the machine itself: the starts are around it.
    """
    mechanism = driven.mechanism
    problem, coordinates = mechanism.problem, mechanism.coordinates
    partition = problem.partition
    lifted = driven.lifted(start)
    values = driven.values(goals, start)
    q = coordinates.with_values(lifted.q, partition.actuated, values)
    weights = motor_weights(problem, 0.0)
    for start_q in shaken(problem, q, (0.0, *SHAKES), weights):
        found = assemble(problem, start_q, weights, _ITERATIONS)
        if found.gap <= problem.tolerance:
            closed = coordinates.unwound(found.q, partition.passive, limits=True)
            try:
                yield driven.original(mechanism.configuration(closed))
            except ClosureError:  # what rounding of full turns has opened
                continue
