"""Series: Taylor polynomials in a few variables, up to an order, whose coefficients are boxes.

A coefficient holds what it stands for at every point that its box holds. So with t from 0 in a
cube |t| ≤ 1, coefficients at the point 0 below the order and over the whole cube at the order,

    f(t) ∈ Σ_{|α| < k} f_α(0) t^α + Σ_{|α| = k} f_α(cube) t^α,

which is as sharp as the cube is small to the power k. What is not there is exactly 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.algebra.boxes import BOXES
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.values.arrays import Array

#: Of each variable.
Exponents = tuple[int, ...]

_ROOT = (1.0, -0.5, 0.375, -0.3125, 0.2734375)  # of (1 + x)^(−1/2), exact in binary


class Series:
    """A number: coefficients by their exponents, that of degree 0 among them.

    Attributes
    ----------
    order : int
        The largest degree that is kept.
    terms : mapping of tuple of int to Intervals
    """

    __slots__ = ("order", "terms")

    def __init__(self, order: int, terms: Mapping[Exponents, Intervals]) -> None:
        self.order, self.terms = order, terms

    @property
    def shape(self) -> tuple[int, ...]:
        """That of each coefficient, as far as they are not broadcast."""
        return np.broadcast_shapes(*(term.shape for term in self.terms.values()))

    @property
    def value(self) -> Intervals:
        """The coefficient of degree 0."""
        return self.terms[self.constant]

    @property
    def constant(self) -> Exponents:
        """The exponents of degree 0."""
        return (0,) * len(next(iter(self.terms)))

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, index: Any) -> Series:
        return self.each(lambda term: term[index])

    def __neg__(self) -> Series:
        return self.each(lambda term: -term)

    def __add__(self, other: Series) -> Series:
        return Series(self.order, _sum(self.terms, other.terms))

    def __sub__(self, other: Series) -> Series:
        return self + (-other)

    def __mul__(self, other: Series) -> Series:
        return Series(self.order, _product(self.terms, other.terms, self.order))

    def each(self, of: Callable[[Intervals], Intervals]) -> Series:
        """Return a linear function of the coefficients."""
        return Series(self.order, {exponents: of(term) for exponents, term in self.terms.items()})


class SeriesAlgebra:
    """The algebra of series in some variables.

    Parameters
    ----------
    variables, order : int
        The order is 4 at most.

    Examples
    --------
    >>> import numpy as np
    >>> algebra = SeriesAlgebra(1, 2)
    >>> x = algebra.variable(0, Intervals.exact([[0.0]]), Intervals.exact([[1.0]]))
    >>> cosine = algebra.cos(x)
    >>> [float(cosine.terms[k,].middle[0, 0].round(12)) + 0.0 for k in range(3)]
    [1.0, 0.0, -0.5]
    """

    __slots__ = ("order", "variables")

    rooted = False

    def __init__(self, variables: int, order: int) -> None:
        self.variables, self.order = variables, order

    def variable(self, which: int, at: Intervals, slope: Intervals) -> Series:
        """Return at + slope t of one of the variables t, components none."""
        first = tuple(int(k == which) for k in range(self.variables))
        return Series(self.order, {self._constant: at, first: slope})

    def boxes(self, values: Intervals) -> Series:
        """Return intervals that depend on no variable."""
        return Series(self.order, {self._constant: values})

    def constant(self, values: ArrayLike) -> Series:
        """Return doubles that depend on no variable."""
        return self.boxes(BOXES.constant(values))

    def measured(self, values: ArrayLike) -> Series:
        """Return a model's numbers as they are stored."""
        return self.constant(values)

    def stack(self, parts: Sequence[Series]) -> Series:
        """Return series side by side along a new first axis."""
        return self._together(parts, BOXES.stack)

    def join(self, parts: Sequence[Series]) -> Series:
        """Return series one after another along the rates."""
        return self._together(parts, BOXES.join)

    def times(self, matrix: Array, x: Series) -> Series:
        """Return matrix @ x."""
        return x.each(lambda term: BOXES.times(matrix, term))

    def directed(self, directions: Array, x: Series) -> Series:
        """Return directions @ x."""
        return self.times(directions, x)

    def dot(self, u: Series, v: Series) -> Series:
        """Return u·v."""
        return (u * v).each(lambda term: term.sum(0))

    def squared(self, u: Series) -> Series:
        """Return u·u."""
        return self.dot(u, u)

    def cross(self, u: Series, v: Series) -> Series:
        """Return u × v."""
        (a, b, c), (x, y, z) = ((w[0], w[1], w[2]) for w in (u, v))
        return self.stack([b * z - c * y, c * x - a * z, a * y - b * x])

    def swapped(self, x: Series) -> Series:
        """Return x with its two first components exchanged."""
        return x.each(BOXES.swapped)

    def cos(self, x: Series) -> Series:
        """Return cos x."""
        cosine, sine = x.value.cos(), x.value.sin()
        return self._composed(x, [cosine, -sine, -cosine, sine, cosine])

    def sin(self, x: Series) -> Series:
        """Return sin x."""
        cosine, sine = x.value.cos(), x.value.sin()
        return self._composed(x, [sine, cosine, -sine, -cosine, sine])

    def unit(self, x: Series) -> Series:
        """Return x by its length, over the first components."""
        square = self.squared(x)
        inverse = Intervals.exact(1.0) / square.value
        power, slopes = inverse.sqrt(), []
        for k, factor in enumerate(_ROOT):
            slopes.append(power * Intervals.exact(factor * _FACTORIAL[k]))
            power = power * inverse
        return x * self._composed(square, slopes)

    @property
    def _constant(self) -> Exponents:
        return (0,) * self.variables

    def _together(
        self, parts: Sequence[Series], how: Callable[[Sequence[Intervals]], Intervals]
    ) -> Series:
        shapes = [part.shape for part in parts]

        def term(exponents: Exponents) -> Intervals:
            return how([_term(*one, exponents) for one in zip(parts, shapes, strict=True)])

        exponents = dict.fromkeys(key for part in parts for key in part.terms)
        return Series(self.order, {key: term(key) for key in exponents})

    def _composed(self, x: Series, slopes: Sequence[Intervals]) -> Series:
        """Return f(x) of f and its derivatives at x's constant coefficient."""
        away = {key: term for key, term in x.terms.items() if any(key)}
        found: Mapping[Exponents, Intervals] = {}
        for k in reversed(range(self.order + 1)):
            slope = slopes[k] / Intervals.exact(_FACTORIAL[k])
            found = _sum(_product(found, away, self.order), {self._constant: slope})
        return Series(self.order, found)


