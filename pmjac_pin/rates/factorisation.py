"""Factorisation: one rank-revealing look at a matrix, from which everything else is read off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.values.arrays import Array

#: A singular value below this times the size of [K K*] counts as zero. Loops closed to 1e-12
#: of the length cannot tell a pose from a singular one nearer than √1e-12: at a fold the residual
#: grows with the square of the distance.
RANK_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Factorisation:
    """A = U diag(σ) Vᵀ with the rank that the tolerance gives.

    Attributes
    ----------
    left : ndarray, shape (p, p)
        U.
    singular_values : ndarray, shape (min(p, k),)
        σ, descending.
    right : ndarray, shape (k, k)
        Vᵀ.
    rank : int
    size : float
        What the singular values are compared with.
    """

    left: Array
    singular_values: Array
    right: Array
    rank: int
    size: float

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
        projected = (self.left[:, :r].T @ b).T / self.singular_values[:r]
        return self.right[:r].T @ projected.T

    def inverse(self, rank: int) -> Array:
        """Return the pseudoinverse by the first `rank` singular values, shape (k, p)."""
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
    if 0 in matrix.shape:
        rows, columns = matrix.shape
        return Factorisation(np.eye(rows), np.zeros(0), np.eye(columns), 0, size)
    left, values, right = np.linalg.svd(matrix)
    rank = int(np.count_nonzero(values > tolerance * size))
    return Factorisation(left, values, right, rank, size)
