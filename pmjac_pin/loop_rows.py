"""Rows: what each kind of loop asks of the pose of its first frame, seen from its second.

The pose (R, p) changes with the joint rates by ṗ = P v and Ṙ = [W v]ₓ R, both in the second
frame's axes. A kind of loop is a few blocks of rows, each a residual and its derivative, exact
on and off closure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.ties import first_smallest

Array = NDArray[np.float64]

HALF_A_TURN = 1e-12  # 1 + cos(angle) below which the direction of a tilt is lost


@dataclass(frozen=True, slots=True)
class Relative:
    """The first frame seen from the second, and how that changes; the last two for frames only.

    Attributes
    ----------
    gap, gap_rates : ndarray, shapes (3,) and (3, nv)
        p and P, m.
    rotation, turning : ndarray, shapes (3, 3) and (3, nv)
        R and W, rad.
    """

    gap: Array
    gap_rates: Array
    rotation: Array | None = None
    turning: Array | None = None

    def axis(self, given: Array) -> tuple[Array, Array]:
        """Return R·given (3,), and its derivative (3, nv)."""
        axis = np.asarray(self.rotation) @ given
        return axis, -pin.skew(axis) @ np.asarray(self.turning)


class Rows(Protocol):
    """A block of rows of a loop's equations.

    Attributes
    ----------
    names : tuple of str
        What each row measures.
    unit : str
        "m", "rad" or "m²".
    vector : bool
        The rows are a vector's components and turn with the axes.
    """

    @property
    def names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def unit(self) -> str: ...  # noqa: D102
    @property
    def vector(self) -> bool: ...  # noqa: D102

    def __call__(self, pose: Relative) -> tuple[Array, Array]:
        """Return the residual (rows,) and its derivative by the joint rates (rows, nv)."""
        ...


@dataclass(frozen=True, slots=True)
class Gap:
    """η = p."""

    names: ClassVar = ("x", "y", "z")
    unit: ClassVar = "m"
    vector: ClassVar = True

    def __call__(self, pose: Relative) -> tuple[Array, Array]:
        """Return p and P."""
        return pose.gap, pose.gap_rates


@dataclass(frozen=True, slots=True)
class Along:
    """η = D p: the gap along some directions of the second frame, the rows of D."""

    directions: Array
    names: tuple[str, ...]
    unit: ClassVar = "m"
    vector: ClassVar = False

    def __call__(self, pose: Relative) -> tuple[Array, Array]:
        """Return D p and D P."""
        return self.directions @ pose.gap, self.directions @ pose.gap_rates


@dataclass(frozen=True, slots=True)
class Distance:
    """η = |p|² − length²."""

    length: float
    names: ClassVar = ("distance²",)
    unit: ClassVar = "m²"
    vector: ClassVar = False

    def __call__(self, pose: Relative) -> tuple[Array, Array]:
        """Return |p|² − length² and 2 pᵀ P."""
        square = pose.gap @ pose.gap - self.length * self.length
        return np.array([square]), (2.0 * pose.gap @ pose.gap_rates)[None]


@dataclass(frozen=True, slots=True)
class Turn:
    """η = log R, the rotation vector."""

    names: ClassVar = ("turn x", "turn y", "turn z")
    unit: ClassVar = "rad"
    vector: ClassVar = True

    def __call__(self, pose: Relative) -> tuple[Array, Array]:
        """Return log R and J_log(R) Rᵀ W: Pinocchio's J_log takes the rate in R's own axes."""
        rotation = np.asarray(pose.rotation)
        return pin.log3(rotation), pin.Jlog3(rotation) @ rotation.T @ pose.turning


@dataclass(frozen=True, slots=True)
class Tilt:
    """η = T a / cos(α/2), of length 2 sin(α/2): the axis a = R b seen across b, at angle α to it.

    The rows of T are perpendicular to b. T a alone would vanish at half a turn, too.
    """

    axis: Array
    across: Array
    names: ClassVar = ("tilt 1", "tilt 2")
    unit: ClassVar = "rad"
    vector: ClassVar = False

    def __call__(self, pose: Relative) -> tuple[Array, Array]:
        """Return η and its derivative."""
        turned, rates = pose.axis(self.axis)
        aside, above = self.across @ turned, 1.0 + self.axis @ turned
        if above < HALF_A_TURN:
            return np.array([2.0, 0.0]), self.across @ rates
        factor = math.sqrt(2.0 / above)
        slope = -0.5 * factor / above
        along = np.outer(aside, self.axis @ rates)
        return factor * aside, factor * (self.across @ rates) + slope * along


@dataclass(frozen=True, slots=True)
class RightAngle:
    """η = a·b: the cosine between an axis of each frame, which are perpendicular."""

    first: Array
    second: Array
    names: ClassVar = ("right angle",)
    unit: ClassVar = "rad"
    vector: ClassVar = False

    def __call__(self, pose: Relative) -> tuple[Array, Array]:
        """Return b·R a and its derivative."""
        turned, rates = pose.axis(self.first)
        return np.array([self.second @ turned]), (self.second @ rates)[None]


def across(axis: Array) -> Array:
    """Return two unit vectors perpendicular to a unit vector and to each other, shape (2, 3).

    Examples
    --------
    >>> across(np.array([0.0, 0.0, 1.0])).tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    """
    shortest = np.eye(3)[first_smallest(axis)]
    first = shortest - (shortest @ axis) * axis
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(axis, first)])
