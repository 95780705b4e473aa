"""ClosedPose: what a search took for closed, closed by Pinocchio's measure; and a mode's place."""

from __future__ import annotations

import numpy as np

from pmjac_pin.closing.damped_closure import assemble, motor_weights
from pmjac_pin.closing.newton_correction import polished
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.modes.gear_trains import gear_trains, unwound
from pmjac_pin.values.arrays import Array


def closed_pose(mechanism: Mechanism, q: Array, limits: bool) -> Configuration | None:
    """Return the closed pose by Pinocchio's measure, None where it is none or beyond limits."""
    problem, coordinates = mechanism.problem, mechanism.coordinates
    weights = motor_weights(problem, 0.0)
    closed = assemble(problem, q, weights)
    if closed.gap > problem.tolerance:
        return None
    q = closed.q
    if problem.given_tolerance is None:
        # Within a tolerance that a small loop or a far place widens, one mode is many poses.
        q = polished(problem, q)
    columns = problem.partition.passive
    trains = gear_trains(mechanism.kinematics.model, mechanism.spec.loops, mechanism.spec.actuated)
    found, q = q, unwound(coordinates, trains, q, columns, limits)
    if limits and coordinates.outside(coordinates.values(q)[columns], columns):
        return None
    # Full turns taken off an angle change its last digits, and far away by more than the tolerance.
    if problem.gap(problem.evaluate(q)[0]) > problem.tolerance:
        again = assemble(problem, q, weights)
        q = again.q if again.gap <= problem.tolerance else found
    return Configuration._of_q(mechanism, q)


def open_by(mechanism: Mechanism, q: Array) -> float:
    """Return the least gap near what a search took for closed, m; 0 within the tolerance."""
    problem = mechanism.problem
    gap = assemble(problem, q, motor_weights(problem, 0.0)).gap
    return gap if gap > problem.tolerance else 0.0


def order(configuration: Configuration, length: float) -> tuple[float, ...]:
    """Return what modes are sorted by: the tool's height first, highest first.

    Without a tool they are by the joints' values.
    """
    if configuration.mechanism.spec.tool.is_none:
        return tuple((np.round(configuration.passive, 6) + 0.0).tolist())
    pose = configuration.tool_pose()
    x, y, z = np.round(pose.translation / length, 6) + 0.0
    return (-z, x, y, *(np.round(pose.rotation.ravel(), 6) + 0.0))


def generator(rng: np.random.Generator | int | None) -> np.random.Generator:
    """Return the generator, or the one that a seed makes."""
    try:
        return np.random.default_rng(rng)
    except (TypeError, ValueError):
        wanted = "a numpy Generator or a whole number ≥ 0"
        raise ArgumentError(f"rng is {wanted}, got {quoted(rng)}") from None
