"""Closed: a pose whose loops are closed, and K* factorised there."""

from __future__ import annotations

from dataclasses import dataclass

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.rates.factorisation import Factorisation
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.found_once import found_once


@dataclass(eq=False)
class Closed:
    """A point on a path: closed loops, and K* factorised there, when it is asked for.

    Attributes
    ----------
    q : ndarray, shape (nq,)
    gap : float
        m.
    residual, scaled : ndarray, shapes (p,) and (p, nv)
        η in m, and [K K*] without dimension, each loop seen from the body that carries both ends.
    partition : Partition
    iterations : int
    """

    q: Array
    gap: float
    residual: Array
    scaled: Array
    partition: Partition
    iterations: int

    @found_once
    def factors(self) -> Factorisation:
        """K* without dimension."""
        partition, scaled = self.partition, self.scaled
        K_star = scaled.take(partition.passive, axis=1)
        return partition.factorise(K_star, partition.size_of(scaled))


def closed_point(problem: ClosureProblem, q: Array, iterations: int = 0) -> Closed:
    """Evaluate at a q whose loops are closed."""
    partition, (residual, jacobian) = problem.partition, problem.evaluate(q)
    error, scaled = residual * partition.row_scale, jacobian * partition.scale
    return Closed(q, norm(error), error, scaled, partition, iterations)
