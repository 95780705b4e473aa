"""Closing the loops from an open start: damped least squares, within the joints' limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.one_thread import one_thread_from
from pmjac_pin.closing.closure_problem import ROUNDING, ClosureProblem
from pmjac_pin.closing.levenberg_marquardt import Patience, by_singular_values, descend
from pmjac_pin.values.arrays import Array, norm

_LONGEST_STRIDE = 0.5  # of one iteration, in characteristic lengths: joints must not wind up
_HOPELESS = 4e16  # a damping at which the steps are shorter than rounding


@dataclass(frozen=True, slots=True, eq=False)
class Assembled:
    """The best pose that damped least squares found."""

    q: Array
    gap: float
    iterations: int


def unlimited(_: Array) -> tuple[float, float]:
    """Return the room of joints without limits."""
    return np.inf, np.inf


def motor_weights(problem: ClosureProblem, motor_weight: float) -> Array:
    """Return how easily each degree of freedom moves: passive ones 1, motors as given."""
    weights = np.ones(problem.partition.column_scale.size)
    weights[problem.partition.actuated] = motor_weight
    return weights


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
    patience = Patience(
        steps=limit,
        enough=enough * problem.partition.length,
        tolerance=problem.tolerance,
        damping=1e-3,
        least=1e-12,
        most=_HOPELESS,
        shrinks=8.0,
        grows=4.0,
        grows_within=np.inf,  # closed, and no further
    )
    with one_thread_from(weights.size):
        end = descend(_OnePose(problem, weights, room), q, patience)
    return Assembled(end.q, float(end.gap), int(end.iterations))


class _OnePose:
    """The loops of one pose: what is to be closed."""

    __slots__ = ("_columns", "_problem", "_room", "_row_column", "_row_scale")

    solution = staticmethod(by_singular_values)

    def __init__(
        self,
        problem: ClosureProblem,
        weights: Array,
        room: Callable[[Array], tuple[Array | float, Array | float]],
    ) -> None:
        self._problem, self._room = problem, room
        self._columns = weights * problem.partition.column_scale
        self._row_scale = problem.partition.row_scale
        self._row_column = self._row_scale[:, None]

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Return η in m and its rows."""
        residual, jacobian = self._problem.evaluate(q)
        return residual * self._row_scale, self._row_column * jacobian

    def ease(self, q: Array, error: Array, rows: Array, _: Array | None) -> Array:
        """Return the scales of the columns: no joint moves on downhill where a limit is."""
        if self._room is unlimited:
            return self._columns
        uphill = self._columns * (rows.T @ error)
        below, above = self._room(q)
        held = ((uphill > 0.0) & (below <= 0.0)) | ((uphill < 0.0) & (above <= 0.0))
        return np.where(held, 0.0, self._columns)

    def fading(self, gap: Array) -> Array:
        """Return the square of the gap, in characteristic lengths.

        That keeps the convergence quadratic at a regular pose and leaves idle and redundant
        directions, with σ at rounding, alone.
        """
        return np.minimum(1.0, (gap / self._problem.partition.length) ** 2)

    def bounded(self, q: Array, step: Array) -> Array:
        """Return a step within the joints' limits, no longer than a stride."""
        partition = self._problem.partition
        stride = norm(step / partition.column_scale)
        step = step * min(1.0, _LONGEST_STRIDE * partition.length / (stride or 1.0))
        if self._room is unlimited:
            return step
        below, above = self._room(q)
        return np.clip(step, -below, above)

    def moved(self, q: Array, step: Array) -> Array:
        """Return q ⊕ v."""
        return self._problem.integrate(q, step)
