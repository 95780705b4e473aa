"""Paths of motors: whatever they are given as, polynomials that are the same path."""

import numpy as np
import pytest
from mechanisms import loaded
from scipy.interpolate import BSpline, CubicSpline, PchipInterpolator, PPoly, make_interp_spline

import pmjac_pin as pj
from pmjac_pin.studies.follow.given_path import motor_path
from pmjac_pin.studies.follow.motor_path import PathPiece

TIMES = np.array([0.0, 0.4, 1.0, 2.5])
VALUES = np.array([[0.9, 1.9], [1.1, 2.0], [1.3, 1.6], [0.8, 1.8]])


def five_bar():
    return loaded("five_bar")


def wave(t):
    return [0.9 + 0.3 * np.sin(2.0 * t), 1.9 + 0.3 * np.cos(t)]


def between(path, count=40):
    ends = np.random.default_rng(0).uniform(path.start, path.end, count)
    return [(t, path.piece_at(t)) for t in ends.tolist()]


@pytest.mark.parametrize(
    "spline",
    [
        CubicSpline(TIMES, VALUES),
        PchipInterpolator(TIMES, VALUES),
        make_interp_spline(TIMES, VALUES, k=3),
        make_interp_spline(TIMES, VALUES, k=2),
    ],
    ids=["cubic", "monotone", "b-spline", "quadratic b-spline"],
)
def test_splines_are_taken_as_they_are(spline):
    path = motor_path(five_bar(), spline)
    assert (path.start, path.end) == (0.0, 2.5)
    slope, bend = spline.derivative(), spline.derivative(2)
    for t, piece in between(path):
        assert piece.values(t) == pytest.approx(spline(t), abs=1e-13)
        assert piece.rates(t) == pytest.approx(slope(t), abs=1e-12)
        assert piece.accelerations(t) == pytest.approx(bend(t), abs=1e-11)


def test_a_part_of_a_spline():
    spline = CubicSpline(TIMES, VALUES)
    path = motor_path(five_bar(), spline, [0.2, 0.7])
    assert (path.start, path.end, len(path.pieces)) == (0.2, 0.7, 2)
    with pytest.raises(pj.ArgumentError, match="not within"):
        motor_path(five_bar(), spline, [0.2, 2.7])


def test_a_function_is_met_by_polynomials():
    path = motor_path(five_bar(), wave, (0.0, 3.0))
    for t, piece in between(path):
        rates = [0.6 * np.cos(2.0 * t), -0.3 * np.sin(t)]
        bends = [-1.2 * np.sin(2.0 * t), -0.3 * np.cos(t)]
        assert piece.values(t) == pytest.approx(wave(t), abs=1e-12)
        assert piece.rates(t) == pytest.approx(rates, abs=1e-9)
        assert piece.accelerations(t) == pytest.approx(bends, abs=1e-6)


@pytest.mark.parametrize("width", [1e-2, 1e-5, 1e-8])
def test_a_narrow_range_has_the_rates_of_its_function(width):
    """What is rounding of values is no acceleration: over the square of the range it would be."""
    path = motor_path(five_bar(), wave, (0.0, width, 2.0 * width, 1.0))
    for piece in path.pieces[:2]:
        assert piece.rates(piece.start) == pytest.approx([0.6, 0.0], abs=1e-14 / width + width)
        assert piece.accelerations(piece.start) == pytest.approx(
            [-1.2 * np.sin(2.0 * piece.start), -0.3 * np.cos(piece.start)],
            abs=min(1e-13 / width**2, 0.31),
        )


def test_a_kink_is_named_or_refused():
    def kinked(t):
        return [1.0 + 0.1 * abs(t - 1.0 / 3.0), 2.0]

    with pytest.raises(pj.ArgumentError, match=r"not smooth near t = 0\.3333"):
        motor_path(five_bar(), kinked, (0.0, 1.0))
    path = motor_path(five_bar(), kinked, (0.0, 1.0 / 3.0, 1.0))
    assert path.piece_at(0.5).rates(0.5) == pytest.approx([0.1, 0.0])
    assert path.piece_at(0.2).rates(0.2) == pytest.approx([-0.1, 0.0])


