"""Choices between equal numbers, so that rounding does not make them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: Of the largest: symmetric mechanisms make entries that are equal but for rounding.
LIKE = 1.0 - 1e-6


def first_largest(values: ArrayLike) -> NDArray[np.intp]:
    """Return where the entry of largest magnitude is along the first axis: the first of equal ones.

    Examples
    --------
    >>> int(first_largest([0.0, -2.0, 2.0 + 1e-15]))
    1
    >>> first_largest([[1.0, 0.5], [-1.0, -0.7]]).tolist()
    [0, 1]
    """
    sizes = np.abs(np.asarray(values, dtype=np.float64))
    return np.asarray((sizes >= LIKE * sizes.max(axis=0)).argmax(axis=0))


def first_smallest(values: ArrayLike) -> int:
    """Return where the entry of smallest magnitude is: the first of those equal beside the largest.

    Examples
    --------
    >>> first_smallest([1e-17, 0.0, 1.0])
    0
    """
    sizes = np.abs(np.asarray(values, dtype=np.float64))
    return int((sizes <= sizes.min() + (1.0 - LIKE) * sizes.max()).argmax())


def pivots(columns: ArrayLike, count: int) -> NDArray[np.intp]:
    """Return `count` independent columns, in their own order, as QR with pivoting chooses them.

    Each next one is that of which most is left beside those before: the first of equal ones.

    Examples
    --------
    >>> pivots([[1.0, 2.0, 2.0], [0.0, 0.0, 1e-9]], 2).tolist()
    [1, 2]
    >>> pivots([[1.0, 1.0 + 1e-15, 0.0], [0.0, 0.0, 1.0]], 2).tolist()
    [0, 2]
    """
    left = np.array(columns, dtype=np.float64)
    product, chosen = np.empty_like(left), list[int]()
    for _ in range(count):
        sizes = np.sqrt(np.multiply(left, left, out=product).sum(axis=0))
        sizes[chosen] = 0.0
        chosen.append(int(first_largest(sizes)))
        unit = left[:, chosen[-1]] / (sizes[chosen[-1]] or 1.0)
        for _ in range(2):  # once more, for what rounding leaves
            left -= np.outer(unit, unit @ left, out=product)
    return np.sort(np.array(chosen, dtype=np.intp))
