"""Factorisation: one rank-revealing look at a matrix, from which everything else is read off."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pmjac_pin.values.arrays import Array, norm

#: A singular value below this times the size of [K K*] counts as zero. Loops closed to 1e-12
#: of the length cannot tell a pose from a singular one nearer than √1e-12: at a fold the residual
#: grows with the square of the distance.
RANK_TOLERANCE = 1e-6
#: Of the size of [K K*]: where a singular value of K* is less, rates are refined.
REFINED = 1e-2

_SURELY = 1.0 - 1e-3  # of a bound that rounding may have moved
_RESOLVED = 1e-9  # of the matrix: above, rounding moves an inverse by less than that


@dataclass(frozen=True, eq=False)
class Factorisation:
    """A = U diag(σ) Vᵀ with the rank that the tolerance gives.

    Of a square matrix that is regular beyond doubt, its inverse tells all that is asked at a
    regular pose: σ_min ≥ 1/‖A⁻¹‖. It takes a fifth of the time; U, σ and V are found when they
    are asked for.

    Attributes
    ----------
    matrix : ndarray, shape (p, k)
    size : float
        What the singular values are compared with.
    tolerance : float
        Relative size up to which they count as zero.
    """

    matrix: Array
    size: float
    tolerance: float

    @cached_property
    def _svd(self) -> tuple[Array, Array, Array]:
        rows, columns = self.matrix.shape
        if not (rows and columns):
            return np.eye(rows), np.zeros(0), np.eye(columns)
        left, values, right = np.linalg.svd(self.matrix)
        return left, values, right

    @cached_property
    def _inverted(self) -> tuple[Array | None, float]:
        """The inverse of a square matrix, where σ_min is above the tolerance, and a bound on it."""
        rows, columns = self.matrix.shape
        if rows != columns or not rows:
            return None, 0.0
        try:
            inverse = np.asarray(np.linalg.inv(self.matrix), dtype=np.float64)
        except np.linalg.LinAlgError:
            return None, 0.0
        # By the largest entry: squares may overflow.
        bound = _SURELY / (rows * float(np.abs(inverse).max()) or math.inf)
        least = max(self.tolerance, _RESOLVED) * max(self.size, norm(self.matrix))
        return (inverse, bound) if bound > least else (None, 0.0)

    @property
    def left(self) -> Array:
        """U, shape (p, p)."""
        return self._svd[0]

    @property
    def singular_values(self) -> Array:
        """σ, shape (min(p, k),), descending."""
        return self._svd[1]

    @property
    def right(self) -> Array:
        """Vᵀ, shape (k, k)."""
        return self._svd[2]

    @cached_property
    def rank(self) -> int:
        """How many singular values are above the tolerance."""
        if self._inverted[0] is not None:
            return len(self.matrix)
        return int(np.count_nonzero(self.singular_values > self.tolerance * self.size))

    def exceeds(self, rank: int, least: float) -> bool:
        """Tell whether the first `rank` singular values are above `least`."""
        inverse, bound = self._inverted
        if inverse is not None and bound > least:
            return True
        return not rank or float(self.singular_values[rank - 1]) > least

    @property
    def null_space(self) -> Array:
        """Orthonormal columns N with A N = 0, shape (k, k − rank)."""
        return self.right[self.rank :].T

    @property
    def left_null_space(self) -> Array:
        """Orthonormal columns W with Wᵀ A = 0, shape (p, p − rank)."""
        return self.left[:, self.rank :]

    def tells_apart(self, rank: int) -> bool:
        """Tell whether the vectors of σ up to `rank` are apart from those of the smaller ones.

        For values that are all as good as zero: with a = σ_rank and b = σ_rank+1 relative to
        `size`, or rounding where that is more, the two spaces are known to b/a. Taken at a pose
        that is singular, and so off by some a, they would be known to a; b < a² is asked for.
        """
        values = np.append(self.singular_values, 0.0) / (self.size or 1.0)
        below = max(float(values[rank]), float(np.finfo(float).eps))
        return below < float(values[rank - 1]) ** 2

    def solve(self, b: Array, rank: int | None = None) -> Array:
        """Return the smallest least-squares solution x of A x = b, by the first `rank` values."""
        r = self.rank if rank is None else rank
        if (inverse := self._inverted[0]) is not None and r == len(inverse):
            return inverse @ b
        projected = (self.left[:, :r].T @ b).T / self.singular_values[:r]
        return self.right[:r].T @ projected.T

    def inverse(self, rank: int) -> Array:
        """Return the pseudoinverse by the first `rank` singular values, shape (k, p)."""
        if (known := self._inverted[0]) is not None and rank == len(known):
            return known
        inverse: Array = (self.right[:rank].T / self.singular_values[:rank]) @ self.left[:, :rank].T
        return inverse


def factorise(matrix: Array, size: float, tolerance: float = RANK_TOLERANCE) -> Factorisation:
    """Factorise a matrix; singular values up to `tolerance` × `size` count as zero.

    Parameters
    ----------
    matrix : ndarray, shape (p, k)
        Either may be zero.
    size : float
        The size of what the matrix is a part of: one vanishing column alone would otherwise
        always have full rank.
    """
    return Factorisation(matrix, size, tolerance)
