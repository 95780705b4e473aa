"""Who computes the chunks: this process, others of this machine, or a cluster's client."""

from __future__ import annotations

import contextlib
import multiprocessing
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, TypeVar

from pmjac_pin.batches.pieces import Progress
from pmjac_pin.errors import WorkerError
from pmjac_pin.studies.sweep.clients import Client, Later, Submit
from pmjac_pin.values.checks import as_count, check_callable
from pmjac_pin.values.cores import usable_cores

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
        How many jobs are done at once; 1 without a client for this process.
    progress : callable, optional
        (chunks done, chunks) ↦ anything.
    """

    client: Any
    workers: int
    progress: Progress | None

    def __post_init__(self) -> None:
        check_callable(self.progress, "progress")

    @classmethod
    def asked(cls, client: Any, workers: int | None, jobs: int, progress: Progress | None) -> Hands:
        """Return those of whom a caller speaks; they are asked how many they are, if he does not.

        Raises
        ------
        ArgumentError
        """
        given = None if client is None else Client.of(client)
        if workers is not None:
            count = as_count(workers, "`workers`")
        else:
            count = usable_cores() if given is None else given.workers
        return cls(client, min(count, jobs), progress)

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
            yield Client.of(self.client).submit
        elif self.workers == 1:
            yield Later
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
