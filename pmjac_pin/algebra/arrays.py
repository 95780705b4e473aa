"""Number types that are NumPy's arrays, of floats or of objects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pmjac_pin.values.arrays import Array

Numbers = NDArray[Any]


class Arrays:
    """Operations that are the same whatever an array consists of."""

    __slots__ = ()

    rooted = False

    def exact(self, values: Array) -> Numbers:
        """Return an array of this type's numbers that are these doubles."""
        return values

    def constant(self, values: ArrayLike) -> Numbers:
        """Return doubles as numbers."""
        return self.exact(np.asarray(values, dtype=float))[..., None, None]

    def measured(self, values: ArrayLike) -> Numbers:
        """Return a model's numbers as they are stored."""
        return self.constant(values)

    def stack(self, parts: Sequence[Numbers]) -> Numbers:
        """Return numbers side by side along a new first axis."""
        shape = parts[0].shape
        if any(part.shape != shape for part in parts):
            shape = np.broadcast_shapes(*(part.shape for part in parts))
        whole = np.empty((len(parts), *shape), dtype=np.result_type(*parts))
        for place, part in enumerate(parts):
            whole[place] = part
        return whole

    def join(self, parts: Sequence[Numbers]) -> Numbers:
        """Return numbers one after another along the rates."""
        counts = [part.shape[-1] for part in parts]
        poses = min(counts) and max(counts)  # there may be none
        rates = sum(part.shape[-2] for part in parts)
        whole = np.empty((*parts[0].shape[:-2], rates, poses), dtype=np.result_type(*parts))
        start = 0
        for part in parts:
            end = start + part.shape[-2]
            whole[..., start:end, :] = part
            start = end
        return whole

    def times(self, matrix: Array, x: Numbers) -> Numbers:
        """Return matrix @ x."""
        product = self.exact(matrix) @ x.reshape(len(x), -1)
        return np.asarray(product).reshape(len(matrix), *x.shape[1:])

    def directed(self, directions: Array, x: Numbers) -> Numbers:
        """Return directions @ x."""
        return self.times(directions, x)

    def dot(self, u: Numbers, v: Numbers) -> Numbers:
        """Return u·v."""
        total = u[0] * v[0]
        for place in range(1, len(u)):
            total = total + u[place] * v[place]
        return np.asarray(total)

    def squared(self, u: Numbers) -> Numbers:
        """Return u·u."""
        return self.dot(u, u)

    def cross(self, u: Numbers, v: Numbers) -> Numbers:
        """Return u × v."""
        shape = np.broadcast_shapes(u.shape, v.shape)
        whole = np.empty(shape, dtype=np.result_type(u, v))
        for place in range(3):
            j, k = (place + 1) % 3, (place + 2) % 3
            whole[place] = u[j] * v[k]
            whole[place] -= u[k] * v[j]
        return whole

    def swapped(self, x: Numbers) -> Numbers:
        """Return x with its two first axes exchanged."""
        return x.swapaxes(0, 1)
