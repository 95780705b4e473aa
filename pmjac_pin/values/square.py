"""Square systems, small ones, many times: LAPACK without NumPy's checks."""

from __future__ import annotations

import functools
from typing import Any

from pmjac_pin.values.arrays import Array


def solved(matrix: Array, right: Array) -> Array | None:
    """Return x with A x = b, or None where elimination meets a zero.

    Examples
    --------
    >>> import numpy as np
    >>> solved(2.0 * np.eye(2), np.array([1.0, 3.0])).tolist()
    [0.5, 1.5]
    >>> solved(np.zeros((2, 2)), np.ones(2)) is None
    True
    """
    *_, solution, failed = _dgesv()(matrix, right)
    return None if failed else solution


@functools.cache
def _dgesv() -> Any:
    # When it is first called: to import SciPy takes as long as to import Pinocchio.
    from scipy.linalg.lapack import dgesv  # noqa: PLC0415

    return dgesv
