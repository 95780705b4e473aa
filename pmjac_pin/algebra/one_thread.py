"""One thread for linear algebra on many small matrices, one after the other.

OpenBLAS shares a singular value decomposition of 40 rows among its threads, which then wait for
each other longer than one of them computes: by ten times, and more where processors have other
work.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from functools import lru_cache, wraps
from threading import Lock
from typing import Any, ParamSpec, TypeVar

from pmjac_pin.values.lapack import lapack

_SHARED = 40  # columns: matrices of fewer are hardly shared

Asked = ParamSpec("Asked")
Found = TypeVar("Found")


class _OneThread:
    """Holds BLAS at one thread while calls are within; the last one out gives the others back."""

    def __init__(self) -> None:
        self._lock, self._within, self._limit = Lock(), 0, None

    _limit: Any

    def __enter__(self) -> None:
        lapack()  # SciPy has a BLAS of its own, and so may have what is imported meanwhile.
        libraries = _libraries(len(sys.modules))
        with self._lock:
            if not self._within:
                self._limit = libraries.limit(limits=1, user_api="blas")
            self._within += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._within -= 1
            if not self._within:
                self._limit.restore_original_limits()


@lru_cache(maxsize=1)
def _libraries(imported: int) -> Any:
    """Return what sets the threads of all libraries that are loaded: to look takes milliseconds."""
    from threadpoolctl import ThreadpoolController  # noqa: PLC0415

    return ThreadpoolController()


_ONE_THREAD, _AS_IT_IS = _OneThread(), nullcontext()


def one_thread_from(columns: int) -> AbstractContextManager[None]:
    """Return what leaves BLAS one thread within, where matrices have so many columns."""
    return _ONE_THREAD if columns >= _SHARED else _AS_IT_IS


def on_one_thread(of: Callable[Asked, Found]) -> Callable[Asked, Found]:
    """Return a function that leaves BLAS one thread while it is called, from any threads.

    Examples
    --------
    >>> import numpy as np
    >>> @on_one_thread
    ... def smallest(matrix):
    ...     return np.linalg.svd(matrix, compute_uv=False)[-1].item()
    >>> round(smallest(np.diag([3.0, 2.0])), 9)
    2.0
    """

    @wraps(of)
    def held(*args: Asked.args, **kwargs: Asked.kwargs) -> Found:
        with _ONE_THREAD:
            return of(*args, **kwargs)

    return held
