"""Springs in joints of one degree of freedom."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_numbers

#: By joint: stiffness, N/m or N m/rad, and the value at rest, m or rad.
Springs: TypeAlias = Mapping[str, tuple[float, float]]


def spring_efforts(coordinates: JointCoordinates, q: Array, springs: Springs) -> Array:
    """Return what it takes to hold joints against their springs, k (x − x₀), shape (nv,).

    What turns endlessly is the shorter way from x₀.

    Parameters
    ----------
    coordinates : JointCoordinates
    q : ndarray, shape (nq,)
    springs : Springs

    Raises
    ------
    UnknownNameError, ArgumentError
    """
    if not isinstance(springs, Mapping):
        wanted = "springs are a mapping of joints to (stiffness, value at rest)"
        raise ArgumentError(f"{wanted}, got {quoted(springs)}")
    efforts = np.zeros(coordinates.rotational.size)
    for name, given in springs.items():
        spring = as_numbers(given, f"the spring of joint {quoted(name)}")
        if spring.shape != (2,) or coordinates.degrees_of_freedom(name) != 1:
            wanted = "a joint of one degree of freedom takes (stiffness, value at rest)"
            raise ArgumentError(f"{wanted}, got {quoted(given)} for {quoted(name)}")
        column = coordinates.columns([name])
        efforts[column] = -spring[0] * coordinates.motion_to(q, column, spring[1:])
    return efforts
