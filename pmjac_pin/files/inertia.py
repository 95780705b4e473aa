"""An inertia from its numbers, and what must hold of them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.errors import ModelFileError

_LEAST_MOMENT = -1e-9  # of the largest moment: what rounding makes of zero


def inertia_at(
    where: str, mass: float, moments: NDArray[np.float64], placement: pin.SE3
) -> pin.Inertia:
    """Return an inertia whose centre and axes are placed in a frame, in that frame.

    Parameters
    ----------
    where : str
        How messages call it.
    mass : float
        kg.
    moments : ndarray, shape (3, 3)
        About the centre, kg m².
    placement : pin.SE3

    Raises
    ------
    ModelFileError
        A mass or a moment below zero.
    """
    if mass < 0.0:
        raise ModelFileError(f"{where}: the mass is {mass:g}; it must not be negative")
    principal, axes = np.linalg.eigh(moments)
    if principal[0] < _LEAST_MOMENT * max(abs(principal[0]), principal[2]):
        raise ModelFileError(f"{where}: a moment of inertia is {principal[0]:g}, below zero")
    turned = placement.rotation @ axes
    kept = turned @ np.diag(np.maximum(principal, 0.0)) @ turned.T
    return pin.Inertia(mass, placement.translation, (kept + kept.T) / 2.0)
