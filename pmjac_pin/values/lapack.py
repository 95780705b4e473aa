"""Small systems of equations, many times: LAPACK without NumPy's checks."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from pmjac_pin.values.arrays import Array, read_only

#: From so many on, singular values take several times as long as QR, and more where OpenBLAS shares
#: them among threads. Of fewer, all takes microseconds.
MANY_COLUMNS = 40


def solved(matrix: Array, right: Array) -> Array | None:
    """Return x with A x = b, A square, or None where elimination meets a zero.

    Examples
    --------
    >>> import numpy as np
    >>> solved(2.0 * np.eye(2), np.array([1.0, 3.0])).tolist()
    [0.5, 1.5]
    >>> solved(np.zeros((2, 2)), np.ones(2)) is None
    True
    """
    _, _, solution, failed = lapack().dgesv(matrix, right)
    return None if failed else solution


def inverted(matrix: Array) -> Array | None:
    """Return the inverse of a square A, or None as `solved`.

    Examples
    --------
    >>> import numpy as np
    >>> inverted(2.0 * np.eye(2)).tolist()
    [[0.5, 0.0], [0.0, 0.5]]
    """
    transposed = solved(matrix.T, _identity(len(matrix)))
    return None if transposed is None else transposed.T


@functools.cache
def _identity(size: int) -> Array:
    return read_only(np.eye(size))


def least_squares(matrix: Array, right: Array) -> Array | None:
    """Return the x of smallest |A x − b|, A with more rows than columns, or None as `solved`.

    Of a matrix of zeros, 0.

    Examples
    --------
    >>> import numpy as np
    >>> least_squares(np.array([[2.0], [0.0]]), np.array([1.0, 3.0])).tolist()
    [0.5]
    >>> least_squares(np.eye(3, 2) @ np.diag([1.0, 0.0]), np.ones(3)) is None
    True
    """
    _, solution, failed = lapack().dgels(matrix, right)
    return None if failed else solution[: matrix.shape[1]]


def inverse_triangle(matrix: Array) -> Array | None:
    """Return R⁻¹ of A = Q R, A with more rows than columns, or None as `solved`.

    Examples
    --------
    >>> import numpy as np
    >>> np.abs(inverse_triangle(np.array([[3.0], [4.0]]))).round(9).tolist()
    [[0.2]]
    """
    reflected, *_ = lapack().dgeqrf(matrix)
    inverse, failed = lapack().dtrtri(reflected[: matrix.shape[1]])
    return None if failed else np.triu(inverse)


@functools.cache
def lapack() -> Any:
    """Return SciPy's wrappers of LAPACK, imported when they are first asked for."""
    from scipy.linalg import lapack  # noqa: PLC0415

    return lapack
