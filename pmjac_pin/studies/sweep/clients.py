"""Clients that a caller hands over: how each is given a job, and how many of these it does at once.

No library of theirs is imported.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Any, TypeAlias

from pmjac_pin.errors import ArgumentError, PmjacError, quoted
from pmjac_pin.values.cores import usable_cores

#: (function, *arguments) ↦ what has a `result()`.
Submit: TypeAlias = Callable[..., Any]


@dataclass(frozen=True, slots=True)
class Client:
    """What computes elsewhere.

    Attributes
    ----------
    submit : callable
    told : callable
        () ↦ how many jobs it says that it does at once; 0 where it does not say.
    """

    submit: Submit
    told: Callable[[], int]

    @classmethod
    def of(cls, given: Any) -> Client:
        """Return what a caller's client does.

        Raises
        ------
        ArgumentError
        """
        if type(given).__module__.partition(".")[0] == "distributed":
            # What was computed once would be taken for what is to be written now.
            return cls(partial(given.submit, pure=False), partial(_threads_of_dask, given))
        if callable(submit := getattr(given, "submit", None)):
            return cls(submit, partial(_workers_of_executor, given))
        if getattr(given, "__name__", "") == "ray":
            return cls(_Ray(given), partial(_cores_of_ray, given))
        raise ArgumentError(
            f"`client` is Dask's Client, an executor or the module ray, got {quoted(given)}; "
            "pip install 'pmjac_pin[dask]' or 'pmjac_pin[ray]' brings one"
        )

    @property
    def workers(self) -> int:
        """How many jobs it does at once; as many as this machine where nobody says."""
        return self.told() or usable_cores()


def _threads_of_dask(client: Any) -> int:
    # Not of its executor. None is there where a cluster grows once it has work.
    return sum(client.nthreads().values()) if hasattr(client, "nthreads") else 0


def _workers_of_executor(executor: Any) -> int:
    """Ask in mpi4py's words and in those of `concurrent.futures`, whose base class has none."""
    for name in ("num_workers", "_max_workers"):
        if isinstance(count := getattr(executor, name, None), int):
            return count
    return 0


def _cores_of_ray(ray: Any) -> int:
    if not ray.is_initialized():
        ray.init()  # as its first job does
    return int(ray.cluster_resources().get("CPU", 0))


class Later:
    """A result that is computed when it is asked for."""

    def __init__(self, function: Callable[..., Any], *arguments: Any) -> None:
        self._function, self._arguments = function, arguments

    def result(self) -> Any:
        """Compute it."""
        return self._function(*self._arguments)


class _Ray:
    """Hands out to Ray."""

    def __init__(self, ray: Any) -> None:
        self._get, self._remote = ray.get, cache(ray.remote)

    def __call__(self, function: Callable[..., Any], *arguments: Any) -> Any:
        return Later(self._result, self._remote(function).remote(*arguments))

    def _result(self, task: Any) -> Any:
        try:
            return self._get(task)
        except PmjacError as error:  # Ray's child of it, with what it says in a traceback
            raise getattr(error, "cause", error) from error
