"""Work: what is computed for each chunk of a sweep, in whatever process."""

from __future__ import annotations

import pickle
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.designs import Designs
from pmjac_pin.batches.few_poses import batch_of
from pmjac_pin.batches.pieces import PIECE
from pmjac_pin.errors import ClosureError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import enforced
from pmjac_pin.studies.sweep.own_measures import OwnMeasure
from pmjac_pin.studies.sweep.points import Points, Region
from pmjac_pin.studies.sweep.variables import (
    VARIABLES,
    AlikePoses,
    AxisLabels,
    SeenPoses,
    Variable,
    own_variable,
)
from pmjac_pin.values.arrays import Array, Index

_MACHINES = 8  # kept in each process
_DESIGNS, _DESIGNS_PER_ENTRY = 8.0, 0.05  # built while the programs of all are recorded


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
        Of `VARIABLES`, or of `own`.
    own : tuple of OwnMeasure
    labels : mapping
        Of the axes that are not those of the points.
    designs : int
        How many different values the parameters have, or at least.
    guess : str
        The pose that all paths begin at.
    enforce_limits : bool or "all"
    """

    machine: bytes
    points: Points
    motors: tuple[str, ...]
    parameters: tuple[str, ...]
    measures: tuple[str, ...]
    own: tuple[OwnMeasure, ...]
    labels: Mapping[str, AxisLabels]
    designs: int
    guess: str
    enforce_limits: bool | str

    @property
    def variables(self) -> dict[str, Variable]:
        """What is computed, by name."""
        own = {one.name: own_variable(one) for one in self.own}
        return {name: own.get(name) or VARIABLES[name] for name in self.measures}

    def compute(self, region: Region) -> dict[str, NDArray[Any]]:
        """Return the measures in a region."""
        values = self.points.at(region)
        shape = [part.stop - part.start for part in region]
        count = int(np.prod(shape))
        found = {name: one.empty([count], self.labels) for name, one in self.variables.items()}
        left = self._by_designs(values, found)
        for parameters, which in self._machines(values, left):
            if (mechanism := _machine_at(self.machine, parameters)) is not None:
                many = batch_of(mechanism, which.size)
                at_rest = mechanism.pose(self.guess).actuated
                targets = self._targets(mechanism, at_rest, values, which)
                poses = many.close(
                    targets, self.guess, enforce_limits=self.enforce_limits, threads=1
                )
                self._put(found, which, SeenPoses(AlikePoses(many), poses, self.measures))
        return {name: array.reshape(*shape, *array.shape[1:]) for name, array in found.items()}

    def _by_designs(self, values: Mapping[str, Array], found: dict[str, NDArray[Any]]) -> Index:
        """Compute what is certain of all designs at once; return the points that are left."""
        count = len(next(iter(values.values())))
        every = np.arange(count)
        if not self.parameters or self.guess != "home":
            return every
        mechanism, left = _unpickled_machine(self.machine), []
        few = self.designs < _enough_designs(mechanism)
        designs = None if few else _designs_of(self.machine, self.parameters)
        if designs is None:
            return every
        for start in range(0, count, PIECE):
            which = every[start : start + PIECE]
            many = designs.at(*self._designs(values, which))
            targets = self._targets(mechanism, many.at_rest, values, which)
            poses = many.close(targets, enforced(self.enforce_limits))
            seen = SeenPoses(many, poses, self.measures)
            self._put(found, which, seen)
            left.append(which[~seen.known()])
            for name, variable in self.variables.items():
                found[name][left[-1]] = variable.nothing
        return np.concatenate(left)

    def _put(self, found: dict[str, NDArray[Any]], which: Index, seen: SeenPoses) -> None:
        for name, variable in self.variables.items():
            found[name][which] = variable.of(seen)

    def _designs(self, values: Mapping[str, Array], which: Index) -> tuple[Array, Index]:
        """Return the values of parameters that some points have, and which of these each has."""
        table = np.column_stack([values[name][which] for name in self.parameters])
        rows, design = np.unique(table, axis=0, return_inverse=True)
        return rows, design.ravel()

    def _machines(
        self, values: Mapping[str, Array], which: Index
    ) -> Iterator[tuple[tuple[tuple[str, float], ...], Index]]:
        """Yield parameters by their names, and which of these points have them."""
        if not self.parameters:
            yield (), which
            return
        rows, design = self._designs(values, which)
        for k, row in enumerate(rows.tolist()):
            yield tuple(zip(self.parameters, row, strict=True)), which[design == k]

    def _targets(
        self, mechanism: Mechanism, at_rest: Array, values: Mapping[str, Array], which: Index
    ) -> Array:
        """Return the motors' values, as they are at rest where they are not swept."""
        targets = np.empty((which.size, len(mechanism.actuated)))
        targets[:] = at_rest
        for name in self.motors:
            targets[:, mechanism.actuated.index(name)] = values[name][which]
        return targets


def _enough_designs(mechanism: Mechanism) -> float:
    """Return from how many designs on it pays to record their programs."""
    partition = mechanism.problem.partition
    entries = (partition.row_scale.size + 6) * partition.column_scale.size
    return _DESIGNS + _DESIGNS_PER_ENTRY * entries


@lru_cache(maxsize=_MACHINES)
def _designs_of(machine: bytes, parameters: tuple[str, ...]) -> Designs | None:
    return Designs.of(_unpickled_machine(machine), parameters)


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
