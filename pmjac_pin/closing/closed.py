"""Closed: a pose whose loops are closed, and K* factorised there."""

from __future__ import annotations

from dataclasses import dataclass

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.rates.factorisation import Factorisation
from pmjac_pin.values.arrays import Array, norm


@dataclass(frozen=True, slots=True, eq=False)
class Closed:
    """A point on a path: closed loops, and K* factorised there, in the anchors' axes."""

    q: Array
    gap: float
    residual: Array
    scaled: Array
    factors: Factorisation
    iterations: int


def closed_point(problem: ClosureProblem, q: Array) -> Closed:
    """Evaluate and factorise at a q whose loops are closed."""
    return point_at(problem, q, *problem.evaluate(q), 0)


def point_at(
    problem: ClosureProblem, q: Array, residual: Array, jacobian: Array, iterations: int
) -> Closed:
    """Factorise at a q whose loops and their Jacobian are known."""
    partition = problem.partition
    scaled, error = partition.scaled(jacobian), residual * partition.row_scale
    factors = partition.factorise(scaled.take(partition.passive, axis=1), partition.size_of(scaled))
    return Closed(q, norm(error), error, scaled, factors, iterations)
