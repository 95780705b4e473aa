"""Singular values of many matrices at once: by the kernel, or by NumPy where none was built."""

from __future__ import annotations

import ctypes

import numpy as np

from pmjac_pin.algebra.tape_runner import kernel
from pmjac_pin.values.arrays import Array, Mask


def singular_values(matrices: Array) -> Array:
    """Return those of matrices (p, k, N), shape (min(p, k), N).

    They are descending, and NaN where an entry is no number.

    Examples
    --------
    >>> singular_values(np.diag([3.0, -4.0])[:, :, None]).ravel().tolist()
    [4.0, 3.0]
    """
    known: Mask = np.asarray(np.isfinite(matrices).all(axis=(0, 1)))
    finite = matrices if known.all() else np.where(known, matrices, 0.0)
    built = kernel()
    values = _of_stack(finite) if built is None else singular_values_in(built, finite)
    found: Array = np.where(known, values, np.nan)
    return found


def _of_stack(matrices: Array) -> Array:
    return np.asarray(np.linalg.svd(matrices.transpose(2, 0, 1), compute_uv=False).T)


def singular_values_in(library: ctypes.CDLL, matrices: Array) -> Array:
    """Return what the kernel finds for finite matrices.

    Raises
    ------
    MemoryError
    """
    if matrices.shape[0] > matrices.shape[1]:
        matrices = matrices.swapaxes(0, 1)
    given = np.ascontiguousarray(matrices, dtype=float)
    vectors, length, count = given.shape
    found = np.empty((vectors, count))
    failed = library.pmjac_singular_values(
        given.ctypes.data_as(ctypes.c_void_p),
        ctypes.c_int64(vectors),
        ctypes.c_int64(length),
        ctypes.c_int64(count),
        found.ctypes.data_as(ctypes.c_void_p),
    )
    if failed:
        raise MemoryError("no memory for singular values")
    return found
