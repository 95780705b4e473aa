"""Closed: a pose whose loops are closed, and K* factorised there."""

from __future__ import annotations

from typing import NamedTuple

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.rates.factorisation import Factorisation
from pmjac_pin.values.arrays import Array, norm


class Closed(NamedTuple):
    """A point on a path: closed loops, and K* factorised there, in the anchors' axes.

    Attributes
    ----------
    q : ndarray, shape (nq,)
    gap : float
        m.
    residual, scaled : ndarray, shapes (p,) and (p, nv)
        η in m, and [K K*] without dimension.
    factors : Factorisation
    iterations : int
    """

    q: Array
    gap: float
    residual: Array
    scaled: Array
    factors: Factorisation
    iterations: int


def closed_point(problem: ClosureProblem, q: Array, iterations: int = 0) -> Closed:
    """Evaluate and factorise at a q whose loops are closed."""
    partition, (residual, jacobian) = problem.partition, problem.evaluate(q)
    error = residual * partition.row_scale
    loops = partition.loop_rates(jacobian)
    return Closed(q, norm(error), error, loops.scaled, loops.passive, iterations)
