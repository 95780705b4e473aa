"""Work: what is computed for each chunk of a sweep, in whatever process."""

from __future__ import annotations

import pickle
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.batch import Batch
from pmjac_pin.batches.few_poses import batch_of
from pmjac_pin.errors import ClosureError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.sweep.points import Points, Region
from pmjac_pin.studies.sweep.variables import VARIABLES, SeenPoses
from pmjac_pin.values.arrays import Array, Index

_MACHINES = 8  # kept in each process


@dataclass(frozen=True, slots=True, eq=False)
class SweepWork:
    """A sweep, less where its results go.

    Attributes
    ----------
    machine : bytes
        A pickled mechanism.
    points : Points
    motors, parameters : tuple of str
        The names of the points.
    measures : tuple of str
        Of `VARIABLES`.
    labels : mapping
        Of the axes that are not those of the points.
    guess : str
        The pose that all paths begin at.
    enforce_limits : bool or "all"
    """

    machine: bytes
    points: Points
    motors: tuple[str, ...]
    parameters: tuple[str, ...]
    measures: tuple[str, ...]
    labels: Mapping[str, Sequence[str]]
    guess: str
    enforce_limits: bool | str

    def compute(self, region: Region) -> dict[str, NDArray[Any]]:
        """Return the measures in a region."""
        values = self.points.at(region)
        shape = [part.stop - part.start for part in region]
        count = int(np.prod(shape))
        found = {name: VARIABLES[name].empty([count], self.labels) for name in self.measures}
        for parameters, which in self._machines(values, count):
            if (mechanism := _machine_at(self.machine, parameters)) is not None:
                many = batch_of(mechanism, which.size)
                targets = self._targets(many, values, which)
                poses = many.close(
                    targets, self.guess, enforce_limits=self.enforce_limits, threads=1
                )
                seen = SeenPoses(many, poses)
                for name in self.measures:
                    found[name][which] = VARIABLES[name].of(seen)
        return {name: array.reshape(*shape, *array.shape[1:]) for name, array in found.items()}

    def _machines(
        self, values: Mapping[str, Array], count: int
    ) -> Iterator[tuple[tuple[tuple[str, float], ...], Index]]:
        """Yield the parameters by their names, and which points have them."""
        if not self.parameters:
            yield (), np.arange(count)
            return
        table = np.column_stack([values[name] for name in self.parameters])
        rows, which = np.unique(table, axis=0, return_inverse=True)
        for k, row in enumerate(rows.tolist()):
            yield tuple(zip(self.parameters, row, strict=True)), np.flatnonzero(which.ravel() == k)

    def _targets(self, many: Batch, values: Mapping[str, Array], which: Index) -> Array:
        """Return the motors' values, of home where they are not swept."""
        targets = np.tile(many.mechanism.pose(self.guess).actuated, (which.size, 1))
        for name in self.motors:
            targets[:, many.mechanism.actuated.index(name)] = values[name][which]
        return targets


@lru_cache(maxsize=_MACHINES)
def _unpickled_machine(machine: bytes) -> Mechanism:
    mechanism: Mechanism = pickle.loads(machine)
    return mechanism


@lru_cache(maxsize=_MACHINES)
def _machine_at(machine: bytes, parameters: tuple[tuple[str, float], ...]) -> Mechanism | None:
    """Return a machine at some parameters; None where it does not assemble."""
    try:
        return _unpickled_machine(machine).with_parameters(dict(parameters))
    except ClosureError:
        return None
