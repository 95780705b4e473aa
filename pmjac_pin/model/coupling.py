"""Coupling: two joints geared together, η = q_second − ratio·q_first − offset."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.values.arrays import Array

N = TypeVar("N")


@dataclass(frozen=True, slots=True)
class Coupling:
    """The equation of two geared joints.

    Attributes
    ----------
    gradient : ndarray, shape (nv,)
        ∂η/∂v: −ratio for the first joint, 1 for the second.
    unit : str
        The second joint's, "rad" or "m".
    """

    coordinates: JointCoordinates
    columns: NDArray[np.intp]
    ratio: float
    offset: float
    gradient: Array
    unit: str

    def residual(self, q: Array) -> float:
        """Return η at q; for a second joint without end, within half a turn."""
        first, second = self.coordinates.values(q)[self.columns].tolist()
        return float(self.equation(first, second, _within_half_a_turn))

    def equation(self, first: N, second: N, wrapped: Callable[[N], N]) -> N:
        """Return η of the joints' values, over any number type.

        Parameters
        ----------
        first, second : numbers
        wrapped : callable
            angle ↦ the same angle within half a turn, for a second joint without end.
        """
        difference: Any = second - self.ratio * first - self.offset  # type: ignore[operator]
        return wrapped(difference) if self.coordinates.wraps[self.columns[1]] else difference


def _within_half_a_turn(angle: float) -> float:
    return math.remainder(angle, math.tau)


def couple(model: pin.Model, loop: JointLoop) -> Coupling:
    """Return the equation of a joint loop.

    Raises
    ------
    UnknownNameError
        No such joint.
    ArgumentError
        A joint with several degrees of freedom, or one without end whose turns would have to
        be counted.
    """
    coordinates = JointCoordinates(model)
    for name in loop.joints:
        if (count := coordinates.degrees_of_freedom(name)) != 1:
            raise ArgumentError(
                f"a joint loop gears joints of one degree of freedom; joint {name!r} has {count}"
            )
    columns = coordinates.columns(loop.joints)
    endless = coordinates.wraps[columns].tolist()
    if endless[0] and not (endless[1] and loop.ratio.is_integer()):
        raise ArgumentError(
            f"joint {loop.joints[0]!r} turns without end and drives {loop.joints[1]!r} by a ratio "
            f"of {loop.ratio:g}, but its turns are not counted; make both `revolute`"
        )
    gradient = np.zeros(model.nv)
    gradient[columns] = -loop.ratio, 1.0
    unit = "rad" if coordinates.rotational[columns[1]] else "m"
    return Coupling(coordinates, columns, loop.ratio, loop.offset, gradient, unit)
