"""Who computes the chunks: this process, others of this machine, or a cluster's client."""

from __future__ import annotations

import contextlib
import multiprocessing
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, TypeAlias, TypeVar

from pmjac_pin.batches.pieces import Progress
from pmjac_pin.errors import ArgumentError, PmjacError, WorkerError, quoted
from pmjac_pin.values.checks import check_callable

#: (function, *arguments) ↦ what has a `result()`.
Submit: TypeAlias = Callable[..., Any]
T = TypeVar("T")

_WAITING = 3  # chunks a worker that are handed out and not yet taken back


@dataclass(frozen=True, slots=True)
class Hands:
    """Those who compute.

    Attributes
    ----------
    client : None, or a client
        None for processes of this machine; anything with a ``submit``, as Dask's ``Client`` and
        the executors of ``concurrent.futures``; the module ``ray``.
    workers : int
        How many processes; 1 for this one.
    progress : callable, optional
        (chunks done, chunks) ↦ anything.
    """

    client: Any
    workers: int
    progress: Progress | None

    def __post_init__(self) -> None:
        check_callable(self.progress, "progress")

    @property
    def elsewhere(self) -> bool:
        """Whether jobs are sent to other processes."""
        if self.client is None:
            return self.workers > 1
        return not isinstance(self.client, ThreadPoolExecutor)

    def results(self, function: Callable[..., T], jobs: Sequence[tuple[Any, ...]]) -> Iterator[T]:
        """Yield the results of all jobs in their order, a few being handed out at a time.

        Raises
        ------
        WorkerError
            A process ends before it has answered.
        """
        waiting: deque[Any] = deque()
        with _told_of_workers(), self._submit() as submit:
            for done in range(len(jobs)):
                while len(waiting) < _WAITING * self.workers and done + len(waiting) < len(jobs):
                    waiting.append(submit(function, *jobs[done + len(waiting)]))
                yield waiting.popleft().result()
                if self.progress is not None:
                    self.progress(done + 1, len(jobs))

    @contextlib.contextmanager
    def _submit(self) -> Iterator[Submit]:
        if self.client is not None:
            yield _submit_of(self.client)
        elif self.workers == 1:
            yield _Here
        else:
            # A copy of this process would have its threads' locks, and nobody to open them.
            context = multiprocessing.get_context("spawn")
            pool = ProcessPoolExecutor(self.workers, mp_context=context)
            try:
                yield pool.submit
            finally:
                pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def _told_of_workers() -> Iterator[None]:
    try:
        yield
    except BrokenExecutor as error:
        raise WorkerError(
            "a process that computes chunks has ended before it has answered: killed, out of "
            "memory (then smaller chunks do, or fewer workers), or started by a script that does "
            'not ask `if __name__ == "__main__":`; what is done is in `out`, where one is given, '
            "and `resume` goes on from there"
        ) from error


class _Here:
    """A result that is computed when it is asked for."""

    def __init__(self, function: Callable[..., Any], *arguments: Any) -> None:
        self._function, self._arguments = function, arguments

    def result(self) -> Any:
        return self._function(*self._arguments)


class _Ray:
    """Hands out to Ray."""

    def __init__(self, ray: Any) -> None:
        self._get, self._remote = ray.get, cache(ray.remote)

    def __call__(self, function: Callable[..., Any], *arguments: Any) -> Any:
        return _Here(self._result, self._remote(function).remote(*arguments))

    def _result(self, task: Any) -> Any:
        try:
            return self._get(task)
        except PmjacError as error:  # Ray's child of it, with what it says in a traceback
            raise getattr(error, "cause", error) from error


def _submit_of(client: Any) -> Submit:
    if type(client).__module__.partition(".")[0] == "distributed":
        # What was computed once would be taken for what is to be written now.
        return partial(client.submit, pure=False)
    if callable(submit := getattr(client, "submit", None)):
        return submit  # type: ignore[no-any-return]
    if getattr(client, "__name__", "") == "ray":
        return _Ray(client)
    raise ArgumentError(
        f"`client` is Dask's Client, an executor or the module ray, got {quoted(client)}"
    )
