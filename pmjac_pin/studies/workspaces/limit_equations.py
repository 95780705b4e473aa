"""LimitEquations: the closed poses of a slice at which one joint is at its limit, a curve."""

from __future__ import annotations

import numpy as np

from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.singularities.curve_equations import CurveEquations, SingularPoint
from pmjac_pin.values.arrays import Array


class LimitEquations(CurveEquations):
    """η(q) = 0 with a degree of freedom at a value; u has no entries.

    Parameters
    ----------
    mechanism : Mechanism
    name : str
        Of the degree of freedom.
    value : float
        m or rad.
    """

    def __init__(self, mechanism: Mechanism, name: str, value: float) -> None:
        super().__init__(mechanism)
        self.name, self.value = name, value
        self._column = np.array([self.partition.columns[name]])

    def begin(self, q: Array) -> SingularPoint:
        """Return the closed pose itself."""
        return SingularPoint(q, np.zeros(0), np.zeros((0, 0)))

    def turned(self, point: SingularPoint) -> SingularPoint:
        """Return the point itself."""
        return point

    def residual(self, point: SingularPoint) -> Array:
        """Return η and how far the joint is from its limit, dimensionless."""
        partition, column = self.partition, self._column
        snapshot = self.mechanism.kinematics.snapshot(point.q)
        gap = snapshot.residual * partition.row_scale / partition.length
        return np.append(gap, self.missing(point.q) / self._strides.diagonal()[column])

    def missing(self, q: Array) -> Array:
        """Return how far the joint is beyond its limit at poses (..., nq), less full turns."""
        coordinates = self.mechanism.coordinates
        away: Array = coordinates.values_of(q, self._column) - self.value
        if coordinates.angles[self._column[0]]:
            away = np.remainder(away + np.pi, 2.0 * np.pi) - np.pi
        return away

    def evaluate(self, point: SingularPoint) -> tuple[Array, Array]:
        """Return the residual (p + 1,) and its derivative (p + 1, nv)."""
        snapshot = self.mechanism.kinematics.snapshot(point.q)
        row = np.zeros((1, self.partition.column_scale.size))
        row[0, self._column] = 1.0
        constraint = self.partition.scaled(snapshot.constraint_jacobian)
        return self.residual(point), np.vstack([constraint, row])
