"""Rows: the elementary equations that loops consist of, each said over any number type.

`rows` takes the two frames of a loop, seen from a body that carries both, and returns η with its
derivative; p₁ − p₂ and log R₁R₂ᵀ are in that body's axes. Where a number type has no roots, tilts
and turns are polynomials that vanish at half a turn as well; `cosine` is what tells the two apart.

Called with one pose that Pinocchio has computed, the same rows are evaluated fast. There the first
frame is seen from the second: its pose (R, p) changes with the joint rates by ṗ = P v and
Ṙ = [W v]ₓ R, in the second frame's axes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal, NamedTuple, Protocol

import numpy as np

from pmjac_pin.algebra import Number, RootedAlgebra
from pmjac_pin.algebra.jets import Jet, Jets, half_skew
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.ties import first_smallest

Measures = Literal["gap", "distance", "gap from second", "turns"]

HALF = np.array([[0.5]])
HALF_A_TURN = 1e-12  # 1 + cos(angle) below which the direction of a tilt is lost


class RelativePose(Protocol):
    """The first frame seen from the second, and how that changes; turns for frames only.

    Attributes
    ----------
    gap, gap_rates : ndarray, shapes (3,) and (3, nv)
        p and P, m.
    """

    @property
    def gap(self) -> Array: ...  # noqa: D102
    @property
    def gap_rates(self) -> Array: ...  # noqa: D102

    def axis(self, given: Array) -> tuple[Array, Array]:
        """Return R·given (3,), and its derivative (3, nv)."""
        ...

    def turn(self) -> tuple[Array, Array]:
        """Return log R (3,), and its derivative (3, nv)."""
        ...


class Seen(Protocol):
    """A frame seen from a body, with derivatives."""

    def origin(self) -> Jet:
        """Return p, components (3,)."""
        ...

    def carried(self, directions: Array) -> Jet:
        """Return R d for each row d, components (3, m)."""
        ...


class Equations(NamedTuple):
    """A block of rows over a number type.

    Attributes
    ----------
    rows : Jet, components (m,)
    cosine : Jet or None
        Of the angle between what the rows want to coincide, without derivatives: 1 where they
        vanish, −1 where they vanish by mistake. None where nothing can be mistaken.
    """

    rows: Jet
    cosine: Jet | None = None


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
    measures : str
        What they measure, for bounds on how much they can bend: the gap between the frames'
        origins, its square, the gap in axes of the second frame, or a product of turns.
    """

    @property
    def names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def unit(self) -> str: ...  # noqa: D102
    @property
    def vector(self) -> bool: ...  # noqa: D102
    @property
    def measures(self) -> Measures: ...  # noqa: D102

    def __call__(self, pose: RelativePose) -> tuple[Array, Array]:
        """Return the residual (rows,) and its derivative by the joint rates (rows, nv)."""
        ...

    def equations(self, jets: Jets, one: Seen, other: Seen) -> Equations:
        """Return the rows between two frames."""
        ...


@dataclass(frozen=True, slots=True)
class Gap:
    """η = p."""

    names: ClassVar = ("x", "y", "z")
    unit: ClassVar = "m"
    vector: ClassVar = True
    measures: ClassVar[Measures] = "gap"

    def __call__(self, pose: RelativePose) -> tuple[Array, Array]:
        """Return p and P."""
        return pose.gap, pose.gap_rates

    def equations(self, jets: Jets, one: Seen, other: Seen) -> Equations:
        """Return p₁ − p₂."""
        return Equations(one.origin() - other.origin())


@dataclass(frozen=True, slots=True)
class Along:
    """η = D p: the gap along some directions of the second frame, the rows of D."""

    directions: Array
    names: tuple[str, ...]
    unit: ClassVar = "m"
    vector: ClassVar = False
    measures: ClassVar[Measures] = "gap from second"

    def __call__(self, pose: RelativePose) -> tuple[Array, Array]:
        """Return D p and D P."""
        return self.directions.dot(pose.gap), self.directions.dot(pose.gap_rates)

    def equations(self, jets: Jets, one: Seen, other: Seen) -> Equations:
        """Return (R₂ d)·(p₁ − p₂) for each direction d."""
        gap, carried = one.origin() - other.origin(), other.carried(self.directions)
        return Equations(jets.dot(carried, gap[:, None]))


