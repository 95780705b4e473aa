"""Monodromy and the trace test, on curves whose degree and components are known."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import CATALOGUE, loaded, mostly_slow

import pmjac_pin as pj
from pmjac_pin.studies.homotopy.curve import Curve, machine_plane, same_plane
from pmjac_pin.studies.homotopy.curve_kernel import curve_kernel
from pmjac_pin.studies.homotopy.machines import Line, Machines
from pmjac_pin.studies.homotopy.monodromy import STRAIGHT, PlaneSection
from pmjac_pin.studies.homotopy.paths import led


class PlaneCurve:
    """f(x, t) = 0 in the plane of two complex numbers, in place of a line of machines."""

    count = 1

    def __init__(self, degree, value, slopes):
        self._degree, self._value, self._slopes = degree, value, slopes

    def lanes(self):
        """No kernel knows it."""

    def evaluate(self, X, t):
        """h^d f(X/h, t) and its derivatives by X, h and t; d is the degree in x."""
        (X, h), d = X.T, self._degree
        x = X / h
        value, (by_x, by_t) = self._value(x, t), self._slopes(x, t)
        by_h = d * h ** (d - 1) * value - h ** (d - 1) * x * by_x
        slopes = np.stack([h ** (d - 1) * by_x, by_h, h**d * by_t], axis=1)
        return (h**d * value)[:, None], slopes[:, None, :]


CUBIC = PlaneCurve(
    3,
    lambda x, t: x**3 + t * t * x - 2 * t + 1,
    lambda x, t: (3 * x * x + t * t, 2 * t * x - 2),
)
# A circle and a parabola: (x² + t² − 4) (x − t²).
TWO = PlaneCurve(
    3,
    lambda x, t: (x * x + t * t - 4) * (x - t * t),
    lambda x, t: (
        2 * x * (x - t * t) + x * x + t * t - 4,
        2 * t * (x - t * t) - 2 * t * (x * x + t * t - 4),
    ),
)


def section_of(line, points, rng):
    curve = Curve(line)
    section = PlaneSection.through(curve, points[0], rng)
    for other in points[1:]:
        start = PlaneSection.through(curve, other, rng)
        moved, arrived = curve.walk(other[None], start.planes(), section.planes(count=1))
        section = section.with_points(moved[arrived])
    return section


def grown(section, rng, rounds):
    for _ in range(rounds):
        section = section.grown(rng)
    return section


def test_all_points_of_an_irreducible_cubic(rng):
    root = np.roots([1.0, 0.0, 0.0, 1.0])[0]  # at t = 0
    section = grown(section_of(CUBIC, [np.array([root, 0.0])], rng), rng, 8)
    assert len(section.points) == 3
    assert section.components().max() == 0
    assert max(section.bends(section.components())) < STRAIGHT
    on_plane = section.points @ section.plane[:-1] - section.plane[-1]
    assert np.abs(on_plane).max() <= 1e-9


@pytest.mark.slow
def test_components_do_not_mix_and_each_has_a_straight_trace(rng):
    circle, parabola = np.array([2.0, 0.0], complex), np.array([0.0, 0.0], complex)
    section = grown(section_of(TWO, [circle, parabola], rng), rng, 8)
    labels = section.components()
    assert np.bincount(labels).tolist() == [2, 2]
    assert max(section.bends(labels)) < STRAIGHT
    on_circle = np.abs((section.points**2).sum(axis=1) - 4) < 1e-9
    assert len(set(labels[on_circle])) == len(set(labels[~on_circle])) == 1


@pytest.mark.slow
def test_the_trace_of_a_part_is_bent(rng):
    """Whatever is left out, or taken from another component, shows."""
    circle, parabola = np.array([2.0, 0.0], complex), np.array([0.0, 0.0], complex)
    section = grown(section_of(TWO, [circle, parabola], rng), rng, 8)
    labels = section.components()
    for missing in range(4):
        part = np.delete(np.arange(4), missing)
        some = PlaneSection(section.curve, section.plane, section.points[part], section.links[:0])
        assert some.bends(np.zeros(3, dtype=int))[0] > 1e-3
    mixed = np.where(np.arange(4) == np.flatnonzero(labels == 0)[0], 1, 0)
    assert max(section.bends(mixed)) > 1e-3


def test_the_trace_of_the_four_bars_curve_knows_a_missing_point(rng):
    machines = Machines(loaded("four_bar"))
    loops = machines.loops
    x = loops.somewhere(rng)
    start = machines.offset(machines.home.near(rng), x)
    curve = Curve(Line.through(loops, start, rng))
    section = grown(PlaneSection.through(curve, np.append(x, 0.0), rng), rng, 8)
    assert len(section.points) == 4
    assert section.bends(np.zeros(4, dtype=int))[0] < STRAIGHT
    fewer = PlaneSection(curve, section.plane, section.points[1:], section.links[:0])
    assert fewer.bends(np.zeros(3, dtype=int))[0] > 1e-3


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_walking_there_and_back_the_same_way_changes_nothing(rng, share):
    root = np.roots([1.0, 0.0, share**2, 1.0 - 2 * share])
    points = np.column_stack([root, np.full(3, share)]).astype(complex)
    curve = Curve(CUBIC)
    here = machine_plane(share, 1, 3)
    there = same_plane(np.array([0.4 + 0.2j, 1.0, 0.7j]), 3)
    moved, arrived = curve.walk(points, here, there)
    assert arrived.all()
    assert np.abs((there[:, :-1] * moved).sum(axis=1) - there[:, -1]).max() <= 1e-9
    back, arrived = curve.walk(moved, there, here)
    assert arrived.all()
    np.testing.assert_allclose(back, points, atol=1e-8)


def test_a_path_to_infinity_is_told_and_one_far_away_arrives():
    """(t + d) x = 1, led to t = 0: x = 1/d; beyond 1e4 is infinity."""
    for d, far in ((0.0, None), (1e-6, None), (2e-4, 5e3), (1e-3, 1e3)):
        line = PlaneCurve(1, lambda x, t, d=d: (t + d) * x - 1.0, lambda x, t, d=d: (t + d, x))
        ends = led(
            Curve(line),
            np.array([[1.0 / (1.0 + d), 1.0]], complex),
            machine_plane(1.0, 1, 1),
            machine_plane(0.0, 1, 1),
        )
        assert (ends.arrived[0], ends.to_infinity[0], ends.lost) == (bool(far), not far, 0)
        if far:
            np.testing.assert_allclose(ends.points[0, 0], far, rtol=1e-9)


def test_a_double_point_is_lost():
    """x² = t, led to t = 0."""
    line = PlaneCurve(2, lambda x, t: x * x - t, lambda x, t: (2 * x, 0 * t - 1.0))
    starts = np.array([[1.0, 1.0], [-1.0, 1.0]], complex)
    ends = led(Curve(line), starts, machine_plane(1.0, 1, 2), machine_plane(0.0, 1, 2))
    assert (ends.arrived.any(), ends.to_infinity.any(), ends.lost) == (False, False, 2)


def lines_of(name, rng):
    """A random line of a mechanism's machines, and points of its curve in a plane."""
    machines = Machines(loaded(name))
    x = machines.loops.somewhere(rng)
    start = machines.offset(machines.home.near(rng), x)
    line = Line(machines.loops, start, machines.offset(machines.home.near(rng), x))
    return line, np.append(x, 0.0)


