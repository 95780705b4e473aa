"""Interval arithmetic: every result holds the exact one, as mpmath computes it."""

from __future__ import annotations

from itertools import product

import mpmath
import numpy as np
import pytest

from pmjac_pin.algebra.intervals import Intervals, hull

mpmath.mp.dps = 60

# Around zero, subnormal, exact in binary or not, large; the ends of boxes and what rounds badly.
NASTY = (
    0.0,
    5e-324,
    -1e-310,
    2.2250738585072014e-308,
    1e-200,
    -1e-160,
    0.1,
    -1.0 / 3.0,
    1.0,
    -1.0 - 2.0**-52,
    1.0 - 2.0**-53,
    np.pi,
    -1e15,
    1e150,
)
OPERATIONS = {
    "+": (lambda x, y: x + y),
    "-": (lambda x, y: x - y),
    "*": (lambda x, y: x * y),
}


def random_doubles(rng, count):
    """Of all sizes and signs, one in ten of them nasty."""
    values = rng.normal(size=count) * 10.0 ** rng.uniform(-30, 30, count)
    return np.where(rng.random(count) < 0.1, rng.choice(NASTY, count), values)


def random_intervals(rng, count):
    one, other = random_doubles(rng, count), random_doubles(rng, count)
    narrow = rng.random(count) < 0.5
    other = np.where(narrow, one * (1.0 + rng.uniform(-1e-12, 1e-12, count)), other)
    return Intervals(np.minimum(one, other), np.maximum(one, other))


def members(rng, intervals):
    """The ends, and numbers between them."""
    share = rng.random(intervals.shape)
    between = intervals.lower + share * (intervals.upper - intervals.lower)
    between = np.clip(between, intervals.lower, intervals.upper)
    return np.array([intervals.lower, intervals.upper, between])


def holds(intervals, index, value):
    """An end that overflowed is not a number, and bounds nothing."""
    lower, upper = (mpmath.mpf(end[index]) for end in (intervals.lower, intervals.upper))
    return not (lower > value or upper < value)


@pytest.mark.parametrize("name", OPERATIONS)
def test_sums_and_products_hold_the_exact_ones(name, rng):
    operation = OPERATIONS[name]
    one, other = random_intervals(rng, 400), random_intervals(rng, 400)
    result = operation(one, other)
    for xs, ys in product(members(rng, one), members(rng, other)):
        for k in range(400):
            assert holds(result, k, operation(mpmath.mpf(xs[k]), mpmath.mpf(ys[k])))


@pytest.mark.parametrize("name", OPERATIONS)
def test_nasty_numbers_too(name):
    operation = OPERATIONS[name]
    xs, ys = np.array(list(product(NASTY, NASTY))).T
    result = operation(Intervals.exact(xs), Intervals.exact(ys))
    for k, (x, y) in enumerate(zip(xs, ys, strict=True)):
        assert holds(result, k, operation(mpmath.mpf(x), mpmath.mpf(y)))


def test_quotients_hold_the_exact_ones_and_are_everything_by_zero(rng):
    one, other = random_intervals(rng, 400), random_intervals(rng, 400)
    with np.errstate(over="ignore", invalid="ignore"):
        result = one / other
    for xs, ys in product(members(rng, one), members(rng, other)):
        for k in range(400):
            if other.lower[k] <= 0.0 <= other.upper[k]:
                assert (result.lower[k], result.upper[k]) == (-np.inf, np.inf)
            else:
                assert holds(result, k, mpmath.mpf(xs[k]) / mpmath.mpf(ys[k]))
    assert np.isfinite(result.lower).mean() > 0.3


def test_squares_hold_the_exact_ones_and_are_never_negative(rng):
    one = random_intervals(rng, 1000)
    result = one.square()
    assert (result.lower >= 0.0).all()
    for xs in members(rng, one):
        for k in range(1000):
            assert holds(result, k, mpmath.mpf(xs[k]) ** 2)


def nasty_angles():
    """Doubles next to multiples of a quarter turn, where reduction and extrema are hard."""
    quarters = np.concatenate([np.arange(-40, 41), [1e3, 12345, 355, 710, 100_003, 600_001]])
    nearest = quarters * (np.pi / 2)
    return np.concatenate(
        [nearest, np.nextafter(nearest, np.inf), np.nextafter(nearest, -np.inf), NASTY[:-2]]
    )


