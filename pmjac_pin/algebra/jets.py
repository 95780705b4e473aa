"""Jets: a value and its derivatives by some freedoms, over any other number type.

The freedoms are told by numbers, the columns of ∂/∂v: two jets need not depend on the same ones,
and what a value does not depend on costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.algebra import Algebra, Function, Number, RootedAlgebra
from pmjac_pin.values.arrays import Array

Columns = tuple[int, ...]

_TINY_SINE = 1e-9  # less counts as this much, at no turn and at half a turn


class Jet:
    """A number and its derivatives.

    Attributes
    ----------
    algebra : Algebra
        Of value and rates.
    value : number, (..., 1, b)
    rates : number, (..., k, b), or None
        None where it depends on nothing.
    columns : tuple of int
        The k freedoms that it depends on.
    """

    __slots__ = ("algebra", "columns", "rates", "value")

    def __init__(self, algebra: Algebra, value: Number, rates: Number, columns: Columns) -> None:
        self.algebra, self.value, self.rates, self.columns = algebra, value, rates, columns

    def __getitem__(self, index: Any) -> Jet:
        return self._each(lambda x: x[index])

    def __neg__(self) -> Jet:
        return self._each(lambda x: -x)

    def __add__(self, other: Jet) -> Jet:
        return self._with(self.value + other.value, self._part(), other._part())

    def __sub__(self, other: Jet) -> Jet:
        return self + (-other)

    def __mul__(self, other: Jet) -> Jet:
        return self.product(other, lambda x, y: x * y)

    @property
    def still(self) -> Jet:
        """The value, depending on nothing."""
        return Jet(self.algebra, self.value, None, ())

    def product(self, other: Jet, of: Callable[[Number, Number], Number]) -> Jet:
        """Return a product of two jets that is linear in each."""
        one = self._part(lambda rates: of(rates, other.value))
        return self._with(
            of(self.value, other.value), one, other._part(lambda rates: of(self.value, rates))
        )

    def _each(self, of: Callable[[Number], Number]) -> Jet:
        """Return a linear function of value and rates."""
        rates = None if self.rates is None else of(self.rates)
        return Jet(self.algebra, of(self.value), rates, self.columns)

    def _part(self, of: Callable[[Number], Number] = lambda x: x) -> tuple[Number, Columns]:
        return (None if self.rates is None else of(self.rates)), self.columns

    def _with(
        self, value: Number, one: tuple[Number, Columns], other: tuple[Number, Columns]
    ) -> Jet:
        """Return a jet whose rates are the sum of two, each by its own freedoms."""
        (rates, columns), (more, others) = one, other
        if more is None or rates is None:
            rates, columns = (rates, columns) if more is None else (more, others)
        elif columns == others:
            rates = rates + more
        else:
            columns, alone, shared, theirs, others_alone = _merged(columns, others)
            parts = [] if alone is None else [rates[..., alone, :]]
            if shared is not None:
                parts.append(rates[..., shared, :] + more[..., theirs, :])
            if others_alone is not None:
                parts.append(more[..., others_alone, :])
            rates = self.algebra.join(parts)
        return Jet(self.algebra, value, rates, columns)


class Jets:
    """The algebra of jets over another.

    Examples
    --------
    >>> from pmjac_pin.algebra.floats import Floats
    >>> floats = Floats()
    >>> x = Jet(floats, floats.constant([3.0]), floats.constant([1.0]), (0,))
    >>> square = Jets(floats).squared(x)
    >>> float(square.value[0, 0]), float(square.rates[0, 0])
    (9.0, 6.0)
    """

    __slots__ = ("base",)

    def __init__(self, base: Algebra) -> None:
        self.base = base

    @property
    def rooted(self) -> bool:
        """Whether the base is."""
        return self.base.rooted

    def constant(self, values: ArrayLike) -> Jet:
        """Return doubles that depend on nothing."""
        return Jet(self.base, self.base.constant(values), None, ())

    def measured(self, values: ArrayLike) -> Jet:
        """Return a model's numbers, which depend on nothing."""
        return Jet(self.base, self.base.measured(values), None, ())

    def stack(self, parts: Sequence[Jet]) -> Jet:
        """Return jets side by side: all by the freedoms that any depends on."""
        columns = parts[0].columns
        if any(part.columns != columns for part in parts):
            columns = tuple(dict.fromkeys(column for part in parts for column in part.columns))
        value = self.base.stack([part.value for part in parts])
        if not columns:
            return Jet(self.base, value, None, ())
        return Jet(
            self.base, value, self.base.stack([self._by(part, columns) for part in parts]), columns
        )

    def join(self, parts: Sequence[Jet]) -> Jet:
        """Return values one after another; they are not jets any more where they have rates."""
        raise NotImplementedError("the rates of jets are their own")

    def times(self, matrix: Array, x: Jet) -> Jet:
        """Return matrix @ x."""
        return x._each(lambda part: self.base.times(matrix, part))

    def directed(self, directions: Array, x: Jet) -> Jet:
        """Return directions @ x."""
        return x._each(lambda part: self.base.directed(directions, part))

    def dot(self, u: Jet, v: Jet) -> Jet:
        """Return u·v."""
        return u.product(v, self.base.dot)

    def squared(self, u: Jet) -> Jet:
        """Return u·u, with the value that is tightest."""
        rates = None
        if u.rates is not None:
            half = self.base.dot(u.rates, u.value)
            rates = half + half
        return Jet(self.base, self.base.squared(u.value), rates, u.columns)

    def cross(self, u: Jet, v: Jet) -> Jet:
        """Return u × v."""
        return u.product(v, self.base.cross)

    def swapped(self, x: Jet) -> Jet:
        """Return x with its two first components exchanged."""
        return x._each(self.base.swapped)

    def of(self, function: Function, x: Jet) -> Jet:
        """Return f(x)."""
        value, rates = function.value(self._rooted, x.value), x.rates
        if rates is not None:
            rates = function.slope(self._rooted, x.value) * rates
        return Jet(self.base, value, rates, x.columns)

    def replaced(self, x: Jet, by: ArrayLike, of: Jet, least: float) -> Jet:
        """Return x with another value where a scalar is below a double; its rates stay."""
        value = self._rooted.replaced(x.value, by, of.value, least)
        return Jet(self.base, value, x.rates, x.columns)

    def rotation_vector(self, rotation: Jet) -> Jet:
        """Return log R = f s, with s = ½ vee(R − Rᵀ) of length sin α and f = α / sin α."""
        rooted, s = self._rooted, half_skew(self, rotation)
        value = rooted.rotation_vector(rotation.value)
        if s.rates is None:
            return Jet(self.base, value, None, ())
        trace = rotation[0, 0] + rotation[1, 1] + rotation[2, 2]
        factor, slope = _angle_by_sine(rooted, rooted.sqrt(self.base.squared(value)))
        rates = factor * s.rates + s.value * (0.5 * slope * trace.rates)
        return Jet(self.base, value, rates, s.columns)

    @property
    def _rooted(self) -> RootedAlgebra:
        rooted: RootedAlgebra = self.base  # type: ignore[assignment]
        return rooted

    def _by(self, jet: Jet, columns: Columns) -> Number:
        """Return a jet's rates by more freedoms than it depends on."""
        if jet.columns == columns:
            return jet.rates
        nothing = self.base.constant(np.zeros(jet.value.shape[:-2]))
        parts = [
            jet.rates[..., [jet.columns.index(column)], :] if column in jet.columns else nothing
            for column in columns
        ]
        return self.base.join(parts)


