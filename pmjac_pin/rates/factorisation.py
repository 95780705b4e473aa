"""Factorisation: one rank-revealing look at a matrix, from which everything else is read off."""

from __future__ import annotations

import functools
import math

import numpy as np

from pmjac_pin.values.arrays import Array, norm, read_only
from pmjac_pin.values.found_once import found_once
from pmjac_pin.values.lapack import MANY_COLUMNS, inverse_triangle, inverted, least_squares

#: A singular value below this times the size of [K K*] counts as zero. Loops closed to 1e-12
#: of the length cannot tell a pose from a singular one nearer than √1e-12: at a fold the residual
#: grows with the square of the distance.
RANK_TOLERANCE = 1e-6
#: Of the size of [K K*]: where a singular value of K* is less, rates are refined.
REFINED = 1e-2

_SURELY = 1.0 - 1e-3  # of a bound that rounding may have moved
_RESOLVED = 1e-9  # of the matrix: above, rounding moves an inverse by less than that
_SQUARED = 1e-3  # of the matrix: above, its normal equations are solved to rounding


class Factorisation:
    """A = U diag(σ) Vᵀ with the rank that the tolerance gives: by `factorise`.

    Of a matrix whose columns are independent beyond doubt, its inverse, or pseudoinverse where it
    has more rows, tells all that is asked at a regular pose: σ_min ≥ 1/‖A⁺‖. It takes a fraction
    of the time; U, σ and V are found when they are asked for, and so is A⁺ where R of A = Q R says
    as much.

    Attributes
    ----------
    matrix : ndarray, shape (p, k)
    size : float
        What the singular values are compared with.
    tolerance : float
        Relative size up to which they count as zero.
    """

    def __init__(
        self, matrix: Array, size: float, tolerance: float, inverse: Array | None, bound: float
    ) -> None:
        self.matrix, self.size, self.tolerance = matrix, size, tolerance
        # Of σ_min, where that is above the tolerance for certain: 0 where nothing is.
        self._bound = bound
        if bound:
            self.rank = matrix.shape[1]
        if inverse is not None:
            self._inverse = inverse

    @found_once
    def _inverse(self) -> Array | None:
        """A⁺, None where its columns are not independent for certain."""
        return least_squares(self.matrix, np.eye(len(self.matrix))) if self._bound else None

    @found_once
    def _svd(self) -> tuple[Array, Array, Array]:
        rows, columns = self.matrix.shape
        if not (rows and columns):
            return np.eye(rows), np.zeros(0), np.eye(columns)
        left, values, right = np.linalg.svd(self.matrix)
        return left, values, right

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

    @found_once
    def rank(self) -> int:
        """How many singular values are above the tolerance."""
        return int(np.count_nonzero(self.singular_values > self.tolerance * self.size))

    def exceeds(self, rank: int, least: float) -> bool:
        """Tell whether the first `rank` singular values are above `least`."""
        if self._bound > least:
            return True
        return not rank or float(self.singular_values[rank - 1]) > least

    def surely_exceeds(self, least: float) -> bool:
        """Tell whether all singular values are above `least` by a bound: if not, they may be."""
        return self._bound > least

    @property
    def null_space(self) -> Array:
        """Orthonormal columns N with A N = 0, shape (k, k − rank)."""
        columns = self.matrix.shape[1]
        if self.rank == columns:
            return np.empty((columns, 0))
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

    def left_over(self, b: Array, solution: Array) -> float:
        """Return the norm of what of b no A x reaches, with A of its rank here.

        `solution` is `solve` of b.
        """
        if self._inverse is not None:
            return norm(b - self.matrix.dot(solution))
        return norm(self.left_null_space.T.dot(b))

    def solve(self, b: Array, rank: int | None = None) -> Array:
        """Return the smallest least-squares solution x of A x = b, by the first `rank` values."""
        r = self.rank if rank is None else rank
        if r == self.matrix.shape[1] and self._inverse is not None:
            solution: Array = self._inverse.dot(b)
            return solution
        left, values, right = self._svd
        projected = left[:, :r].T.dot(b).T / values[:r]
        return np.asarray(right[:r].T.dot(projected.T))

    def inverse(self, rank: int) -> Array:
        """Return the pseudoinverse by the first `rank` singular values, shape (k, p)."""
        if rank == self.matrix.shape[1] and self._inverse is not None:
            return self._inverse
        left, values, right = self._svd
        inverse: Array = (right[:rank].T / values[:rank]).dot(left[:, :rank].T)
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
    rows, columns = matrix.shape
    if rows >= columns > 0:
        largest = max(size, norm(matrix))
        found = _inverted(
            matrix, max(tolerance, _RESOLVED if rows == columns else _SQUARED) * largest
        )
        if found is not None:
            return Factorisation(matrix, size, tolerance, *found)
        if rows > columns >= MANY_COLUMNS:
            bound = _bound_by_reflections(matrix)
            if bound > max(tolerance, _RESOLVED) * largest:
                return Factorisation(matrix, size, tolerance, None, bound)
    return decompose(matrix, size, tolerance)


def decompose(matrix: Array, size: float, tolerance: float = RANK_TOLERANCE) -> Factorisation:
    """Factorise a matrix as `factorise` does, at once by singular values: for its null space."""
    return Factorisation(matrix, size, tolerance, None, 0.0)


def _inverted(matrix: Array, least: float) -> tuple[Array, float] | None:
    """Return A⁺ and a bound on σ_min by elimination, None where that is not above the least."""
    rows, columns = matrix.shape
    square = rows == columns
    inverse = inverted(matrix if square else matrix.T.dot(matrix))
    if inverse is None:
        return None
    # By the largest entry: squares may overflow.
    entries = np.abs(inverse)
    length = columns * entries.item(entries.argmax())
    bound = _SURELY / ((length if square else math.sqrt(length)) or math.inf)
    if not bound > least:
        return None
    if not square:  # A⁺ = (AᵀA)⁻¹Aᵀ, improved by one step
        left = inverse.dot(matrix.T)
        inverse = (_twice(columns) - left.dot(matrix)).dot(left)
    return inverse, bound


def _bound_by_reflections(matrix: Array) -> float:
    """Return a bound on σ_min of A = Q R by the inverse of R, without the squares of AᵀA."""
    inverse = inverse_triangle(matrix)
    if inverse is None:
        return 0.0
    entries = np.abs(inverse)
    largest: float = entries.item(entries.argmax())
    # Squares may overflow, and so may the inverse.
    return _SURELY / (largest * norm(inverse / largest)) if math.isfinite(largest) else 0.0


@functools.cache
def _twice(size: int) -> Array:
    return read_only(2.0 * np.eye(size))
