"""Contraction: how far x ↦ x − C η(x) is from constant, which Krawczyk's test asks of boxes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.intervals import Intervals


def contraction(inverse: NDArray[np.float64], jacobian: Intervals) -> Intervals:
    """Return I − C J(X), shape (..., n, n): its size bounds by how much the map contracts.

    Parameters
    ----------
    inverse : ndarray, shape (..., n, n)
        C, of which nothing is asked.
    jacobian : Intervals, shape (..., n, n)
        ∂η/∂x over boxes.
    """
    return Intervals.exact(np.eye(jacobian.shape[-1])) - jacobian.after(inverse)
