"""Checking the numbers that a caller gives."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError, quoted

Array = NDArray[np.float64]


def as_numbers(given: object, what: str) -> Array:
    """Return a float array of what the caller gave, or say what is wrong with it.

    Raises
    ------
    ArgumentError
        Strings, complex numbers, ragged lists, NaN and infinities.
    """
    try:
        raw = np.asarray(given)
        if raw.dtype.kind not in "iuf":
            raise TypeError
    except (TypeError, ValueError):
        raise ArgumentError(f"{what} must be real numbers, got {quoted(given)}") from None
    array = raw.astype(np.float64)
    if not np.isfinite(array).all():
        raise ArgumentError(f"{what} must be finite, got {quoted(given)}")
    return array
