"""Radii of the ellipsoids of many J_eq: by the kernel, or by NumPy where none was built."""

from __future__ import annotations

import ctypes
from functools import cache

import numpy as np

from pmjac_pin.algebra.c_kernels import COUNT, POINTER, address, loaded
from pmjac_pin.algebra.singular_values import singular_values
from pmjac_pin.rates.ellipse import FLATNESS_TOLERANCE, flattened
from pmjac_pin.rates.tool_reach import RADIUS_ROUNDING
from pmjac_pin.values.arrays import Array

#: `Nothing` of `many_radii.c`.
NOTHING = (ctypes.c_double * 2)(FLATNESS_TOLERANCE, RADIUS_ROUNDING)


def fill_radii(J_eq: Array, sizes: Array, linear: Array, angular: Array) -> None:
    """Find the singular values of J_eq's blocks, zero where they are rounding.

    Parameters
    ----------
    J_eq : ndarray, shape (N, 6, n)
        NaN where there is none, and then the radii are.
    sizes : ndarray, shape (2, N)
        What the linear and the angular entries are compared with.
    linear, angular : ndarray, shape (N, 3)
        Where they go, row by row: descending.
    """
    built = radii_kernel()
    if built is not None:
        _by_kernel(built, J_eq, sizes, linear, angular)
        return
    linear[:] = _radii_of_blocks(J_eq[:, :3].transpose(1, 2, 0), sizes[0]).T
    angular[:] = _radii_of_blocks(J_eq[:, 3:].transpose(1, 2, 0), sizes[1]).T


@cache
def radii_kernel() -> ctypes.CDLL | None:
    """Return the kernel that was built from the source beside it, None where there is none."""
    sources = ("rates/many_radii.c", "algebra/singular_values.c", "algebra/lanes.h")
    takes = POINTER, COUNT, COUNT, POINTER, POINTER, POINTER, POINTER
    return loaded("rates/_many_radii.so", *sources, pmjac_radii=takes)


def _by_kernel(
    library: ctypes.CDLL, J_eq: Array, sizes: Array, linear: Array, angular: Array
) -> None:
    given, beside = np.ascontiguousarray(J_eq), np.ascontiguousarray(sizes)
    failed = library.pmjac_radii(
        address(given),
        given.shape[2],
        len(given),
        address(beside),
        NOTHING,
        address(linear),
        address(angular),
    )
    if failed:
        raise MemoryError("no memory for singular values")


def _radii_of_blocks(block: Array, size: Array) -> Array:
    """Return singular values of (3, n, N) blocks, (3, N), zero where they are rounding."""
    radii = np.zeros((3, block.shape[2]))
    values = singular_values(block)
    radii[: len(values)] = values
    flat = flattened(radii, radii[0])
    flat[flat <= RADIUS_ROUNDING * size] = 0.0
    flat[:, np.isnan(radii).any(axis=0)] = np.nan
    return flat
