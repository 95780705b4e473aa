"""Closing the loops from an open start: damped least squares, within the joints' limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pmjac_pin.closing.closure_problem import ROUNDING, ClosureProblem
from pmjac_pin.values.arrays import Array, norm

_LONGEST_STRIDE = 0.5  # of one iteration, in characteristic lengths: joints must not wind up
_HOPELESS = 1e16  # a damping at which the steps are shorter than rounding


@dataclass(frozen=True, slots=True, eq=False)
class Assembled:
    """The best pose that damped least squares found."""

    q: Array
    gap: float
    iterations: int


def unlimited(_: Array) -> tuple[float, float]:
    """Return the room of joints without limits."""
    return np.inf, np.inf


def assemble(
    problem: ClosureProblem,
    q: Array,
    weights: Array,
    limit: int = 400,
    room: Callable[[Array], tuple[Array | float, Array | float]] = unlimited,
    *,
    enough: float = ROUNDING,
) -> Assembled:
    """Close the loops from an open start by damped least squares (Levenberg–Marquardt).

    Parameters
    ----------
    problem : ClosureProblem
    q : ndarray, shape (nq,)
    weights : ndarray, shape (nv,)
        How easily each degree of freedom moves; zero keeps it where it is.
    limit : int
        Number of iterations after which the best pose is returned as it is.
    room : callable
        q ↦ how far each degree of freedom is from its lower and from its upper limit.
    enough : float
        A gap at which nothing is improved any more, of the characteristic length.
    """
    length, row_scale = problem.partition.length, problem.partition.row_scale
    columns, row_column = weights * problem.partition.column_scale, row_scale[:, None]
    residual, jacobian = problem.evaluate(q)
    gap, damping = problem.gap(residual), 1e-3
    for iteration in range(limit):
        if gap <= enough * length:
            return Assembled(q, gap, iteration)
        error, rows = residual * row_scale, row_column * jacobian
        if room is unlimited:
            step = _damped_step(problem, error, rows, columns, damping)
        else:
            below, above = room(q)
            scale = _unheld(columns, columns * (rows.T @ error), below, above)
            step = np.clip(_damped_step(problem, error, rows, scale, damping), -below, above)
        if not step.any():
            return Assembled(q, gap, iteration)
        trial = problem.integrate(q, step)
        trial_residual, trial_jacobian = problem.evaluate(trial)
        trial_gap = problem.gap(trial_residual)
        if trial_gap < gap:
            q, residual, jacobian, gap = trial, trial_residual, trial_jacobian, trial_gap
            damping = max(damping / 8.0, 1e-12)
        elif gap <= problem.tolerance or damping > _HOPELESS:
            return Assembled(q, gap, iteration)
        else:
            damping *= 4.0
    return Assembled(q, gap, limit)


def _unheld(columns: Array, uphill: Array, below: Array | float, above: Array | float) -> Array:
    """Return how easily each degree of freedom moves downhill: not at all, where a limit is."""
    held = ((uphill > 0.0) & (below <= 0.0)) | ((uphill < 0.0) & (above <= 0.0))
    return np.where(held, 0.0, columns)


def _damped_step(
    problem: ClosureProblem, error: Array, rows: Array, scale: Array, damping: float
) -> Array:
    """Return v (nv,), for rows in m and columns moving as easily as `scale` says."""
    # No rank is said here: what vanishes is held back by damping.
    left, values, right = np.linalg.svd(rows * scale, full_matrices=False)
    if not values.size or not (largest := float(values[0])):
        return np.zeros(scale.size)
    partition = problem.partition
    # Damping fades with the gap, which keeps the convergence quadratic at a regular pose
    # and leaves idle and redundant directions, with σ at rounding, alone.
    fading = min(1.0, (norm(error) / partition.length) ** 2)
    squared = damping * largest**2 * fading + (1e-9 * largest) ** 2
    step: Array = -scale * (right.T @ (values / (values**2 + squared) * (left.T @ error)))
    stride = norm(step / partition.column_scale)
    step *= min(1.0, _LONGEST_STRIDE * partition.length / (stride or 1.0))
    return step
