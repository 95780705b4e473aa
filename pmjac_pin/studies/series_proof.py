"""SeriesProof: Krawczyk's test along series, over many pieces at once.

At given joint values x, let F(v) = η(x, φ̃(x) ⊕ v), with φ̃ the series and v dimensionless, and A an
approximate inverse of K* in a piece. With

    Y ≥ |A F(0)|,    E ≥ |I − A K*| up to r from the series,    all over the piece,

and Y + E r ≤ r, Krawczyk's test holds at every x of the piece: there is a closed pose within
Y + E r of the series, component by component, and, where moreover ‖E‖ + (1 + ‖E‖) r < 1, no other
one within r. Y is of the order of how far the series is from closed poses, since F(0) is enclosed
by its Taylor polynomial (`SeriesEquations`); E is small where pieces are.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.balls import OUTWARDS
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.series import largest_sizes
from pmjac_pin.rates.partition import Partition
from pmjac_pin.studies.krawczyk import contraction
from pmjac_pin.studies.series_equations import EquationsAlong, SeriesEquations
from pmjac_pin.values.arrays import Array, Index, Mask

_ROUNDS = 12
_WIDER = 20.0  # than a series is off: where no other pose is looked for


@dataclass(frozen=True, slots=True, eq=False)
class ProvenPieces:
    """What holds in each of b pieces, of m unknowns.

    Attributes
    ----------
    good : ndarray of bool, shape (b,)
        Whether there is exactly one closed pose within `radius`.
    radius : ndarray, shape (b,)
    reach : ndarray, shape (b, m)
        How far it is from the series at most, by each unknown.
    norm : ndarray, shape (b,)
        ‖E‖
    inverse : ndarray, shape (b, m, m)
        A
    jacobian : Intervals, shape (b, p, nv)
        [K K*]
    """

    good: Mask
    radius: Array
    reach: Array
    norm: Array
    inverse: Array
    jacobian: Intervals


class SeriesProof:
    """Krawczyk's test of some equations.

    Parameters
    ----------
    equations : SeriesEquations
    partition : Partition
    least_radius : float
        How far at least no other pose is wanted.
    """

    def __init__(
        self, equations: SeriesEquations, partition: Partition, least_radius: float
    ) -> None:
        self._equations, self._partition = equations, partition
        self.least_radius = least_radius

    def of(self, along: EquationsAlong, count: int, rows: Index, columns: Index) -> ProvenPieces:
        """Return what holds in some pieces, of as many rows as columns of K*; others are held."""
        K, _ = self._equations.around(along, np.zeros(count))
        A = self._inverse(self.square(K, rows, columns))
        terms = (term[:, rows][..., None].after(A)[..., 0] for term in along.residual.values())
        Y = largest_sizes(terms)
        first = contraction(A, self.square(K, rows, columns)).magnitude
        with np.errstate(divide="ignore", invalid="ignore"):
            radius = _WIDER * Y.max(axis=1) / (1.0 - first.sum(axis=2).max(axis=1))
        good = np.isfinite(radius) & (radius >= 0.0)
        radius = np.where(good, np.maximum(radius, self.least_radius), 0.0)
        K, cosine = self._equations.around(along, radius)
        E = upwards(contraction(A, self.square(K, rows, columns)).magnitude.sum(axis=2))
        Z = E.max(axis=1)
        good &= upwards(Y + E * radius[:, None]).max(axis=1) <= radius
        good &= (upwards(Z + (1.0 + Z) * radius * self._turns(columns)) < 1.0) & (cosine > 0.0)
        reach, Z = np.where(good, radius, 1.0), np.where(good, Z, 1.0)
        for _ in range(_ROUNDS):  # what is within r is within Y + E r
            reach = np.minimum(reach, upwards(Y + E * reach[:, None]).max(axis=1))
        return ProvenPieces(good, radius, upwards(Y + E * reach[:, None]), Z, A, K)

    def square(self, K: Intervals, rows: Index, columns: Index) -> Intervals:
        """Return some rows and columns of [K K*], those by their natural rates."""
        scale = Intervals.exact(self._partition.column_scale[columns])
        return K[:, rows][:, :, columns] * scale

    def gap(self, along: EquationsAlong, found: ProvenPieces, rows: Index, columns: Index) -> Array:
        """Return how far the rows that are left out are from 0, (b,), in their units."""
        others = np.setdiff1d(np.arange(self._equations.rows), rows)
        if not others.size:
            return np.zeros(len(found.good))
        own = largest_sizes(term[:, others] for term in along.residual.values())
        slopes: Array = found.jacobian[:, others][:, :, columns].magnitude
        slopes = slopes * self._partition.column_scale[columns]
        reach = found.reach.max(axis=1)
        sizes = upwards(own + upwards(slopes.sum(axis=2)) * reach[:, None])
        return np.asarray(sizes.max(axis=1))

    def _turns(self, columns: Index) -> float:
        """Return the largest turn of an unknown of 1."""
        return float(self._partition.column_scale[columns].max(initial=0.0))

    def _inverse(self, square: Intervals) -> Array:
        """Return approximate inverses (b, m, m), 0 where there is none."""
        found = np.zeros(square.shape)
        for inverse, matrix in zip(found, square.middle, strict=True):
            with contextlib.suppress(np.linalg.LinAlgError):
                inverse[:] = np.linalg.inv(matrix)
        return found


def upwards(sizes: Array) -> Array:
    """Return more than exact sums and products of numbers ≥ 0 that came out so."""
    return np.asarray(OUTWARDS * sizes)