@pytest.mark.skipif(curve_kernel() is None, reason="no kernel was built")
@pytest.mark.parametrize(
    "name", mostly_slow(CATALOGUE, ("four_bar", "bennett", "serial_2r", "three_rps_ss"))
)
def test_the_kernel_follows_as_numpy_does(name, rng):
    """More points than lanes, so that lanes take up others; none, one and few."""
    try:
        line, point = lines_of(name, rng)
    except pj.ArgumentError as refused:
        assert "no homotopy" in str(refused)
        return
    section = PlaneSection.through(Curve(line), point, rng)
    count = 70
    there = rng.normal(size=(2, count, point.size + 1))
    there = there[0] + 1j * there[1]
    for many in (count, 1, 0):
        here, ends = section.planes(count=many), there[np.arange(many)]
        points = np.tile(point, (many, 1))
        found, arrived = Curve(line).walk(points, here, ends)
        expected, all_arrived = Curve(WithoutKernel(line)).walk(points, here, ends)
        np.testing.assert_array_equal(arrived, all_arrived)
        assert arrived.mean() > 0.5 if many > 1 else arrived.shape == (many,)
        near = np.abs(expected).max(axis=1, initial=0.0) < 1e3
        size = 1.0 + np.abs(expected[arrived & near]).max(initial=0.0)
        np.testing.assert_allclose(
            found[arrived & near], expected[arrived & near], atol=1e-7 * size
        )


class WithoutKernel:
    """A line that no kernel knows."""

    def __init__(self, line):
        self.count, self.evaluate = line.count, line.evaluate

    def lanes(self):
        return None