@pytest.mark.parametrize("name", ["cos", "sin"])
def test_sine_and_cosine_of_doubles(name, rng):
    angles = np.concatenate([nasty_angles(), rng.uniform(-10, 10, 4000), rng.normal(size=99) * 1e5])
    result = getattr(Intervals.exact(angles), name)()
    exact = getattr(mpmath, name)
    for k, angle in enumerate(angles):
        assert holds(result, k, exact(mpmath.mpf(angle)))
        assert abs(angle) > 1e6 or result.width[k] < 1e-14


def check_ranges(name, angles, result):
    """Against the ends and the extrema in between, found with 60 digits of π; and no wider."""
    exact, top = getattr(mpmath, name), 0 if name == "cos" else mpmath.mpf(1) / 4
    for k in range(len(angles.lower)):
        ends = [mpmath.mpf(angles.lower[k]), mpmath.mpf(angles.upper[k])]
        values = [exact(end) for end in ends]
        turns = [end / (2 * mpmath.pi) - top for end in ends]
        if mpmath.floor(turns[1]) >= mpmath.ceil(turns[0]):
            values.append(mpmath.mpf(1))
        if mpmath.floor(turns[1] - 0.5) >= mpmath.ceil(turns[0] - 0.5):
            values.append(mpmath.mpf(-1))
        assert holds(result, k, min(values))
        assert holds(result, k, max(values))
        assert result.upper[k] - float(max(values)) < 1e-14
        assert float(min(values)) - result.lower[k] < 1e-14


def intervals_of_angles(rng):
    """Wide and narrow ones, a third of them at multiples of a right angle and beside."""
    lower = np.concatenate([rng.uniform(-30, 30, 2000), rng.choice(nasty_angles(), 1000)])
    widths = np.concatenate([rng.uniform(0, 7, 1500), 10.0 ** rng.uniform(-17, 0, 1500)])
    return Intervals(lower, lower + widths)


@pytest.mark.parametrize("name", ["cos", "sin"])
def test_sine_and_cosine_of_intervals_are_their_ranges(name, rng):
    angles = intervals_of_angles(rng)
    check_ranges(name, angles, getattr(angles, name)())


def test_far_angles_can_be_anything():
    result = Intervals.exact([1e9, -1e300]).cos()
    np.testing.assert_array_equal(result.lower, -1.0)
    np.testing.assert_array_equal(result.upper, 1.0)


@pytest.mark.parametrize("terms", [1, 2, 7, 50])
def test_sums_of_many(terms, rng):
    one = random_intervals(rng, 40 * terms)
    one = Intervals(one.lower.reshape(40, terms), one.upper.reshape(40, terms))
    result = one.sum(axis=1)
    for xs in members(rng, one):
        for k in range(40):
            assert holds(result, k, mpmath.fsum(map(mpmath.mpf, xs[k])))


def test_matrix_products(rng):
    boxes, matrix = random_intervals(rng, 20 * 12), random_doubles(rng, 20 * 16)
    one = Intervals(boxes.lower.reshape(20, 4, 3), boxes.upper.reshape(20, 4, 3))
    matrices = matrix.reshape(20, 4, 4)
    result = one.after(matrices)
    for xs in members(rng, one):
        for k in range(20):
            exact = mpmath.matrix(matrices[k].tolist()) * mpmath.matrix(xs[k].tolist())
            for i, j in np.ndindex(result.shape[1:]):
                assert holds(result, (k, i, j), exact[i, j])


def test_middles_are_inside_and_widening_widens(rng):
    one = random_intervals(rng, 500)
    assert one.holds(one.middle).all()
    assert one.inside(one.widened(0.0)).all()
    assert one.inside(one.widened(1e-3)).all()


def test_meeting_intervals():
    one, other = Intervals.exact([1.0, 2.0]), Intervals(np.array([0.0, 3.0]), np.array([1.0, 4.0]))
    assert one.meets(other).tolist() == [True, False]
    common = one.meet(other)
    assert (common.lower <= common.upper).tolist() == [True, False]
    whole = hull(Intervals.stack([one, other], 0))
    assert (whole.lower.tolist(), whole.upper.tolist()) == ([0.0, 2.0], [1.0, 4.0])


def test_what_is_not_a_number_is_never_excluded():
    strange = Intervals.exact([np.nan])
    assert strange.meets(Intervals.exact([0.0])).all()
    assert not strange.inside(Intervals(np.array([-1.0]), np.array([1.0]))).any()
