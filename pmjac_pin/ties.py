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
