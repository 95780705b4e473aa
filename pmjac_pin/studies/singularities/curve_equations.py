"""CurveEquations: a system whose solutions in a slice are a curve, with Newton's way back to it.

Unknowns are the joints and a vector u of the system's own. Redundant equations vanish with the
others: least squares of the known rank are Newton's method.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.values.arrays import Array, Index, norm

EXACT = 1e-13  # of all equations, without dimension: the next step would be rounding
_NEWTON_STEPS = 30
_LARGEST_STEP = 0.5  # lengths or rad: Newton's first steps may be wild


@dataclass(frozen=True, slots=True, eq=False)
class SingularPoint:
    """A pose and the motion that M does not hold there, singular where the equations vanish.

    Attributes
    ----------
    q : ndarray, shape (nq,)
    u : ndarray, shape (k,)
        On the scaled rates, of unit length.
    idle : ndarray, shape (k, d)
        N, orthonormal columns: to which u is orthogonal.
    """

    q: Array
    u: Array
    idle: Array


class CurveEquations(ABC):
    """A system of equations for the joints of a mechanism and a vector u.

    Parameters
    ----------
    mechanism : Mechanism
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.problem = mechanism, mechanism.problem
        self.partition = mechanism.problem.partition

    @abstractmethod
    def begin(self, q: Array) -> SingularPoint:
        """Return the first guess from a closed q."""

    @abstractmethod
    def residual(self, point: SingularPoint) -> Array:
        """Return what vanishes, dimensionless, all equations."""

    @abstractmethod
    def evaluate(self, point: SingularPoint) -> tuple[Array, Array]:
        """Return the residual (r,), and its derivative (r, nv + k) by q and by u."""

    @abstractmethod
    def turned(self, point: SingularPoint) -> SingularPoint:
        """Return a point with u as it is to be at its own pose."""

    def _resting(self, point: SingularPoint) -> Array:
        """Return the idle motions of the joints on all columns, (nv, d)."""
        partition = self.partition
        idle = partition.passive.size - partition.passive_rank
        found = np.zeros((partition.column_scale.size, idle))
        if idle:
            snapshot = self.mechanism.kinematics.snapshot(point.q)
            loops = partition.loop_rates(snapshot.constraint_jacobian)
            found[partition.passive] = loops.passive.right[partition.passive_rank :].T
        return found

    def moved(self, point: SingularPoint, step: Array) -> SingularPoint:
        """Return the point moved by a step (nv + k,): of q in lengths or rad, then of u."""
        nv = self.partition.column_scale.size
        return replace(
            point,
            q=self.problem.integrate(point.q, self._strides.diagonal() * step[:nv]),
            u=point.u + step[nv:],
        )

    def dimension(self, held: Index) -> int:
        """Return how many ways lead along the locus, with some columns of q held: 1 for a curve.

        Ways on which joints idle alone are none: N borders them.
        """
        partition = self.partition
        idle = partition.passive.size - partition.passive_rank
        return partition.column_scale.size - partition.constraint_rank - idle - held.size - 1

    def bordered(self, point: SingularPoint, held: Index) -> tuple[Array, Array]:
        """Return residual and derivative with columns of q held, and what idles at rest.

        Below those of `evaluate` stand rows that are zero but for the derivative.
        """
        residual, jacobian = self.evaluate(point)
        resting = self._resting(point)
        rows = np.zeros((held.size + resting.shape[1], jacobian.shape[1]))
        rows[np.arange(held.size), held] = 1.0
        rows[held.size :, : resting.shape[0]] = resting.T
        return np.append(residual, np.zeros(len(rows))), np.vstack([jacobian, rows])

    def corrected(
        self, point: SingularPoint, held: Index | None = None, most: float = np.inf
    ) -> SingularPoint | None:
        """Return the singular point near a guess by Newton's method, None where there is none.

        Parameters
        ----------
        point : SingularPoint
        held : ndarray of int, optional
            Columns of q that stay: motors of a slice.
        most : float
            How far all steps may lead together, lengths or rad.
        """
        held = np.zeros(0, dtype=np.intp) if held is None else held
        rank = self.partition.column_scale.size + point.u.size - self.dimension(held)
        spent, before = 0.0, np.inf
        for _ in range(_NEWTON_STEPS):
            residual, jacobian = self.bordered(point, held)
            size = norm(residual)
            if not np.isfinite(size) or spent > most:
                return None
            if size <= EXACT or (size <= 1e2 * EXACT and size > 0.5 * before):
                return point
            left, values, right = np.linalg.svd(jacobian, full_matrices=False)
            if values.size < rank or not values[rank - 1]:
                return None
            step = -right[:rank].T @ ((left[:, :rank].T @ residual) / values[:rank])
            length = norm(step)
            if length > _LARGEST_STEP:
                step *= _LARGEST_STEP / length
            spent, before = spent + min(length, _LARGEST_STEP), size
            point = self.moved(point, step)
        return None

    def tangent(self, point: SingularPoint, held: Index) -> Array:
        """Return the ways that lead along the locus from a singular point, (d, nv + k), rows."""
        _, jacobian = self.bordered(point, held)
        right = np.linalg.svd(jacobian)[2]
        return np.asarray(right[right.shape[0] - self.dimension(held) :])

    @cached_property
    def _strides(self) -> Array:
        """What an unknown of 1 is of each column, m or rad: a diagonal matrix."""
        return np.diag(self.partition.length * self.partition.column_scale)
