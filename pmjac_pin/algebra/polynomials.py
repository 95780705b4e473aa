"""Polynomials: NumPy arrays of FLINT's polynomials with rational coefficients, all exact.

A double is taken as the rational number that it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from flint import fmpq, fmpq_mpoly
from numpy.typing import NDArray

from pmjac_pin.algebra.arrays import Arrays
from pmjac_pin.values.arrays import Array

#: Of polynomials, or of rational numbers.
Symbols = NDArray[Any]


class Polynomials(Arrays):
    """Polynomials in any variables.

    Examples
    --------
    >>> polynomials = Polynomials()
    >>> polynomials.squared(polynomials.constant([0.5, 1.0])).ravel().tolist()
    [5/4]
    """

    __slots__ = ()

    def exact(self, values: Array) -> Symbols:
        """Return doubles as rational numbers."""
        return np.asarray(np.vectorize(rational, otypes=[object])(values))


def rational(number: float) -> fmpq:
    """Return a double as the rational number that it is."""
    return fmpq(*float(number).as_integer_ratio())


def symbols(entries: Sequence[fmpq_mpoly]) -> Symbols:
    """Return polynomials as an array; NumPy would take each for a sequence of its terms."""
    found = np.empty(len(entries), dtype=object)
    for index, entry in enumerate(entries):
        found[index] = entry
    return found
