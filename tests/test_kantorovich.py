"""The Newton–Kantorovich radii against equations whose solutions are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from pmjac_pin.algebra.balls import exactly
from pmjac_pin.studies.certificates.kantorovich import System, radii


def system(residual, jacobian, bends, groups=None):
    rows = len(residual)
    groups = [[k] for k in range(rows)] if groups is None else groups
    bends = [Polynomial(np.atleast_1d(bend)) for bend in bends]
    return System(exactly(residual), exactly(jacobian), groups, np.arange(rows), bends)


@pytest.mark.parametrize("point", [1.0001, 1.2, 1.5, 3.0])
def test_a_parabola_has_its_two_roots_as_radii(point):
    """x² = 1 from x > 1: the theorem is sharp, r = x − 1 and x + 1."""
    found = radii(system([point**2 - 1.0], [[2.0 * point]], [2.0]))
    assert not found.failed
    assert found.existence == pytest.approx(point - 1.0, rel=2e-6)
    assert found.existence >= point - 1.0
    assert found.uniqueness == pytest.approx(point + 1.0, rel=2e-6)
    assert found.uniqueness <= point + 1.0


@pytest.mark.parametrize("constant", [1e-9, 1e-3, 1.0])
def test_no_certificate_where_there_is_no_root(constant, rng):
    """x² + c has no real root, so no x may be certified."""
    for point in rng.normal(size=200) * math.sqrt(constant):
        found = radii(system([point**2 + constant], [[2.0 * point]], [2.0]))
        assert found.failed
        assert found.existence == math.inf
        assert found.uniqueness == 0.0


def test_a_linear_system_has_one_solution():
    found = radii(system([0.3, -0.4], np.eye(2), [0.0, 0.0], groups=[[0, 1]]))
    assert found.existence == pytest.approx(0.5, rel=2e-6)
    assert found.uniqueness == math.inf


def test_an_exact_solution():
    found = radii(system([0.0], [[2.0]], [2.0]))
    assert found.existence < 1e-300
    assert found.uniqueness == pytest.approx(2.0, rel=2e-6)


def test_the_failing_inequality_is_named():
    assert "determinant is zero" in radii(system([0.0], [[0.0]], [1.0])).failed
    bent = radii(system([1.0], [[1.0]], [3.0]))
    assert bent.failed.startswith("h = 2 Y Z₂ / (1 − Z₁)² < 1 does not hold: h = 6")
    assert bent.number == pytest.approx(6.0)
    wide = system([0.0, 0.0], np.eye(2), [0.0, 0.0])
    wide.jacobian[0, 1] += type(wide.jacobian[0, 1])(0, 2)
    assert radii(wide).failed.startswith("‖I − A K*‖ < 1 does not hold: it may be up to 2")


def test_curvature_that_grows_with_the_distance():
    """x³ = 1 from x: D² = 6x up to 6(x + r); both radii bound what is true."""
    found = radii(system([1.1**3 - 1.0], [[3 * 1.1**2]], [[6.6, 6.0]]))
    assert 0.1 <= found.existence < 0.15
    assert 0.3 < found.uniqueness < 1.1