_FACTORIAL = (1.0, 1.0, 2.0, 6.0, 24.0)


def _term(series: Series, shape: tuple[int, ...], exponents: Exponents) -> Intervals:
    term = series.terms.get(exponents)
    return Intervals.exact(np.zeros(shape)) if term is None else term


def _sum(
    one: Mapping[Exponents, Intervals], other: Mapping[Exponents, Intervals]
) -> dict[Exponents, Intervals]:
    found = dict(one)
    for exponents, term in other.items():
        found[exponents] = found[exponents] + term if exponents in found else term
    return found


def _product(
    one: Mapping[Exponents, Intervals], other: Mapping[Exponents, Intervals], order: int
) -> dict[Exponents, Intervals]:
    found: dict[Exponents, Intervals] = {}
    for a, x in one.items():
        for b, y in other.items():
            if sum(a) + sum(b) <= order:
                key = tuple(map(int.__add__, a, b))
                term = x * y
                found[key] = found[key] + term if key in found else term
    return found


def largest_sizes(terms: Iterable[Intervals]) -> Array:
    """Return bounds on |Σ c_α t^α| for |t| ≤ 1: the sum of the coefficients' largest values."""
    total = Intervals.exact(0.0)
    for term in terms:
        total = total + Intervals.exact(term.magnitude)
    return total.upper
