"""Singular values of many matrices at once: by the kernel, or by NumPy where none was built."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache

import numpy as np

from pmjac_pin.algebra.c_kernels import COUNT, POINTER, address, loaded
from pmjac_pin.values.arrays import Array, Mask

#: What `pmjac_singular_values` is given.
VALUES_TAKE = (POINTER, COUNT, COUNT, COUNT, POINTER, COUNT, POINTER)


def singular_values(matrices: Array, places: Sequence[int] | None = None) -> Array:
    """Return those of matrices (p, k, N), shape (min(p, k), N), to rounding of the largest.

    They are descending, and NaN where an entry is no number.

    Parameters
    ----------
    matrices : ndarray, shape (p, k, N)
    places : sequence of int, optional
        Which of them: 0 is the largest. All by default.

    Examples
    --------
    >>> singular_values(np.diag([3.0, -4.0])[:, :, None]).ravel().tolist()
    [4.0, 3.0]
    """
    wanted = range(min(matrices.shape[:2])) if places is None else places
    built = values_kernel()
    return _of_stack(matrices, wanted) if built is None else values_in(built, matrices, wanted)


@cache
def values_kernel() -> ctypes.CDLL | None:
    """Return the kernel that was built from the source beside it, None where there is none."""
    sources = ("algebra/singular_values.c", "algebra/lanes.h")
    return loaded("algebra/_singular_values.so", *sources, pmjac_singular_values=VALUES_TAKE)


def _of_stack(matrices: Array, places: Sequence[int]) -> Array:
    known: Mask = np.asarray(np.isfinite(matrices).all(axis=(0, 1)))
    finite = np.where(known, matrices, 0.0).transpose(2, 0, 1)
    values = np.linalg.svd(finite, compute_uv=False)[:, list(places)].T
    return np.where(known, values, np.nan)


def values_in(library: ctypes.CDLL, matrices: Array, places: Sequence[int]) -> Array:
    """Return what the kernel finds at some places.

    Raises
    ------
    MemoryError
    """
    if matrices.shape[0] > matrices.shape[1]:
        matrices = matrices.swapaxes(0, 1)
    given = np.ascontiguousarray(matrices, dtype=float)
    vectors, length, count = given.shape
    which, found = np.array(places, dtype=np.int64), np.empty((len(places), count))
    failed = library.pmjac_singular_values(
        address(given),
        vectors,
        length,
        count,
        address(which),
        which.size,
        address(found),
    )
    if failed:
        raise MemoryError("no memory for singular values")
    return found
