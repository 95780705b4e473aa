"""MotorPath: motor values as polynomials of a parameter, piece after piece."""

from __future__ import annotations

from dataclasses import dataclass
from math import comb

import numpy as np

from pmjac_pin.values.arrays import Array

_CUBIC = 4  # coefficients


@dataclass(frozen=True, slots=True, eq=False)
class PathPiece:
    """θ(t) = Σ c_k (t − origin)ᵏ from `start` to `end`.

    Attributes
    ----------
    coefficients : ndarray, shape (k, n)
        The highest power first.
    """

    start: float
    end: float
    origin: float
    coefficients: Array

    def values(self, t: float) -> Array:
        """Return θ (n,)."""
        return self._derivative(t, 0)

    def rates(self, t: float) -> Array:
        """Return dθ/dt (n,)."""
        return self._derivative(t, 1)

    def accelerations(self, t: float) -> Array:
        """Return d²θ/dt² (n,)."""
        return self._derivative(t, 2)

    def _derivative(self, t: float, order: int) -> Array:
        powers = self.coefficients
        for _ in range(order):
            powers = powers[:-1] * np.arange(len(powers) - 1.0, 0.0, -1.0)[:, None]
        total, x = np.zeros(self.coefficients.shape[1]), t - self.origin
        for row in powers:
            total = total * x + row
        return total

    def unit_coefficients(self, start: float, end: float) -> Array:
        """Return the coefficients (k, n) in s, from 0 to 1 between two parameters, lowest first."""
        shift, width = start - self.origin, end - start
        given = self.coefficients[::-1]
        found = np.zeros(given.shape)
        for power, row in enumerate(given):
            for k in range(power + 1):
                found[k] += comb(power, k) * shift ** (power - k) * width**k * row
        return found

    def aside(self, start: float, end: float) -> Array | None:
        """Return how far the path is between two parameters from a cubic, (n,); None for nowhere.

        From the one with the same values and rates at both ends: the Bernstein coefficients of
        the difference, for s from 0 to 1, are as large as it is at most.
        """
        if len(self.coefficients) <= _CUBIC:
            return None
        powers = self.unit_coefficients(start, end)
        higher = powers[_CUBIC:]
        degrees = np.arange(float(_CUBIC), len(powers))[:, None]
        value, slope = higher.sum(axis=0), (degrees * higher).sum(axis=0)
        rest = np.concatenate(
            [np.zeros((2, powers.shape[1])), [slope - 3.0 * value], [2.0 * value - slope]]
        )
        rest = np.concatenate([rest, higher])
        return np.asarray(np.abs(_bernstein(rest)).max(axis=0))


def _bernstein(powers: Array) -> Array:
    """Return the Bernstein coefficients of polynomials in s by powers (k, n), lowest first."""
    degree = len(powers) - 1
    matrix = [[comb(i, k) / comb(degree, k) for k in range(degree + 1)] for i in range(degree + 1)]
    found: Array = np.array(matrix) @ powers
    return found


@dataclass(frozen=True, slots=True, eq=False)
class MotorPath:
    """Pieces that hang together, in their order."""

    pieces: tuple[PathPiece, ...]

    @property
    def start(self) -> float:
        """The first parameter."""
        return self.pieces[0].start

    @property
    def end(self) -> float:
        """The last parameter."""
        return self.pieces[-1].end

    def number_at(self, t: float) -> int:
        """Return which piece holds a parameter: the later one where two meet."""
        starts = [piece.start for piece in self.pieces]
        return max(int(np.searchsorted(starts, t, "right")) - 1, 0)

    def piece_at(self, t: float) -> PathPiece:
        """Return the piece that holds a parameter: the later one where two meet."""
        return self.pieces[self.number_at(t)]
