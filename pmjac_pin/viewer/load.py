"""Load: what hangs at the tool or pushes it, as the page's sliders say it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.values.arrays import Array

LoadKind = Literal["weight", "force"]

LARGEST_LOAD = 1e6  # kg, N
DOWN = -0.5 * math.pi


@dataclass(frozen=True, slots=True)
class Load:
    """A weight at the tool, or a force on it: both at its origin, without a moment.

    Attributes
    ----------
    kind : {"weight", "force"}
        Which of the two acts.
    mass : float
        kg, hung at the tool.
    size : float
        Of the force, N.
    azimuth, elevation : float
        Of its direction, rad: from the world's x towards y, and from that plane towards z.
    """

    kind: LoadKind = "weight"
    mass: float = 0.0
    size: float = 0.0
    azimuth: float = 0.0
    elevation: float = DOWN

    def __post_init__(self) -> None:
        for name, unit in (("mass", "kg"), ("size", "N")):
            given = getattr(self, name)
            if not 0.0 <= given <= LARGEST_LOAD:
                raise ArgumentError(
                    f"{name} is 0 to {LARGEST_LOAD:g} {unit}, got {quoted(float(given))}"
                )
        for name in ("azimuth", "elevation"):
            given = getattr(self, name)
            if not abs(given) <= 2.0 * math.pi:
                raise ArgumentError(f"{name} is at most a turn, got {quoted(float(given))}")

    def force(self, mechanism: Mechanism) -> Array:
        """Return the force on the tool, N, in the world.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> Load("weight", mass=2.0).force(pj.load("four_bar")).tolist()
        [0.0, 0.0, -19.62]
        """
        if self.kind == "weight":
            return np.asarray(self.mass * gravity_of(mechanism))
        across = math.cos(self.elevation)
        way = (
            across * math.cos(self.azimuth),
            across * math.sin(self.azimuth),
            math.sin(self.elevation),
        )
        return self.size * np.array(way)


def gravity_of(mechanism: Mechanism) -> Array:
    """Return the acceleration of gravity, m/s², in the world."""
    return np.array(mechanism.kinematics.model.gravity.linear)