def _angle_by_sine(rooted: RootedAlgebra, angle: Number) -> tuple[Number, Number]:
    """Return f = α / sin α and its derivative by cos α; large ones at half a turn.

    What the derivative loses to rounding at a small α is multiplied by α² wherever it is used.
    """
    angle = rooted.largest(angle, _TINY_SINE)
    sine = rooted.largest(rooted.sin(angle), _TINY_SINE)
    factor = angle / sine
    return factor, (factor * rooted.cos(angle) - 1.0) / (sine * sine)


def half_skew(algebra: Algebra, rotation: Number) -> Number:
    """Return ½ vee(R − Rᵀ) of a rotation (3, 3): its axis times the sine of its angle."""
    pairs = ((2, 1), (0, 2), (1, 0))
    whole = algebra.stack([rotation[i, j] - rotation[j, i] for i, j in pairs])
    return algebra.times(0.5 * np.eye(3), whole)


_Which = slice | list[int] | None


@lru_cache(maxsize=4096)
def _merged(one: Columns, other: Columns) -> tuple[Columns, _Which, _Which, _Which, _Which]:
    """Return all columns, and where each part of them is: in one alone, in both, in the other."""
    alone = [k for k, column in enumerate(one) if column not in other]
    shared = [k for k, column in enumerate(one) if column in other]
    theirs = [other.index(one[k]) for k in shared]
    others_alone = [k for k, column in enumerate(other) if column not in one]
    columns = [one[k] for k in alone + shared] + [other[k] for k in others_alone]
    return tuple(columns), *map(_which, (alone, shared, theirs, others_alone))  # type: ignore[return-value]


def _which(places: list[int]) -> _Which:
    """Return places as a slice where they are one: NumPy copies nothing then."""
    if not places:
        return None
    whole = list(range(places[0], places[0] + len(places)))
    return slice(whole[0], whole[-1] + 1) if places == whole else places
