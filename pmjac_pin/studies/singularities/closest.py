"""Closest: the point of a singular locus that is nearest to a pose, by Newton's method along it.

Let T span the ways along the locus at a point (`SingularEquations.tangent`) and F be the weighted
change from the pose. On the locus ½ |F|² has the gradient g = Tᵀ Fₜ, and its Hessian are the
differences of g, carried from nearby points of the locus. Steps go along T and are corrected back.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pmjac_pin.studies.singularities.curve_equations import SingularPoint
from pmjac_pin.studies.singularities.singular_equations import SingularEquations
from pmjac_pin.values.arrays import Array, Index, norm

_MOST_NEARER = 25
_MOST_HALVED = 6
_STATIONARY = 1e-9  # of the distance: how much nearer a step along the locus might lead
_NO_NEARER = 1e-12  # of the distance: by how much a step leads nearer at least
_LEAST_CURVED = 1e-3  # of the largest curvature: along less, steps are no longer than with this
_ASIDE_STEP = 1e-4  # lengths or rad, of differences between gradients
_LONGEST = 0.3  # lengths or rad
_NONE_HELD: Index = np.zeros(0, dtype=np.intp)


@dataclass(frozen=True, slots=True, eq=False)
class Closest:
    """A point of the locus where the distance is stationary, to second order the least nearby.

    Attributes
    ----------
    point : SingularPoint
    change : ndarray, shape (k,)
        F there.
    """

    point: SingularPoint
    change: Array

    @property
    def distance(self) -> float:
        """|F|."""
        return norm(self.change)


class ClosestPoint:
    """The search for what is nearest to a pose.

    Parameters
    ----------
    equations : SingularEquations
    measure : callable
        q ↦ F (k,), and ∂F by q in lengths or rad (k, nv).
    """

    def __init__(
        self, equations: SingularEquations, measure: Callable[[Array], tuple[Array, Array]]
    ) -> None:
        self._equations, self._measure = equations, measure

    def from_start(self, q: Array) -> Closest | None:
        """Return the point that is found from a closed q, None where there is none."""
        point = self._equations.corrected(self._equations.begin(q))
        for _ in range(_MOST_NEARER):
            if point is None or not (ways := self._ways(point)).size:
                break
            step = self._step(point, ways)
            if step is None:
                break
            point = step
        return None if point is None else Closest(point, self._change(point.q))

    def _ways(self, point: SingularPoint) -> Array:
        return self._equations.tangent(point, _NONE_HELD)

    def _step(self, point: SingularPoint, ways: Array) -> SingularPoint | None:
        """Return a nearer point, None where none is."""
        gradient, change = self._gradient(point, ways), self._change(point.q)
        if norm(gradient) <= _STATIONARY * norm(change):
            return None
        curvatures, turned = np.linalg.eigh(self._hessian(point, ways, gradient))
        if not (largest := float(np.abs(curvatures).max())):
            return None
        curvatures = np.maximum(np.abs(curvatures), _LEAST_CURVED * largest)
        downhill = -turned @ ((turned.T @ gradient) / curvatures)
        downhill *= min(1.0, _LONGEST / (norm(downhill) or 1.0))
        for halved in range(_MOST_HALVED):
            tried = self._along(point, 0.5**halved * downhill @ ways)
            if tried is not None and norm(self._change(tried.q)) < (1.0 - _NO_NEARER) * norm(
                change
            ):
                return tried
        return None

    def _along(self, point: SingularPoint, step: Array) -> SingularPoint | None:
        return self._equations.corrected(self._equations.moved(point, step))

    def _gradient(self, point: SingularPoint, ways: Array) -> Array:
        """Return the gradient by ways, as they are at the point."""
        here = self._ways(point)
        slopes: Array = ways @ here.T @ here
        change, by_q = self._measure(point.q)
        return np.asarray(slopes[:, : by_q.shape[1]] @ by_q.T @ change)

    def _change(self, q: Array) -> Array:
        return self._measure(q)[0]

    def _hessian(self, point: SingularPoint, ways: Array, gradient: Array) -> Array:
        columns = []
        for way in ways:
            beside = self._along(point, _ASIDE_STEP * way)
            rise = (
                np.zeros(len(ways)) if beside is None else self._gradient(beside, ways) - gradient
            )
            columns.append(rise / _ASIDE_STEP)
        found = np.array(columns)
        return 0.5 * (found + found.T)