@dataclass(frozen=True, slots=True)
class Distance:
    """η = |p|² − length²."""

    length: float
    names: ClassVar = ("distance²",)
    unit: ClassVar = "m²"
    vector: ClassVar = False
    measures: ClassVar[Measures] = "distance"

    def __call__(self, pose: RelativePose) -> tuple[Array, Array]:
        """Return |p|² − length² and 2 pᵀ P."""
        square = pose.gap.dot(pose.gap) - self.length * self.length
        return np.array([square]), (2.0 * pose.gap).dot(pose.gap_rates)[None]

    def equations(self, jets: Jets, one: Seen, other: Seen) -> Equations:
        """Return |p₁ − p₂|² − length²."""
        square = jets.squared(one.origin() - other.origin())
        return Equations((square - jets.squared(jets.measured([self.length])))[None])


@dataclass(frozen=True, slots=True)
class Turn:
    """η = log R, the rotation vector."""

    names: ClassVar = ("turn x", "turn y", "turn z")
    unit: ClassVar = "rad"
    vector: ClassVar = True
    measures: ClassVar[Measures] = "turns"

    def __call__(self, pose: RelativePose) -> tuple[Array, Array]:
        """Return log R and its derivative."""
        return pose.turn()

    def equations(self, jets: Jets, one: Seen, other: Seen) -> Equations:
        """Return log R₁R₂ᵀ, or ½ vee(R₁R₂ᵀ − R₂R₁ᵀ) of length sin α."""
        axes, others = (jets.swapped(frame.carried(np.eye(3))) for frame in (one, other))
        between = jets.dot(axes[:, :, None], others[:, None])
        if jets.rooted:
            return Equations(jets.rotation_vector(between))
        still = between.still
        twice = still[0, 0] + still[1, 1] + still[2, 2] - jets.constant(1.0)
        return Equations(half_skew(jets, between), jets.times(HALF, twice[None])[0])


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
    measures: ClassVar[Measures] = "turns"

    def __call__(self, pose: RelativePose) -> tuple[Array, Array]:
        """Return η and its derivative."""
        turned, rates = pose.axis(self.axis)
        aside, above = self.across.dot(turned), 1.0 + self.axis.dot(turned)
        if above < HALF_A_TURN:
            return np.array([2.0, 0.0]), self.across.dot(rates)
        factor = math.sqrt(2.0 / above)
        slope = -0.5 * factor / above
        along = aside[:, None] * self.axis.dot(rates)
        return factor * aside, factor * self.across.dot(rates) + slope * along

    def equations(self, jets: Jets, one: Seen, other: Seen) -> Equations:
        """Return tₖ·a / cos(α/2), or tₖ·a of length sin α."""
        axis, carried = one.carried(self.axis[None]), other.carried(self._frame())
        if not jets.rooted:
            aside = jets.dot(carried[:, :2], axis)
            return Equations(aside, jets.dot(carried.still[:, 2], axis.still[:, 0]))
        whole = jets.dot(carried, axis)
        aside, above = whole[:2], jets.constant(1.0) + whole[2]
        chord = jets.of(_PerHalfCosine(), above) * aside
        return Equations(jets.replaced(chord, [2.0, 0.0], above, HALF_A_TURN))

    def _frame(self) -> Array:
        return np.vstack([self.across, self.axis])


class _PerHalfCosine:
    """1 / cos(α/2) as a function of 1 + cos α, bounded at half a turn."""

    def value(self, algebra: RootedAlgebra, x: Number) -> Number:
        """Return √(2/x)."""
        return algebra.sqrt(2.0 / algebra.largest(x, HALF_A_TURN))

    def slope(self, algebra: RootedAlgebra, x: Number) -> Number:
        """Return −½ √(2/x) / x."""
        return -0.5 * self.value(algebra, x) / algebra.largest(x, HALF_A_TURN)


@dataclass(frozen=True, slots=True)
class RightAngle:
    """η = a·b: the cosine between an axis of each frame, which are perpendicular."""

    first: Array
    second: Array
    names: ClassVar = ("right angle",)
    unit: ClassVar = "rad"
    vector: ClassVar = False
    measures: ClassVar[Measures] = "turns"

    def __call__(self, pose: RelativePose) -> tuple[Array, Array]:
        """Return b·R a and its derivative."""
        turned, rates = pose.axis(self.first)
        return np.array([self.second.dot(turned)]), self.second.dot(rates)[None]

    def equations(self, jets: Jets, one: Seen, other: Seen) -> Equations:
        """Return R₁a·R₂b."""
        axis, normal = one.carried(self.first[None]), other.carried(self.second[None])
        return Equations(jets.dot(axis, normal))


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
