"""Expanded polynomials: values and derivatives against a hand-written one, and as enclosures."""

from __future__ import annotations

import numpy as np
from flint import Ordering, acb, arb, fmpq, fmpq_mpoly_ctx

from pmjac_pin.studies.homotopy.polynomial_table import PolynomialTable

CONTEXT = fmpq_mpoly_ctx.get(["x", "y", "z"], Ordering.lex)
X, Y, Z = CONTEXT.gens()
POLYNOMIALS = [
    fmpq(1, 3) * X**3 * Y - 2 * Z + 5,
    Y * Y * Z - X,
    CONTEXT.constant(fmpq(7, 2)),
    CONTEXT.constant(0),
]


def by_hand(x, y, z):
    none = 0 * x
    values = [x**3 * y / 3 - 2 * z + 5, y * y * z - x, none + 3.5, none]
    slopes = [
        [x * x * y, x**3 / 3, none - 2],
        [none - 1, 2 * y * z, y * y],
        [none] * 3,
        [none] * 3,
    ]
    return np.array(values), np.array(slopes)


def test_values_and_derivatives(rng):
    points = rng.normal(size=(7, 3)) + 1j * rng.normal(size=(7, 3))
    values, slopes = PolynomialTable(POLYNOMIALS, 3).evaluate(points)
    for point, value, slope in zip(points, values, slopes, strict=True):
        expected, rates = by_hand(*point)
        np.testing.assert_allclose(value, expected, rtol=1e-13, atol=1e-13)
        np.testing.assert_allclose(slope, rates, rtol=1e-13, atol=1e-13)


def test_balls_enclose_the_values_of_all_points_in_them(rng):
    table = PolynomialTable(POLYNOMIALS, 3)
    middle = rng.normal(size=3) + 1j * rng.normal(size=3)
    radius = 1e-3
    point = np.array([acb(arb(z.real, radius), arb(z.imag, radius)) for z in middle], dtype=object)
    values, slopes = table.values_in_balls(point), table.slopes_in_balls(point)
    for _ in range(50):
        shift = rng.uniform(-radius, radius, 3) + 1j * rng.uniform(-radius, radius, 3)
        expected, rates = by_hand(*(middle + shift))
        for ball, number in zip(
            [*values, *slopes.ravel()], [*expected, *rates.ravel()], strict=True
        ):
            slack = acb(arb(0, 1e-12), arb(0, 1e-12))  # the points are rounded
            assert (ball + slack).contains(acb(number.real, number.imag))
        assert max(float(ball.real.rad()) for ball in values) < 0.1


def test_one_third_is_one_third():
    """The coefficients of enclosures are exact: not the nearest double."""
    [value] = PolynomialTable([fmpq(1, 3) * X], 3).values_in_balls(
        np.array([acb(3), acb(0), acb(0)], dtype=object)
    )
    assert value.contains(1)
    assert float(value.real.rad()) < 1e-14
