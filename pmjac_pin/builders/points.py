"""Places that a caller gave for a machine: points, lengths, a pose."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import SMALLEST, as_number, as_numbers


def points(given: ArrayLike, what: str, count: int) -> Array:
    """Return points, shape (count, 3).

    Raises
    ------
    ArgumentError
    """
    found = as_numbers(given, what)
    if found.shape != (count, 3):
        raise ArgumentError(f"{what} of shape ({count}, 3) expected, got {found.shape}")
    return found


def as_radii(given: ArrayLike, what: str, count: int) -> list[float]:
    """Return positive lengths, m.

    Raises
    ------
    ArgumentError
    """
    found = as_numbers(given, what)
    if found.shape != (count,) or found.min() < SMALLEST:
        raise ArgumentError(
            f"{what}: {count} lengths of {SMALLEST:g} m or more expected, got {quoted(given)}"
        )
    values: list[float] = found.tolist()
    return values


def as_length(given: float, what: str) -> float:
    """Return a positive length, m.

    Raises
    ------
    ArgumentError
    """
    value = as_number(given, what)
    if value < SMALLEST:
        raise ArgumentError(f"{what} must be {SMALLEST:g} m or more, got {quoted(given)}")
    return value


def as_pose(given: float | pin.SE3) -> pin.SE3:
    """Return a pose: a height alone is one above the origin.

    Raises
    ------
    ArgumentError
    """
    if isinstance(given, pin.SE3):
        entries = given.homogeneous
        turned = entries[:3, :3]
        if not np.isfinite(entries).all() or np.abs(turned @ turned.T - np.eye(3)).max() > 1e-6:
            raise ArgumentError(
                "the platform's pose holds no rotation, or numbers that are not finite"
            )
        if np.linalg.det(turned) < 0.0:
            raise ArgumentError("the platform's pose is a reflection: it holds no rotation")
        return pin.SE3(given)
    return pin.SE3(np.eye(3), np.array([0.0, 0.0, as_number(given, "the platform's height")]))


def upright(way: Array) -> Array:
    """Return a rotation whose z is along a way, turned from the world's z as little as can be."""
    length = float(np.linalg.norm(way))
    if not length > 0.0:
        return np.eye(3)
    z, along = np.array([0.0, 0.0, 1.0]), way / length
    if along[2] < -0.5:  # downwards: a half turn about x comes first
        flip = np.diag([1.0, -1.0, -1.0])
        turned: Array = pin.Quaternion.FromTwoVectors(flip @ z, along).toRotationMatrix() @ flip
        return turned
    found: Array = pin.Quaternion.FromTwoVectors(z, along).toRotationMatrix()
    return found
