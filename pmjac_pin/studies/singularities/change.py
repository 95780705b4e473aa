"""Change: how far poses are from one, by their motors or by all joints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, TypeAlias

import numpy as np
import pinocchio as pin

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, quoted, unknown_name
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import SMALLEST, as_number

Space: TypeAlias = Literal["motors", "joints"]


class ChangeFrom:
    """How far a pose is from a given one: what changes, and its derivative.

    Parameters
    ----------
    configuration : Configuration
    space : "motors" or "joints"
    weights : mapping of str to float
        How much a rad, or a metre, of a degree of freedom counts: 1 where it is not named.

    Raises
    ------
    UnknownNameError, ArgumentError
        No such motor or joint; a weight that is not positive.
    """

    def __init__(
        self, configuration: Configuration, space: Space, weights: Mapping[str, float]
    ) -> None:
        model = configuration.mechanism.kinematics.model
        partition = configuration.mechanism.problem.partition
        self._q, self._model, self.space = configuration.q, model, space
        self._columns = partition.actuated if space == "motors" else np.arange(model.nv)
        slides = np.array([partition.units[k] == "m" for k in range(model.nv)])
        self._stride = np.where(slides, partition.length, 1.0)
        self.unit: Literal["m", "rad"] = "m" if slides[self._columns].all() else "rad"
        self._scale = np.ones(slides.size) if self.unit == "m" else 1.0 / self._stride
        names = partition.columns
        allowed = partition.actuated_names if space == "motors" else tuple(names)
        for name, given in weights.items():
            if name not in allowed:
                raise unknown_name("motor" if space == "motors" else "joint", name, allowed)
            if not (weight := as_number(given, f"the weight of {name}")) >= SMALLEST:
                raise ArgumentError(f"the weight of {name} is positive, got {quoted(given)}")
            self._scale[names[name]] *= weight

    def __call__(self, q: Array) -> tuple[Array, Array]:
        """Return F (k,), in `unit`, and ∂F by q in lengths or rad (k, nv)."""
        change = pin.difference(self._model, self._q, q)
        by_q = pin.dDifference(self._model, self._q, q, pin.ARG1)
        scaled = self._scale[:, None] * by_q * self._stride
        return (self._scale * change)[self._columns], scaled[self._columns]
