"""Programs over intervals: what the kernel makes of a tape holds the exact, as mpmath has it."""

from __future__ import annotations

from itertools import product

import mpmath
import numpy as np
import pytest
from test_intervals import (
    NASTY,
    check_ranges,
    holds,
    intervals_of_angles,
    members,
    nasty_angles,
    random_intervals,
)

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.tape import INSTRUCTIONS, Tape
from pmjac_pin.algebra.terms import Recording
from pmjac_pin.studies.modes.pruning_kernel import LoopsInLanes, pruning_kernel

pytestmark = pytest.mark.skipif(pruning_kernel() is None, reason="no kernel was built")

#: Each instruction of sums and products, alone or together, of x, y and z.
FORMULAS = {
    "+": lambda x, y, z: x + y,
    "-": lambda x, y, z: x - y,
    "*": lambda x, y, z: x * y,
    "neg": lambda x, y, z: -x,
    "muladd": lambda x, y, z: x * y + z,
    "mulsub": lambda x, y, z: x * y - z,
    "submul": lambda x, y, z: z - x * y,
    "square": lambda x, y, z: x * x,
    "square and more": lambda x, y, z: x * x + y,
    "less a square": lambda x, y, z: y - x * x,
    "a difference of itself": lambda x, y, z: (x * y + z) * (x * y + z) - x * y,
}


def over(formula, *boxes):
    """Return what the kernel makes of a formula over intervals (b,), shape (b,)."""
    recording = Recording(len(boxes))
    return enclosed(Tape.of(recording, [formula(*recording.inputs)]), *boxes)[0]


def enclosed(tape, *boxes):
    none = Intervals.exact(np.zeros(0))
    lanes = LoopsInLanes(pruning_kernel(), tape, tape, none, np.zeros(0))
    return lanes.enclose(Intervals.stack(boxes, 1))


@pytest.mark.parametrize("name", FORMULAS)
def test_results_hold_the_exact_ones(name, rng):
    formula, boxes = FORMULAS[name], [random_intervals(rng, 200) for _ in range(3)]
    result = over(formula, *boxes)
    for xs, ys, zs in product(*(members(rng, box) for box in boxes)):
        for k in range(200):
            assert holds(result, k, formula(*(mpmath.mpf(values[k]) for values in (xs, ys, zs))))


@pytest.mark.parametrize("name", FORMULAS)
def test_of_nasty_numbers_too(name, rng):
    formula = FORMULAS[name]
    xs, ys = np.array(list(product(NASTY, NASTY))).T
    zs = rng.choice(NASTY, len(xs))
    result = over(formula, *map(Intervals.exact, (xs, ys, zs)))
    for k, values in enumerate(zip(xs, ys, zs, strict=True)):
        assert holds(result, k, formula(*map(mpmath.mpf, values)))


@pytest.mark.parametrize("name", ["+", "-", "*", "muladd", "submul", "square"])
def test_they_are_as_narrow_as_numpys(name, rng):
    formula, boxes = FORMULAS[name], [random_intervals(rng, 500) for _ in range(3)]
    ours = over(formula, *boxes)
    squared = {"square": lambda x, y, z: x.square()}
    with np.errstate(over="ignore", invalid="ignore"):
        theirs = squared.get(name, formula)(*boxes)
    known = np.isfinite(theirs.width) & np.isfinite(ours.width)
    slack = 1e-15 * (ours.magnitude + theirs.magnitude) + 1e-280
    size = np.maximum(*(box.magnitude for box in boxes[:2])) if name in "+-" else theirs.magnitude
    assert known.mean() > 0.9
    assert (ours.width <= theirs.width + slack + 1e-15 * size)[known].all()


@pytest.mark.parametrize("name", ["cos", "sin"])
def test_sine_and_cosine_of_doubles(name, rng):
    angles = np.concatenate([nasty_angles(), rng.uniform(-10, 10, 3000), rng.normal(size=99) * 1e5])
    result = over(lambda x: x.recording.term(name, x), Intervals.exact(angles))
    exact = getattr(mpmath, name)
    for k, angle in enumerate(angles):
        assert holds(result, k, exact(mpmath.mpf(angle)))
        assert abs(angle) > 1e6 or result.width[k] < 1e-14


