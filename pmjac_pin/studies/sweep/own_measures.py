"""Measures of a caller's own: functions of the poses of a sweep, and of what was found at them."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeAlias

import numpy as np

from pmjac_pin.batches.few_poses import FewPoses
from pmjac_pin.batches.results import ManyClosed, ManyMeasures, Status
from pmjac_pin.errors import ArgumentError, quoted, shortened
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.columns import labels_of_rows
from pmjac_pin.values.found_once import found_once

#: (N poses that have J_eq, what was found at them) ↦ an array (N, ...).
Measure: TypeAlias = Callable[[ManyClosed, ManyMeasures], Any]

_MEASURES_WANTED = "`measures` is a list of names, or of pairs (name, function)"
_TIMES_TRIED = 11  # times the guess: as no other axis of what is found is long


class OwnMeasure:
    """A function with a name; it is pickled once, and unpickled where it is first called.

    Parameters
    ----------
    name : str
    function : callable
    shape : tuple of int
        Of what it says of one pose.
    """

    def __init__(self, name: str, function: Measure, shape: tuple[int, ...]) -> None:
        self.name, self.shape = name, shape
        self.__dict__["function"] = function

    def __getstate__(self) -> dict[str, Any]:
        return {"name": self.name, "shape": self.shape, "contents": self.contents}

    @property
    def dims(self) -> dict[str, range]:
        """Axes behind those of the points, and their labels."""
        return {f"{self.name}_{k}": range(size) for k, size in enumerate(self.shape)}

    @found_once
    def contents(self) -> bytes:
        """The function as other processes are handed it.

        Raises
        ------
        ArgumentError
        """
        try:
            return _pickled(self.function)
        except Exception as error:
            right = "write it with `def` in a module, install cloudpickle, or give `workers=1`"
            raise self._fault(
                f"cannot be sent to other processes ({_error_in_words(error)}): {right}"
            ) from (error)

    @found_once
    def function(self) -> Measure:
        """The function, of what was sent.

        Raises
        ------
        ArgumentError
        """
        try:
            return pickle.loads(self.contents)  # type: ignore[no-any-return]
        except Exception as error:
            right = "write it in a module that they can import, or give `workers=1`"
            raise self._fault(
                f"is not found by other processes ({_error_in_words(error)}): {right}"
            ) from (error)

    def at(self, poses: ManyClosed, found: ManyMeasures) -> Array:
        """Return what it says of N poses, shape (N, *shape).

        Raises
        ------
        ArgumentError
            It fails, or returns anything else.
        """
        values = self.numbers(poses, found)
        if values.shape[1:] != self.shape:
            wanted = (len(values), *self.shape)
            raise self._fault(f"returned shape {values.shape}, where {wanted} was expected")
        return values

    def numbers(self, poses: ManyClosed, found: ManyMeasures) -> Array:
        """Return what it says of N poses, of whatever shape (N, ...)."""
        function, count = self.function, len(poses.q)
        try:
            returned = function(poses, found)
        except Exception as error:
            raise self._fault(f"raised {_error_in_words(error)}") from error
        try:
            values = np.asarray(returned)
        except ValueError:  # lists of unlike lengths
            values = np.array(None)
        if values.dtype.kind not in "biuf" or np.ma.is_masked(returned):
            raise self._fault(f"is to return real numbers, it returned {quoted(returned)}")
        if not values.size or not values.ndim or len(values) != count:
            wanted = f"is to return a number or an array for each of {count} poses"
            raise self._fault(f"{wanted}, ({count}, ...), it returned shape {values.shape}")
        labels = labels_of_rows(returned)
        if labels is not None and labels != list(range(count)):
            right = "in their order: return them so, without labels"
            raise self._fault(f"returned rows labelled {quoted(labels)}, not the poses', {right}")
        return values.astype(np.float64)

    def _fault(self, what: str) -> ArgumentError:
        return ArgumentError(f"measure {self.name!r}: its function {what}")


def asked_measures(given: object) -> dict[str, Measure | None]:
    """Return names, with a function where that is a caller's own.

    Raises
    ------
    ArgumentError
        Anything but names and pairs of a name and a function; a function's name that is given
        twice, or is none of Python's.
    """
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise ArgumentError(f"{_MEASURES_WANTED}, got {quoted(given)}")
    asked: dict[str, Measure | None] = {}
    for entry in given.items() if isinstance(given, Mapping) else given:
        name, function = entry if isinstance(entry, tuple) and len(entry) == 2 else (entry, None)
        if not isinstance(name, str) or (entry is not name and not callable(function)):
            raise ArgumentError(f"{_MEASURES_WANTED}, it holds {quoted(entry)}")
        if function is not None and not name.isidentifier():
            raise ArgumentError(f"a measure of one's own has a name like 'reach_2', got {name!r}")
        if name in asked and asked[name] is not function:
            raise ArgumentError(f"`measures` has the name {name!r} twice")
        asked[name] = function
    return asked


def own_measures(
    functions: Mapping[str, Measure], mechanism: Mechanism, guess: str
) -> tuple[OwnMeasure, ...]:
    """Return measures of which each was tried once, at the pose where paths begin.

    Raises
    ------
    ArgumentError
        One fails there, or returns no number or array a pose; there is no J_eq.
    """
    if not functions:
        return ()
    few = FewPoses(mechanism)
    poses = few.close(mechanism.pose(guess).actuated[None], guess, enforce_limits=False)
    found = few.measures(poses.q)
    if (status := Status(found.status[0])) != Status.CLOSED:
        told = f"are tried at the guess, {guess!r}, where J_eq is {status.name}"
        raise ArgumentError(f"measures of one's own {told}: name another pose as `guess`")
    again = np.zeros(_TIMES_TRIED, dtype=np.intp)
    tried = poses.part(again), found.part(again)
    measures = [OwnMeasure(name, function, ()) for name, function in functions.items()]
    return tuple(
        OwnMeasure(one.name, one.function, one.numbers(*tried).shape[1:]) for one in measures
    )


def _pickled(function: Measure) -> bytes:
    """Return bytes that hold what can be imported nowhere, where a package for that is there."""
    for name in ("cloudpickle", "ray.cloudpickle"):  # Ray's own is for those who have Ray at hand
        if name == "cloudpickle" or "ray" in sys.modules:
            try:
                module = __import__(name, fromlist=["dumps"])
            except ImportError:
                continue
            return bytes(module.dumps(function))
    return pickle.dumps(function)


def _error_in_words(error: Exception) -> str:
    return shortened(f"{type(error).__name__}: {error}")
