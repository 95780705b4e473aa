"""Sheet: closed poses as a function of the joints that drive, by cubic Hermite polynomials.

Between points of a grid, each entry of q is the polynomial, cubic in each joint, that has its
values and derivatives at the corners: f, ∂f/∂xₖ, and of two joints ∂²f/∂x₁∂x₂.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.values.arrays import Array, Index, ReadOnlyArrays

#: From values and half the slopes at −1 and 1 to the coefficients of 1, s, s², s³: exact in binary.
_TO_POWERS = 0.25 * np.array(
    [[2.0, 1.0, 2.0, -1.0], [-3.0, -1.0, 3.0, -1.0], [0.0, -1.0, 0.0, 1.0], [1.0, 1.0, -1.0, 1.0]]
)


@dataclass(frozen=True, eq=False)
class Sheet(ReadOnlyArrays):
    """Polynomials over the cells of a grid.

    Attributes
    ----------
    axes : tuple of ndarray
        Of the grid.
    data : ndarray, shape (*grid, 2, ..., nq)
        At each point, after one axis a joint: the value at 0 and the derivative by it at 1.
    """

    axes: tuple[Array, ...]
    data: Array

    @classmethod
    def of(cls, axes: tuple[Array, ...], q: Array, slopes: Array, twist: Array) -> Sheet:
        """Return those of closed poses.

        Parameters
        ----------
        axes : tuple of ndarray
        q, slopes, twist : ndarray, shapes (*grid, nq), (*grid, nq, n) and (*grid, nq or 0)
        """
        parts = [q, *np.moveaxis(slopes, -1, 0)[::-1], *([twist] if len(axes) > 1 else [])]
        shape = (*q.shape[:-1], *(2,) * len(axes), q.shape[-1])
        return cls(axes, np.stack(parts, axis=-2).reshape(shape))

    def cells(self, x: Array) -> tuple[Index, Array, Array]:
        """Return the cell of each row of joint values (N, n), where in it from 0 to 1, its widths.

        What is outside is in the cell beside it, and below 0 or above 1.
        """
        found, shares, widths = [], [], []
        for axis, values in zip(self.axes, x.T, strict=True):
            cell = np.clip(np.searchsorted(axis, values, "right") - 1, 0, axis.size - 2)
            width = axis[cell + 1] - axis[cell]
            found.append(cell)
            shares.append((values - axis[cell]) / width)
            widths.append(width)
        return np.array(found), np.array(shares), np.array(widths)

    def at(self, x: Array) -> Array:
        """Return q (N, nq) at joint values (N, n)."""
        cells, shares, widths = self.cells(x)
        bases = [_basis(u) for u in shares]
        total = np.zeros((cells.shape[1], self.data.shape[-1]))
        for place in product((0, 1), repeat=2 * len(bases)):
            corner, order = place[::2], place[1::2]
            weight = np.ones(cells.shape[1])
            for basis, width, c, o in zip(bases, widths, corner, order, strict=True):
                weight = weight * basis[2 * c + o] * (width if o else 1.0)
            data = self.data[(*(cells + np.array(corner)[:, None]), *order)]
            total += weight[:, None] * data
        return total

    def powers(self, cells: Index) -> Intervals:
        """Return the coefficients (4ⁿ, b, nq) of 1, s₂, … s₁³ s₂³ in some cells, shape (n, b).

        Each sₖ goes from −1 to 1 over the cell. They hold those of the polynomials exactly.
        """
        n, parts = len(self.axes), []
        for place in product((0, 1), repeat=2 * n):
            corner, order = place[::2], place[1::2]
            data = self.data[(*(cells + np.array(corner)[:, None]), *order)]
            term = Intervals.exact(data)
            for axis, cell, o in zip(self.axes, cells, order, strict=True):
                if o:
                    term = term * half_width(axis, cell)[:, None]
            parts.append(term)
        whole = Intervals.stack(parts, 0)
        matrix = np.asarray(_TO_POWERS if n == 1 else np.kron(_TO_POWERS, _TO_POWERS), dtype=float)
        flat = Intervals(*(end.reshape(len(parts), -1) for end in (whole.lower, whole.upper)))
        found = flat.after(matrix)
        return Intervals(*(end.reshape(whole.shape) for end in (found.lower, found.upper)))


def half_width(axis: Array, cell: Index) -> Intervals:
    """Return half the widths of cells."""
    width = Intervals.exact(axis[cell + 1]) - Intervals.exact(axis[cell])
    return width * Intervals.exact(0.5)


def middle(axis: Array, cell: Index) -> Intervals:
    """Return the middles of cells."""
    both = Intervals.exact(axis[cell + 1]) + Intervals.exact(axis[cell])
    return both * Intervals.exact(0.5)


def _basis(u: Array) -> Array:
    """Return the cubic basis (4, N) at numbers in [0, 1]: of f₀, f′₀, f₁, f′₁ at 0 and 1."""
    v = 1.0 - u
    return np.array([(1.0 + 2.0 * u) * v * v, u * v * v, u * u * (3.0 - 2.0 * u), -u * u * v])
