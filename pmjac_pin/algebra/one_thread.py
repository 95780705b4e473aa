"""One thread for linear algebra on many small matrices, one after the other.

OpenBLAS shares a singular value decomposition of 40 rows among its threads, which then wait for
each other longer than one of them computes: by ten times, and more where processors have other
work.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from functools import lru_cache, wraps
from threading import Lock
from typing import Any, ParamSpec, TypeVar
from weakref import ref

from pmjac_pin.values.lapack import MANY_COLUMNS, lapack

Asked = ParamSpec("Asked")
Found = TypeVar("Found")


class _Held:
    """BLAS held at one thread by whoever is within; the last one out gives the others back.

    Somebody may interrupt between any two steps. So what there was before is known before it is
    changed, and until it is given back; and who has ended without leaving is within no longer.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._within: list[ref[_OneThread]] = []
        self._before: list[tuple[Any, int]] = []  # libraries, with their numbers of threads

    def enter(self, one: _OneThread) -> None:
        """Take one more, after which BLAS has one thread."""
        lapack()  # SciPy has a BLAS of its own, and so may have what is imported meanwhile.
        libraries = _libraries(len(sys.modules))
        with self._lock:
            others = self._others(one)
            self._within = [*others, ref(one)]
            if others:
                return
            self._before = self._before or [
                (library, library.num_threads)
                for library in libraries.lib_controllers
                if library.user_api == "blas" and library.num_threads
            ]
            for library, _ in self._before:
                library.set_num_threads(1)

    def leave(self, one: _OneThread) -> None:
        """Leave one out, who may have left before."""
        with self._lock:
            self._within = self._others(one)
            if not self._within:
                for library, count in self._before:
                    library.set_num_threads(count)
                self._before = []

    def begin_anew(self) -> None:
        """Give back what threads hold that a forked process does not have."""
        self._lock, self._within = Lock(), []
        self.leave(_OneThread())

    def _others(self, one: _OneThread) -> list[ref[_OneThread]]:
        return [other for other in self._within if other() not in {None, one}]


class _OneThread:
    """Leaves BLAS one thread within."""

    def __enter__(self) -> None:
        try:
            _HELD.enter(self)
        except BaseException:
            _HELD.leave(self)
            raise

    def __exit__(self, *_: object) -> None:
        try:
            _HELD.leave(self)
        except BaseException:
            _HELD.leave(self)
            raise


_HELD, _AS_IT_IS = _Held(), nullcontext()
os.register_at_fork(after_in_child=_HELD.begin_anew)


@lru_cache(maxsize=1)
def _libraries(imported: int) -> Any:
    """Return all libraries that are loaded: to look takes milliseconds."""
    from threadpoolctl import ThreadpoolController  # noqa: PLC0415

    return ThreadpoolController()


def one_thread_from(columns: int) -> AbstractContextManager[None]:
    """Return what leaves BLAS one thread within, where matrices have so many columns."""
    return _OneThread() if columns >= MANY_COLUMNS else _AS_IT_IS


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
        with _OneThread():
            return of(*args, **kwargs)

    return held
