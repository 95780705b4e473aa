"""Number types over which the kinematics is written once.

A number x of any of these types is an array, components first, and then always two axes:

    scalar (k, b)    vector (3, k, b)    columns of a matrix (3, 3, k, b)

with b poses, and k rates: a value has k = 1, its derivatives by k freedoms are one more array with
the same components. So +, − and × broadcast whatever the components are, and what a value goes
through linearly its derivatives go through as well, in the same operation.

The numbers of one type have +, −, × among themselves, and `[...]` on components. An `Algebra` has
the rest: constants, products with matrices of doubles, and sums of products, which some types know
better than by + and ×. `Jets` are an algebra over any other: a value with its derivatives.

The pose of a body is [R p], whose columns are numbers. A joint multiplies it from the right,

    X ↦ X · place · M(θ),    ∂X/∂θₖ = X ξₖ^ at the joint itself, then through the same products,

ξₖ being the unit twist of its k-th freedom in the moved frame, a constant. As a motion of the
world the same derivative is a twist (ω, v): ω × R and v + ω × p. Boxes need the first, in which no
difference of two poses is taken; floats and balls need the second, which costs less.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from numpy.typing import ArrayLike

from pmjac_pin.values.arrays import Array

#: A number of one of the types: an array of floats, `Intervals`, an array of objects, a `Jet`.
Number = Any


class Algebra(Protocol):
    """What the kinematics asks of a number type beside +, −, × and components.

    Attributes
    ----------
    rooted : bool
        It has square roots and logarithms, so that tilts and turns are measured by their chords
        and angles; otherwise by polynomials, which vanish at half a turn as well.
    """

    @property
    def rooted(self) -> bool: ...  # noqa: D102

    def constant(self, values: ArrayLike) -> Number:
        """Return doubles as numbers, their axes the components."""
        ...

    def measured(self, values: ArrayLike) -> Number:
        """Return doubles that stand for a model's own numbers, as far as these are known."""
        ...

    def stack(self, parts: Sequence[Number]) -> Number:
        """Return numbers side by side, as components."""
        ...

    def join(self, parts: Sequence[Number]) -> Number:
        """Return numbers of the same components one after another along the rates."""
        ...

    def times(self, matrix: Array, x: Number) -> Number:
        """Return a matrix (m, n) of doubles times the n first components of x."""
        ...

    def directed(self, directions: Array, x: Number) -> Number:
        """Return a model's unit vectors, one a row, as far as these are known, times x."""
        ...

    def dot(self, u: Number, v: Number) -> Number:
        """Return the sum of products over the first components."""
        ...

    def squared(self, u: Number) -> Number:
        """Return u·u."""
        ...

    def cross(self, u: Number, v: Number) -> Number:
        """Return u × v over the first components."""
        ...

    def swapped(self, x: Number) -> Number:
        """Return x with its two first components exchanged: a matrix transposed."""
        ...


class RootedAlgebra(Algebra, Protocol):
    """An algebra with functions of its numbers."""

    def sqrt(self, x: Number) -> Number: ...  # noqa: D102
    def sin(self, x: Number) -> Number: ...  # noqa: D102
    def cos(self, x: Number) -> Number: ...  # noqa: D102

    def largest(self, x: Number, y: float) -> Number:
        """Return the larger of each number and a double."""
        ...

    def replaced(self, x: Number, by: ArrayLike, of: Number, least: float) -> Number:
        """Return x, of constant components `by` where a scalar is below a double."""
        ...

    def rotation_vector(self, rotation: Number) -> Number:
        """Return the logarithm of a rotation (3, 3)."""
        ...


class Function(Protocol):
    """A function of one real number."""

    def value(self, algebra: RootedAlgebra, x: Number) -> Number:
        """Return f(x)."""
        ...

    def slope(self, algebra: RootedAlgebra, x: Number) -> Number:
        """Return f′(x)."""
        ...