def breaks(path):
    """Where pieces begin and end."""
    return [piece.start for piece in path.pieces] + [path.end]


def test_waypoints_by_name_and_their_times():
    path = motor_path(five_bar(), {"theta2": VALUES[:, 1], "theta1": VALUES[:, 0]}, TIMES)
    assert breaks(path) == TIMES.tolist()
    for t, piece in between(path):
        straight = [np.interp(t, TIMES, column) for column in VALUES.T]
        assert piece.values(t) == pytest.approx(straight, abs=1e-14)
    assert breaks(motor_path(five_bar(), VALUES)) == [0.0, 1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ("path", "times", "said"),
    [
        ([[0.9, 1.9]], None, "two waypoints"),
        (VALUES, [0.0, 1.0], "4 waypoints and 2 times"),
        (VALUES, [0.0, 1.0, 1.0, 2.0], "ascend"),
        (VALUES[:3], [0.0, 1e-300, 1.0], "1e-09 apart or more, got 0.0 and 1e-300: leave one out"),
        (VALUES[:3], [0.0, 5e-324, 1.0], "apart or more"),
        (wave, [0.0, 1e-20, 1.0], "apart or more"),
        (VALUES[:3], [1e8, 1e8 + 1e-6, 1e8 + 1.0], "1e-05 apart or more"),
        (PPoly(np.ones((1, 2, 2)), [0.0, 1e-300, 1.0]), None, "apart or more"),
        (PPoly([[[1e308, 0.0]], [[0.9, 1.9]]], [0.0, 2.0]), None, r"must be 1e\+09 or less"),
        ([[0.9], [1.0]], None, r"shape \(N, 2\)"),
        (wave, None, "needs `times`"),
        (lambda t: [t], (0.0, 1.0), "is 2 values"),
        (lambda t: [t, "x"], (0.0, 1.0), "real numbers"),
        (CubicSpline(TIMES, VALUES[:, :1]), None, "2 values \\(theta1, theta2\\)"),
        (BSpline([0.0, 0.0, 1.0, 2.0, 2.0], np.eye(3)[:, :2], 1), (0.0, 3.0), "not within"),
    ],
)
def test_what_is_no_path_is_told(path, times, said):
    with pytest.raises(pj.ArgumentError, match=said):
        motor_path(five_bar(), path, times)


def test_a_jump_is_refused():
    spline = CubicSpline(TIMES, VALUES)
    spline.c = spline.c.copy()
    spline.c[-1, 1] += 1e-3
    with pytest.raises(pj.ArgumentError, match=r"jumps by 0\.001 at t = 0\.4"):
        motor_path(five_bar(), spline)


@pytest.mark.parametrize("degree", range(1, 8))
def test_how_far_a_piece_is_from_a_cubic_is_bounded(degree):
    rng = np.random.default_rng(degree)
    piece = PathPiece(-0.3, 1.2, 0.1, rng.standard_normal((degree + 1, 2)))
    start, end = -0.2, 0.9
    s = np.linspace(0.0, 1.0, 201)
    values = np.array([piece.values(start + x * (end - start)) for x in s])
    slopes = [(end - start) * piece.rates(t) for t in (start, end)]
    v = 1.0 - s
    basis = [(1.0 + 2.0 * s) * v * v, s * v * v, s * s * (3.0 - 2.0 * s), -s * s * v]
    cubic = np.column_stack(basis) @ [values[0], slopes[0], values[-1], slopes[1]]
    far, bound = np.abs(values - cubic).max(axis=0), piece.aside(start, end)
    if degree < 4:
        assert bound is None
        assert far.max() < 1e-13
    else:
        assert (far <= bound).all()
        assert (bound <= 10.0 * far).all()