@pytest.mark.parametrize("name", ["cos", "sin"])
def test_sine_and_cosine_are_off_by_less_than_half_of_what_is_allowed(name, rng):
    """The bound is proven in the source; this is how far the worst of many are from it."""
    angles = np.concatenate([nasty_angles(), rng.uniform(-7, 7, 4000)])
    angles = angles[np.abs(angles) < 1e6]
    result = over(lambda x: x.recording.term(name, x), Intervals.exact(angles))
    inside = (result.lower > -1.0) & (result.upper < 1.0)
    exact = getattr(mpmath, name)
    off = [abs(result.middle[k] - exact(mpmath.mpf(angles[k]))) for k in np.flatnonzero(inside)]
    assert max(off) < 4.0 * 2.0**-53


@pytest.mark.parametrize("name", ["cos", "sin"])
def test_sine_and_cosine_of_intervals_are_their_ranges(name, rng):
    angles = intervals_of_angles(rng)
    check_ranges(name, angles, over(lambda x: x.recording.term(name, x), angles))


@pytest.mark.parametrize("name", ["cos", "sin"])
def test_far_angles_can_be_anything(name):
    angles = Intervals(np.array([1e9, -1e300, -2e6, 0.0]), np.array([1e9, -1e300, 0.0, 2e6]))
    result = over(lambda x: x.recording.term(name, x), angles)
    np.testing.assert_array_equal(result.lower, -1.0)
    np.testing.assert_array_equal(result.upper, 1.0)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e200, -1e200])
def test_what_overflows_bounds_nothing_that_comes_of_it(value):
    """0 · ∞ is no number, nor is what is the least of it and of others."""
    huge = Intervals(np.array([min(value, 0.0)]), np.array([max(value, 0.0)]))
    huge = Intervals.exact([value]) if np.isnan(value) else huge
    nothing, some = Intervals.exact([0.0]), Intervals(np.array([-1.0]), np.array([2.0]))
    for formula in (
        lambda x, y, z: (x * x) * x * y,
        lambda x, y, z: (x * x) * x * y + z,
        lambda x, y, z: z - (x * x) * x * y,
        lambda x, y, z: y * ((x * x) * x - x * x),
    ):
        result = over(formula, huge, nothing, some)
        assert not np.isfinite(result.lower).any()
        assert not np.isfinite(result.upper).any()
        assert result.meets(Intervals.exact([5.0])).all()


def test_nothing_bounds_what_has_no_end():
    """0 times [−∞, 0] may be 0, but where an end overflowed nothing else is looked at."""
    low, huge, nothing = Intervals(np.array([-1e200]), np.zeros(1)), [1e200], [0.0]
    result = over(lambda x, w, y: (x * w) * y, low, *map(Intervals.exact, (huge, nothing)))
    assert np.isnan(result.lower).all()


def test_one_box_that_overflows_spoils_no_other():
    boxes = Intervals.exact([1.0, 1e200, 2.0])
    result = over(lambda x: x * x, boxes)
    assert result.holds(np.array([1.0, 0.0, 4.0])).tolist() == [True, False, True]
    assert np.isnan(result.lower).tolist() == [False, True, False]


KNOWN = {"load", "store", "+", "-", "*", "neg", "sin", "cos", "muladd", "mulsub", "submul"}


@pytest.mark.parametrize("name", sorted(set(INSTRUCTIONS) - KNOWN))
def test_an_instruction_that_it_does_not_know_bounds_nothing(name):
    recording = Recording(2)
    two = name in {"/", "max", "copysign", "atan2"}
    term = recording.term(name, *recording.inputs[: 1 + two])
    result = enclosed(Tape.of(recording, [term]), Intervals.exact([1.0]), Intervals.exact([2.0]))
    assert np.isnan(result.lower).all()
    assert np.isnan(result.upper).all()
