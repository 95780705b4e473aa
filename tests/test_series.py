"""Series: coefficients hold the exact ones, and the whole polynomial what it stands for."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.series import Series, SeriesAlgebra, largest_sizes

mpmath.mp.dps = 40
ORDER = 4


def functions(algebra):
    """Functions of two numbers, over series and over mpmath's numbers."""
    return {
        "product": (lambda x, y: (x * y - y) * x, lambda x, y: (x * y - y) * x),
        "cosine": (lambda x, y: algebra.cos(x * y), lambda x, y: mpmath.cos(x * y)),
        "sine": (lambda x, y: algebra.sin(x + y), lambda x, y: mpmath.sin(x + y)),
        "both": (
            lambda x, y: algebra.cos(x) * algebra.sin(y * y),
            lambda x, y: mpmath.cos(x) * mpmath.sin(y * y),
        ),
        "unit": (
            lambda x, y: algebra.unit(algebra.stack([x, y]))[0],
            lambda x, y: x / mpmath.sqrt(x * x + y * y),
        ),
        "square": (
            lambda x, y: algebra.squared(algebra.stack([x, y])),
            lambda x, y: x * x + y * y,
        ),
        "cross": (
            lambda x, y: algebra.cross(algebra.stack([x, y, x]), algebra.stack([y, x, y]))[1],
            lambda x, y: x * y - x * y,
        ),
    }


def variables(algebra, at, half, wide):
    """x = at + half t, at a point or all over |t| ≤ 1."""
    ends = (at - half, at + half) if wide else (at, at)
    return [
        algebra.variable(
            k, Intervals(*(np.array([[e[k]]]) for e in ends)), Intervals.exact([[half[k]]])
        )
        for k in range(2)
    ]


@pytest.mark.parametrize("name", functions(None))
def test_coefficients_hold_the_exact_ones(name, rng):
    algebra = SeriesAlgebra(2, ORDER)
    ours, exact = functions(algebra)[name]
    for _ in range(5):
        at, half = rng.uniform(0.5, 1.5, 2), rng.uniform(0.01, 0.2, 2)
        found = ours(*variables(algebra, at, half, wide=False))
        for exponents in [(i, j) for i in range(ORDER + 1) for j in range(ORDER + 1 - i)]:
            factorials = mpmath.factorial(exponents[0]) * mpmath.factorial(exponents[1])
            derivative = mpmath.diff(exact, tuple(map(mpmath.mpf, at)), exponents)
            size = mpmath.mpf(half[0]) ** exponents[0] * mpmath.mpf(half[1]) ** exponents[1]
            expected = derivative * size / factorials
            term = found.terms.get(exponents, Intervals.exact([[0.0]]))
            # mpmath's derivatives are differences: right to some 1e-8 in the fourth.
            assert term.lower[0, 0] - 1e-7 < expected < term.upper[0, 0] + 1e-7
            assert term.width[0, 0] < 1e-12


@pytest.mark.parametrize("name", functions(None))
def test_the_remainder_holds_all_over_a_cube(name, rng):
    """Coefficients below the order at the middle, of the order all over: f is within their sum."""
    algebra = SeriesAlgebra(2, ORDER)
    ours, exact = functions(algebra)[name]
    for _ in range(5):
        at, half = rng.uniform(0.5, 1.5, 2), rng.uniform(0.01, 0.3, 2)
        point, whole = (ours(*variables(algebra, at, half, wide)) for wide in (False, True))
        terms = {
            key: (whole if sum(key) == ORDER else point).terms[key]
            for key in {**point.terms, **whole.terms}
            if key in (whole if sum(key) == ORDER else point).terms
        }
        value = Intervals.exact([[0.0]])
        assert largest_sizes(terms.values())[0, 0] >= 0.0
        for t in rng.uniform(-1.0, 1.0, (20, 2)):
            value = Intervals.exact([[0.0]])
            for (i, j), term in terms.items():
                value = value + term * Intervals.exact([[t[0] ** i * t[1] ** j]])
            expected = exact(
                *(
                    mpmath.mpf(a) + mpmath.mpf(h) * mpmath.mpf(s)
                    for a, h, s in zip(at, half, t, strict=True)
                )
            )
            assert value.lower[0, 0] - 1e-13 <= expected <= value.upper[0, 0] + 1e-13


def test_what_is_beyond_the_order_is_dropped():
    algebra = SeriesAlgebra(1, 2)
    x = algebra.variable(0, Intervals.exact([[0.0]]), Intervals.exact([[1.0]]))
    cube = x * x * x
    assert isinstance(cube, Series)
    assert all(sum(key) <= 2 for key in cube.terms)
    assert all(abs(term.middle[0, 0]) == 0.0 for term in cube.terms.values())


def test_roots_hold_the_exact_ones(rng):
    for x in (*rng.uniform(0, 10, 50), 0.0, 1e-300, 2.0):
        found = Intervals.exact(x).sqrt()
        assert found.lower <= mpmath.sqrt(mpmath.mpf(float(x))) <= found.upper
