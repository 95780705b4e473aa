"""Closed: a pose whose loops are closed, K* factorised there, and how joints follow motors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.rates.factorisation import Factorisation
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, norm
from pmjac_pin.values.found_once import found_once

NO_INVERSE = 1e-9  # relative singular value of K* at a pose that no step is proven to lead to


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


def is_singular(point: Closed, partition: Partition) -> bool:
    """Tell whether K* is below its generic rank."""
    return point.factors.rank < partition.passive_rank


def is_invertible(point: Closed, partition: Partition) -> bool:
    """Tell whether K* has a pseudoinverse of its generic rank that rounding leaves alone."""
    factors = point.factors
    return factors.exceeds(partition.passive_rank, NO_INVERSE * factors.size)


def path_velocity(point: Closed, displacement: Array, partition: Partition) -> Array:
    """Return v (nv,): the motors' displacement and φ̇ = −K*⁻¹ K θ̇ with it."""
    driving = point.scaled.take(partition.actuated, axis=1)
    moves = point.factors.solve(
        driving.dot(displacement / partition.motor_scale), partition.passive_rank
    )
    velocity = passive_motion(-moves, partition)
    velocity[partition.actuated] = displacement
    return velocity


def passive_motion(moves: Array, partition: Partition) -> Array:
    """Return v (nv,) of the passive joints' moves (m_p,), which are without dimension."""
    velocity = np.zeros(partition.column_scale.size)
    velocity[partition.passive] = moves * partition.passive_scale
    return velocity
