"""A polynomial that leads from motor values to joint values, nearly: where Newton's steps begin."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np

from pmjac_pin.values.arrays import Array

_MOST_DEGREE = 8


def fitted_polynomial(u: Array, joints: Array) -> tuple[list[tuple[int, ...]], Array]:
    """Return exponents and coefficients of the polynomial of the degree that fits best."""
    best, found = np.inf, None
    for degree in range(1, _MOST_DEGREE + 1):
        exponents = [e for e in product(range(degree + 1), repeat=u.shape[1]) if sum(e) <= degree]
        if 2 * len(exponents) > len(u):
            break
        columns = np.stack([(u ** np.array(e)).prod(axis=1) for e in exponents], axis=1)
        coefficients = np.linalg.lstsq(columns, joints, rcond=None)[0]
        off = float(np.abs(columns @ coefficients - joints).max())
        if found is None or off < 0.5 * best:
            best, found = off, (exponents, coefficients)
    if found is None:
        return [(0,) * u.shape[1]], joints.mean(axis=0)[None]
    return found


def c_polynomial(coefficients: Mapping[tuple[int, ...], float], n: int, place: int = 0) -> str:
    """Return a polynomial of n variables u0, u1 as an expression in C, by Horner's scheme.

    Examples
    --------
    >>> c_polynomial({(0,): 1.0, (1,): 2.0, (2,): 3.0}, 1)
    '(((3.0)) * u0 + (2.0)) * u0 + (1.0)'
    """
    if place == n:
        return repr(float(coefficients[()]) + 0.0)
    parts: dict[int, dict[tuple[int, ...], float]] = {}
    for exponents, number in coefficients.items():
        parts.setdefault(exponents[0], {})[exponents[1:]] = number
    text = ""
    for power in sorted(parts, reverse=True):
        inner = c_polynomial(parts[power], n, place + 1)
        text = f"({text}) * u{place} + ({inner})" if text else f"({inner})"
    return text
