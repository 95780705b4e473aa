"""Boxes: intervals over NumPy's arrays, every operation rounded outwards."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.values.arrays import Array


class Boxes:
    """Closed intervals.

    Examples
    --------
    >>> boxes = Boxes()
    >>> x = Intervals(np.array([[[-1.0]]]), np.array([[[2.0]]]))
    >>> float(boxes.squared(x).lower[0, 0]) > -1e-12, float(boxes.dot(x, x).lower[0, 0]) < -1.0
    (True, True)
    """

    __slots__ = ()

    rooted = False

    def constant(self, values: ArrayLike) -> Intervals:
        """Return doubles as intervals without width."""
        return Intervals.exact(np.asarray(values, dtype=float)[..., None, None])

    def measured(self, values: ArrayLike) -> Intervals:
        """Return a model's numbers as they are stored: what counts as closed has a tolerance."""
        return self.constant(values)

    def between(self, ends: Intervals) -> Intervals:
        """Return intervals as numbers, their axes the components."""
        return ends[..., None, None]

    def stack(self, parts: Sequence[Intervals]) -> Intervals:
        """Return intervals side by side along a new first axis."""
        shape = np.broadcast_shapes(*(part.shape for part in parts))
        lower, upper = np.empty((len(parts), *shape)), np.empty((len(parts), *shape))
        for place, part in enumerate(parts):
            lower[place], upper[place] = part.lower, part.upper
        return Intervals(lower, upper)

    def join(self, parts: Sequence[Intervals]) -> Intervals:
        """Return intervals one after another along the rates."""
        poses = max(part.shape[-1] for part in parts)
        rates = sum(part.shape[-2] for part in parts)
        shape = (*parts[0].shape[:-2], rates, poses)
        lower, upper = np.empty(shape), np.empty(shape)
        start = 0
        for part in parts:
            end = start + part.shape[-2]
            lower[..., start:end, :], upper[..., start:end, :] = part.lower, part.upper
            start = end
        return Intervals(lower, upper)

    def times(self, matrix: Array, x: Intervals) -> Intervals:
        """Return matrix @ x."""
        flat = (x.shape[0], -1)
        product = Intervals(x.lower.reshape(flat), x.upper.reshape(flat)).after(matrix)
        shape = (len(matrix), *x.shape[1:])
        return Intervals(product.lower.reshape(shape), product.upper.reshape(shape))

    def directed(self, directions: Array, x: Intervals) -> Intervals:
        """Return directions @ x."""
        return self.times(directions, x)

    def dot(self, u: Intervals, v: Intervals) -> Intervals:
        """Return u·v."""
        return (u * v).sum(0)

    def squared(self, u: Intervals) -> Intervals:
        """Return u·u, as narrow as squares are."""
        return u.square().sum(0)

    def cross(self, u: Intervals, v: Intervals) -> Intervals:
        """Return u × v."""
        (a, b, c), (x, y, z) = ((w[0], w[1], w[2]) for w in (u, v))
        return self.stack([b * z - c * y, c * x - a * z, a * y - b * x])

    def swapped(self, x: Intervals) -> Intervals:
        """Return x with its two first axes exchanged."""
        return Intervals(x.lower.swapaxes(0, 1), x.upper.swapaxes(0, 1))

    def cos(self, x: Intervals) -> Intervals:
        """Return cos x."""
        return x.cos()

    def sin(self, x: Intervals) -> Intervals:
        """Return sin x."""
        return x.sin()

    def unit(self, x: Intervals) -> Intervals:
        """Return x: of the members of a box around what q holds of a turn, those of length 1."""
        return x


BOXES = Boxes()
