"""Krawczyk's test, of balls and of boxes, against equations whose solutions are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pmjac_pin.algebra.balls import exactly
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.studies.krawczyk import RADII, image_of_boxes, radii

FINITE = RADII[:-1]


def parabola(point, constant):
    """x² + constant = 0 about a point: the derivative is 2x."""
    middle = np.full((len(FINITE), 1, 1), 2.0 * point)
    jacobian = Intervals.exact(middle).widened(2.0 * FINITE[:, None, None])
    residual = exactly([point**2]) + exactly([constant])
    return radii(residual, jacobian, np.array([0]), np.eye(1), FINITE)


def linear(residual, matrix, groups, columns=None):
    jacobian = Intervals.exact(np.tile(np.array(matrix), (len(RADII), 1, 1)))
    columns = np.arange(len(residual)) if columns is None else np.array(columns)
    return radii(exactly(residual), jacobian, columns, np.array(groups, dtype=float))


@pytest.mark.parametrize("point", [1.0001, 1.1, 1.2])
def test_a_parabola_has_its_nearer_root_within_and_its_farther_one_beyond(point):
    found = parabola(point, -1.0)
    assert not found.failed
    assert point - 1.0 <= found.existence <= 2.0 * (point - 1.0)
    assert point < found.uniqueness < point + 1.0


@pytest.mark.parametrize("constant", [1e-9, 1e-3, 1.0])
def test_no_certificate_where_there_is_no_root(constant, rng):
    """x² + c has no real root, so no x may be certified."""
    for point in rng.normal(size=200) * math.sqrt(constant):
        found = parabola(point, constant)
        assert found.failed
        assert found.existence == math.inf
        assert found.uniqueness == 0.0


def test_what_is_certified_of_random_parabolas_is_true(rng):
    """(x − a)(x − b) from any point: the root within is one, and only one is that near."""
    proven = 0
    for _ in range(300):
        near, apart = rng.normal(), 10.0 ** rng.uniform(-6.0, 0.0)
        point = 0.5 * apart + rng.normal() * 10.0 ** rng.uniform(-6.0, 0.0) * near
        roots = np.array([-0.5, 0.5]) * apart
        found = parabola(point, -0.25 * apart**2)
        if not found.failed:
            away = np.sort(abs(roots - point))
            assert away[0] <= found.existence * (1 + 1e-9) + 1e-16
            assert found.uniqueness < away[1]
            proven += 1
    assert proven > 30


def test_what_is_proven_of_boxes_of_random_parabolas_is_true(rng):
    """(x − a)(x − b): the image holds the roots of its box, inside it there is one."""
    near, apart = rng.normal(size=500), 10.0 ** rng.uniform(-3.0, 0.0, 500)
    roots = np.stack([near, near + apart], axis=1)
    middle = near + 0.3 * apart * rng.normal(size=500)
    widths = apart * 10.0 ** rng.uniform(-2.0, 0.5, 500)
    boxes = Intervals.exact(middle[:, None]).widened(widths[:, None])
    at = boxes.middle
    one, other = (Intervals.exact(root)[:, None] for root in roots.T)
    residual = (Intervals.exact(at) - one) * (Intervals.exact(at) - other)
    jacobian = ((boxes - one) + (boxes - other))[..., None]
    inverse = 1.0 / jacobian.middle
    image = image_of_boxes(inverse, residual, jacobian, at, boxes)
    within = boxes.holds(roots)
    assert image.holds(roots)[within].all()
    proven = image.inside(boxes)[:, 0]
    assert (within.sum(axis=1)[proven] == 1).all()
    assert 20 < proven.sum() < 480
    outside = image_of_boxes(inverse, residual, jacobian, at + 10.0, boxes)
    assert not outside.inside(boxes).any()


def test_a_linear_system_has_one_solution():
    found = linear([0.3, -0.4], np.eye(2), [[1, 1]])
    assert found.existence == pytest.approx(0.5, rel=1e-9)
    assert found.existence >= 0.5
    assert found.uniqueness == math.inf


def test_an_unknown_that_is_held_counts_only_where_a_ball_bends():
    """x + 1000 y = 0.1 with y held: one solution, but not proven so in a large ball of both."""
    found = linear([0.1], [[1.0, 1000.0]], [[1, 1]], columns=[0])
    assert found.failed
    assert linear([1e-4], [[1.0, 1000.0]], [[1, 1]], columns=[0]).existence < 2e-4


def test_an_exact_solution():
    found = parabola(1.0, -1.0)
    assert found.existence < 1e-300
    assert 1.4 < found.uniqueness < 2.0


def test_the_failing_inequality_is_named():
    assert "determinant is zero" in linear([0.0], [[0.0]], [[1]]).failed
    bent = parabola(0.1, -1.0)
    assert bent.failed.startswith("Y + M r < r does not hold for any r: Newton's step is Y = 4.95")
    wide = Intervals.exact(np.tile(np.eye(2), (len(RADII), 1, 1))).widened(2.0)
    found = radii(exactly([0.0, 0.0]), wide, np.arange(2), np.eye(2))
    assert found.failed.startswith("‖I − A K*‖ < 1 does not hold: it may be up to 4")


def test_where_nothing_is_known_nothing_is_proven():
    for bad in (np.nan, np.inf):
        ends = np.tile(np.eye(2), (len(RADII), 1, 1))
        ends[1:, 0, 1] = bad
        with np.errstate(invalid="ignore", over="ignore"):
            found = radii(exactly([0.0, 0.0]), Intervals(ends, ends), np.arange(2), np.eye(2))
        assert found.failed
