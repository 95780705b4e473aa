"""Gradients by the motor values of what is measured on J_eq.

Of a simple singular value σ = uᵀ B v of a matrix B(θ), ∂σ/∂θₖ = uᵀ (∂B/∂θₖ) v. Where singular
values are equal, each alone has no gradient: that of their product has one still.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from pmjac_pin.errors import NoGradientError, unknown_name
from pmjac_pin.values.arrays import Array

_EQUAL = 1e-6  # of the largest: singular values that are not told apart
_ZERO = 1e-12  # of the largest: rounding


def gradient_of(measure: str, block: Array, slopes: Array) -> Array:
    """Return the gradient (n,) of a measure of a matrix.

    Parameters
    ----------
    measure : str
        A name of `MEASURES`.
    block : ndarray, shape (r, n)
        B, rows of J_eq.
    slopes : ndarray, shape (r, n, n)
        ∂B/∂θ, the last axis along which motor.

    Raises
    ------
    UnknownNameError
    NoGradientError
        A singular value that is not simple, or is zero where that has no derivative.
    """
    if not isinstance(measure, str) or measure not in MEASURES:
        raise unknown_name("measure", measure, tuple(MEASURES))
    left, values, right = np.linalg.svd(block, full_matrices=False)
    rates = np.einsum("ri,rjk,ij->ik", left, slopes, right)
    return MEASURES[measure](values, rates)


def _simple(values: Array, which: int) -> None:
    others = np.delete(values, which)
    if not values[which] > _ZERO * values[0]:
        raise NoGradientError("a singular value is 0 here, where it has no gradient")
    if others.size and np.abs(others - values[which]).min() <= _EQUAL * values[0]:
        raise NoGradientError("singular values are equal here: each alone has no gradient")


def _smallest(values: Array, rates: Array) -> Array:
    _simple(values, -1)
    return np.asarray(rates[-1])


def _largest_gradient(values: Array, rates: Array) -> Array:
    _simple(values, 0)
    return np.asarray(rates[0])


def _log_det(values: Array, rates: Array) -> Array:
    if not values[-1] > _ZERO * values[0]:
        raise NoGradientError("a singular value is 0 here, and log det without bound")
    return np.asarray((rates / values[:, None]).sum(axis=0))


def _product_gradient(values: Array, rates: Array) -> Array:
    others = [np.prod(np.delete(values, k)) for k in range(values.size)]
    if values[-1] <= _ZERO * values[0] and others[-1]:
        raise NoGradientError("the product of the singular values is 0 here: it has a kink")
    return np.asarray(np.array(others) @ rates)


def _condition(values: Array, rates: Array) -> Array:
    _simple(values, -1)
    _simple(values, 0)
    return np.asarray((rates[0] - values[0] / values[-1] * rates[-1]) / values[-1])


#: What has a gradient, by name: Yoshikawa's manipulability is the product of singular values.
MEASURES: Mapping[str, Callable[[Array, Array], Array]] = MappingProxyType(
    {
        "smallest singular value": _smallest,
        "largest singular value": _largest_gradient,
        "product of singular values": _product_gradient,
        "condition number": _condition,
        "log det": _log_det,
    }
)
