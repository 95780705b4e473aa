"""Corners of what a linear map makes of a box: force and velocity polygons and polytopes."""

from __future__ import annotations

from itertools import product

import numpy as np

from pmjac_pin.errors import ArgumentError
from pmjac_pin.values.arrays import Array, read_only

_MOST = 16  # motors: 65,536 corners of a box


def corners_of(map_: Array, limits: Array) -> Array:
    """Return the corners of {A u : |uᵢ| ≤ limitᵢ}, shape (k, m).

    Parameters
    ----------
    map_ : ndarray, shape (m, n)
    limits : ndarray, shape (n,)

    Raises
    ------
    ArgumentError
        More motors than have corners that can be counted.
    """
    if limits.size > _MOST:
        raise ArgumentError(f"polytopes of at most {_MOST} motors, got {limits.size}")
    box = np.array(list(product((-1.0, 1.0), repeat=limits.size))) * limits
    points = box @ map_.T
    if len(map_) == 1:
        return read_only(np.array([points.min(axis=0), points.max(axis=0)]))
    # Hulls are imported with the first of them.
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415

    try:
        return read_only(points[ConvexHull(points).vertices])
    except QhullError:
        raise ArgumentError("the polytope is flat here: some direction is not reached") from None
