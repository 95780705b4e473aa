"""Velocity and force ellipsoids against support functions and least squares on J itself."""

import copy
import math
import pickle

import numpy as np
import pytest

from pmjac_pin.errors import ArgumentError
from pmjac_pin.rates.ellipse import Ellipse
from pmjac_pin.rates.ellipsoid import Ellipsoid, force_ellipsoid, velocity_ellipsoid

# The lecture's [Jv]eq at pose B, from its formulas at the exact root.
POSE_B = [
    [-0.50850867, 0.11898438, 0.49019316],
    [0.18131145, -0.22681353, 0.35553312],
    [0.14473201, 0.61993528, 2.18347576],
]
RANKS = [(0, 0), (1, 1), (2, 2), (2, 1), (3, 3), (3, 2), (3, 1), (3, 0), (5, 3), (5, 2), (5, 1)]
NAMES = ("xy", "yx", "yz", "zy", "zx", "xz")
UNIT = {letter: np.eye(3)[i] for i, letter in enumerate("xyz")}
BUILD = (velocity_ellipsoid, force_ellipsoid)


@pytest.fixture
def rng():
    return np.random.default_rng(33)


def block(rng, n, rank):
    return rng.standard_normal((3, rank)) @ rng.standard_normal((rank, n))


def blocks(rng):
    """A block of each number of columns and rank."""
    for n, rank in RANKS:
        yield block(rng, n, rank)


def unit_columns(rng, n, count):
    columns = rng.standard_normal((n, count))
    return columns / np.linalg.norm(columns, axis=0)


def planes(rng, J):
    """Names, random normals, and planes that hold or stand across the range of J."""
    U = np.linalg.svd(J)[0]
    return [*NAMES, *rng.standard_normal((4, 3)), *U.T]


def normal_of(ellipse):
    return np.cross(*ellipse.basis.T)


def support(ellipse, y):
    """Largest y . p over the points p of an ellipse."""
    return np.linalg.norm(ellipse.radii * (y @ ellipse.axes))


# --- the ellipsoid itself ---------------------------------------------------------------------


@pytest.mark.parametrize("build", BUILD)
def test_radii_descend_and_axes_are_right_handed(rng, build):
    for J in blocks(rng):
        ellipsoid = build(J)
        assert (ellipsoid.radii[:-1] >= ellipsoid.radii[1:]).all()
        np.testing.assert_allclose(ellipsoid.axes.T @ ellipsoid.axes, np.eye(3), atol=1e-12)
        assert np.linalg.det(ellipsoid.axes) == pytest.approx(1)


def test_squared_radii_are_the_eigenvalues_of_equation_33(rng):
    for (_, rank), J in zip(RANKS, blocks(rng), strict=True):
        ellipsoid = velocity_ellipsoid(J)
        expected = np.sort(np.linalg.eigvalsh(J @ J.T))[::-1]
        np.testing.assert_allclose(ellipsoid.radii**2, expected, atol=1e-12)
        np.testing.assert_allclose(
            J @ J.T @ ellipsoid.axes, ellipsoid.axes * ellipsoid.radii**2, atol=1e-12
        )
        assert ellipsoid.rank == rank


def test_pose_b_of_the_lecture():
    ellipsoid = velocity_ellipsoid(POSE_B)
    np.testing.assert_allclose(ellipsoid.radii, [2.3429, 0.5645, 0.2980], atol=5e-5)
    assert repr(ellipsoid) == "Ellipsoid(radii=[2.343 0.5645 0.298] m/s, rank=3)"


def test_images_of_unit_rates_lie_in_the_ellipsoid(rng):
    for (n, rank), J in zip(RANKS, blocks(rng), strict=True):
        ellipsoid = velocity_ellipsoid(J)
        coordinates = ellipsoid.axes.T @ J @ unit_columns(rng, n, 500)
        spanned, beyond = coordinates[:rank], coordinates[rank:]
        assert (np.linalg.norm(spanned / ellipsoid.radii[:rank, None], axis=0) <= 1 + 1e-9).all()
        np.testing.assert_allclose(beyond, 0, atol=1e-12)
        if rank == n > 0:
            size = np.linalg.norm(spanned / ellipsoid.radii[:rank, None], axis=0)
            np.testing.assert_allclose(size, 1)


def test_surface_points_are_images_of_rates_within_one(rng):
    for (_, rank), J in zip(RANKS, blocks(rng), strict=True):
        points = velocity_ellipsoid(J).points(25, 13)
        assert points.shape == (25, 13, 3)
        np.testing.assert_array_equal(points[-1], points[0])
        targets = points.reshape(-1, 3).T
        rates = np.linalg.pinv(J, rcond=1e-9) @ targets
        np.testing.assert_allclose(J @ rates, targets, atol=1e-12)
        length = np.linalg.norm(rates, axis=0)
        assert (length <= 1 + 1e-9).all()
        if rank == 3:
            np.testing.assert_allclose(length, 1)


def test_surface_points_surround_the_ellipsoid():
    points = velocity_ellipsoid(np.diag([3.0, 2.0, 1.0])).points(n_u=41, n_v=21).reshape(-1, 3)
    np.testing.assert_allclose(points.max(axis=0), [3, 2, 1])
    np.testing.assert_allclose(points.min(axis=0), [-3, -2, -1])


def test_axes_do_not_depend_on_how_the_rates_are_measured(rng):
    J = block(rng, 3, 3)
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    expected = velocity_ellipsoid(J).axes
    for same in (-J, J @ turn, J[:, ::-1]):
        np.testing.assert_allclose(velocity_ellipsoid(same).axes, expected, atol=1e-12)


def test_equal_components_leave_the_sign_to_the_first():
    # Rounding decides which of the two is larger, and must not decide the sign.
    for nudge in (-1e-15, 1e-15):
        axis = velocity_ellipsoid([[-1.0], [1.0 + nudge], [0.0]]).axes[:, 0]
        np.testing.assert_allclose(axis, [math.sqrt(0.5), -math.sqrt(0.5), 0])


TIED = [(1, 1, 1), (2, 1, 1), (2, 2, 1), (1, 0, 0), (1, 1, 0), (0, 0, 0)]
SYMMETRIC = [(0, 0, 1), (1, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, -1), (0, 1, 1), (1, 1, 1)]


def single_direction(radii, axes):
    """The axis of the radius that is not equal to another."""
    return axes[:, 0] if radii[1] == radii[2] else axes[:, 2]


@pytest.mark.parametrize("radii", TIED)
@pytest.mark.parametrize("build", BUILD)
def test_axes_of_equal_radii_are_no_accident_of_rounding(rng, radii, build):
    """However the same ellipsoid is made, turned in the span of equal radii by the way."""
    for direction in [*SYMMETRIC, *rng.standard_normal((5, 3))]:
        turn = np.linalg.qr(np.column_stack([direction, np.eye(3)]))[0][:, :3]
        U = turn if radii[1] == radii[2] else turn[:, ::-1]
        first = None
        for _ in range(10):
            V = np.linalg.qr(rng.standard_normal((3, 3)))[0]
            J = (U * np.array(radii)) @ V + 1e-14 * rng.standard_normal((3, 3)) * max(radii)
            axes = build(J, rounding=1e-12).axes
            first = axes if first is None else first
            np.testing.assert_allclose(axes, first, atol=1e-11)


@pytest.mark.parametrize("radii", TIED[:5])
def test_axes_of_equal_radii_are_the_nearest_to_the_worlds(rng, radii):
    ball = radii[0] == radii[1] == radii[2]
    for direction in [*SYMMETRIC, *rng.standard_normal((20, 3))]:
        U = np.linalg.qr(np.column_stack([direction, np.eye(3)]))[0][:, :3]
        U = U if radii[1] == radii[2] else U[:, ::-1]
        axes = velocity_ellipsoid(U * np.array(radii)).axes
        if ball:
            np.testing.assert_array_equal(axes, np.eye(3))
            continue
        normal = single_direction(radii, axes)
        plane = axes[:, :2] if radii[0] == radii[1] else axes[:, 1:]
        pairs = [np.eye(3)[:, pair] for pair in ([0, 1], [0, 2], [1, 2])]
        angle = np.linspace(0, 2 * math.pi, 721)
        turns = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        mirrors = (np.eye(2), np.diag([1, -1]))
        best = max(
            np.einsum("ij,jka,kl,il->a", plane, turns, mirror, pair).max()
            for pair in pairs
            for mirror in mirrors
        )
        got = max(np.sum(plane * sign * pair) for pair in pairs for sign in ([1, 1], [1, -1]))
        assert got >= best - 1e-9
        np.testing.assert_allclose(np.abs(normal @ plane), 0, atol=1e-12)


def test_circles_have_the_axes_of_their_plane(rng):
    for J in blocks(rng):
        ball = velocity_ellipsoid(np.linalg.qr(rng.standard_normal((3, 3)))[0] * 2.0)
        for plane in planes(rng, J):
            np.testing.assert_array_equal(ball.section(plane).axes, np.eye(2))
            np.testing.assert_array_equal(ball.projection(plane).axes, np.eye(2))


def test_rank_is_relative(rng):
    for scale in (1e-200, 1.0, 1e200):
        assert velocity_ellipsoid(scale * np.diag([1, 1e-8, 1e-10])).rank == 2
        assert force_ellipsoid(scale * np.diag([1, 1e-8, 1e-10])).radii[0] == math.inf
    assert velocity_ellipsoid(np.zeros((3, 2))).rank == 0
    assert force_ellipsoid(np.zeros((3, 2))).rank == 3
    assert force_ellipsoid(np.diag([1, 1e-8, 1e-10])).rank == 3


def test_radii_up_to_a_known_rounding_are_zero(rng):
    J = block(rng, 4, 2) + 1e-7 * rng.standard_normal((3, 4))
    whole = velocity_ellipsoid(J)
    assert whole.rank == 3
    for rank, rounding in enumerate((*(1.0001 * whole.radii), 0.0)):
        velocity, force = (
            build(J, rounding=rounding) for build in (velocity_ellipsoid, force_ellipsoid)
        )
        assert velocity.rank == rank
        np.testing.assert_array_equal(velocity.radii[:rank], whole.radii[:rank])
        assert np.isinf(force.radii).tolist() == [True] * (3 - rank) + [False] * rank


@pytest.mark.parametrize("build", BUILD)
def test_radii_that_overflow_are_refused(build):
    J = 1.5e308 * np.array([[1.0, 1.0], [1.0, 1.0], [0.0, 0.0]])
    wanted = "the Jacobian block's radii must be finite; its largest entry is 1.5e+308"
    assert refusal(build, J) == wanted
    assert velocity_ellipsoid(1e-8 * J).rank == 1


@pytest.mark.parametrize("build", BUILD)
def test_what_is_built_keeps_the_rules_of_what_is_given(rng, build):
    for J in blocks(rng):
        made = build(J, "unit", 0.0, "motors")
        given = Ellipsoid(made.radii, made.axes, made.unit, made.motor_unit)
        for name in ("radii", "axes"):
            with pytest.raises(ValueError, match="WRITEABLE"):
                getattr(made, name).setflags(write=True)
            np.testing.assert_array_equal(getattr(made, name), getattr(given, name))
        assert repr(made) == repr(given)
    assert refusal(build, np.eye(3), unit=1) == 'unit must be a string, such as "m/s"; got 1'
    assert refusal(build, np.eye(3), motor_unit=1) == "motor_unit must be a string; got 1"


@pytest.mark.parametrize("rounding", [-1.0, math.nan, "much"])
@pytest.mark.parametrize("build", BUILD)
def test_what_is_no_rounding_is_refused(build, rounding):
    message = refusal(build, np.eye(3)[:, :2], rounding=rounding)
    assert message == f"rounding must be a number ≥ 0, got {rounding!r}"


def test_the_shadow_of_a_needle_along_itself_is_a_point(rng):
    for direction in rng.standard_normal((20, 3)):
        needle = velocity_ellipsoid(direction[:, None])
        assert needle.projection(direction).radii.tolist() == [0.0, 0.0]


def test_volume_and_area():
    ball = velocity_ellipsoid(2 * np.eye(3))
    assert ball.volume == pytest.approx(4 / 3 * math.pi * 8)
    assert ball.section("xy").area == pytest.approx(4 * math.pi)
    assert force_ellipsoid(np.eye(3)[:, :2]).volume == math.inf


# --- sections and projections -----------------------------------------------------------------


def test_projection_has_the_support_of_the_ellipsoid(rng):
    """The support of {J u} in direction d is |J^T d|, and a shadow keeps it in its plane."""
    for J in blocks(rng):
        for plane in planes(rng, J):
            shadow = velocity_ellipsoid(J).projection(plane)
            for y in unit_columns(rng, 2, 20).T:
                expected = np.linalg.norm(J.T @ shadow.basis @ y)
                assert support(shadow, y) == pytest.approx(expected, abs=1e-9)


def test_section_has_the_least_support_across_its_plane(rng):
    """The support of a section is the least of |J^T (d + s n)| over s: a parabola in s."""
    for J in blocks(rng):
        for plane in planes(rng, J):
            section = velocity_ellipsoid(J).section(plane)
            across = J.T @ normal_of(section)
            # Rounding leaves a crumb of a normal that stands on the range of J.
            across = across * (np.linalg.norm(across) > 1e-12)
            for y in unit_columns(rng, 2, 20).T:
                along = J.T @ section.basis @ y
                s = -(along @ across) / max(across @ across, 1e-300)
                expected = np.linalg.norm(along + s * across)
                assert support(section, y) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("n", [3, 5])
def test_section_against_dense_sampling(rng, n):
    J = block(rng, n, 3)
    for plane in planes(rng, J):
        section = velocity_ellipsoid(J).section(plane)
        angle = np.linspace(0, 2 * math.pi, 2000)
        ray = np.stack([np.cos(angle), np.sin(angle)])
        # The least rates for a unit velocity: the ray leaves the ellipsoid at 1 over their norm.
        reach = 1 / np.linalg.norm(np.linalg.pinv(J) @ section.basis @ ray, axis=0)
        assert reach.max() == pytest.approx(section.radii[0], rel=1e-4)
        assert reach.min() == pytest.approx(section.radii[1], rel=1e-4)
        rates = np.linalg.pinv(J) @ section.basis @ section.points(50).T
        np.testing.assert_allclose(np.linalg.norm(rates, axis=0), 1)


@pytest.mark.parametrize("method", ["section", "projection"])
@pytest.mark.parametrize("build", BUILD)
def test_figures_are_well_formed(rng, build, method):
    for J in blocks(rng):
        for plane in planes(rng, J):
            figure = getattr(build(J), method)(plane)
            assert figure.radii[0] >= figure.radii[1] >= 0
            np.testing.assert_allclose(figure.axes.T @ figure.axes, np.eye(2), atol=1e-12)
            assert np.linalg.det(figure.axes) == pytest.approx(1)
            assert figure.axes[np.abs(figure.axes[:, 0]).argmax(), 0] > 0
            np.testing.assert_allclose(figure.basis.T @ figure.basis, np.eye(2), atol=1e-12)
            if not isinstance(plane, str):
                np.testing.assert_allclose(
                    normal_of(figure) * np.linalg.norm(plane), plane, atol=1e-12
                )


@pytest.mark.parametrize("method", ["section", "projection"])
@pytest.mark.parametrize(("name", "normal"), [("yz", "x"), ("zx", "y"), ("xy", "z")])
def test_named_planes_are_those_of_their_normals(rng, name, normal, method):
    for J in blocks(rng):
        ellipsoid = velocity_ellipsoid(J)
        named, other = (getattr(ellipsoid, method)(plane) for plane in (name, 7 * UNIT[normal]))
        np.testing.assert_array_equal(named.basis, np.column_stack([UNIT[a] for a in name]))
        np.testing.assert_allclose(named.basis, other.basis)
        np.testing.assert_allclose(named.points(), other.points(), atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("method", ["section", "projection"])
def test_letters_give_the_order_of_the_coordinates(rng, method, name):
    cut = getattr(velocity_ellipsoid(block(rng, 3, 3)), method)
    one, other, upper = cut(name), cut(name[::-1]), cut(name.upper())
    np.testing.assert_array_equal(one.basis[:, 0], UNIT[name[0]])
    np.testing.assert_allclose(one.radii, other.radii)
    np.testing.assert_allclose(np.abs(one.axes), np.abs(other.axes[::-1]), atol=1e-12)
    np.testing.assert_array_equal(one.axes, upper.axes)


def test_normals_of_any_length_give_the_same(rng):
    ellipsoid = velocity_ellipsoid(block(rng, 3, 3))
    normal = rng.standard_normal(3)
    for scale in (1e-300, 1e300):
        figure = ellipsoid.section(scale * normal)
        np.testing.assert_allclose(figure.points(), ellipsoid.section(normal).points(), atol=1e-12)


def test_outline_is_closed_and_counter_clockwise(rng):
    figure = velocity_ellipsoid(block(rng, 3, 3)).projection("xy")
    outline = figure.points(count=101)
    assert outline.shape == (101, 2)
    np.testing.assert_array_equal(outline[0], outline[-1])
    np.testing.assert_allclose(outline[0], figure.radii[0] * figure.axes[:, 0])
    x, y = outline.T
    assert (x[:-1] * y[1:] - x[1:] * y[:-1]).sum() / 2 == pytest.approx(figure.area, rel=1e-2)


# --- forces -----------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [3, 4, 6])
def test_force_ellipsoid_has_reciprocal_radii_on_the_same_axes(rng, n):
    J = block(rng, n, 3)
    velocity, force = velocity_ellipsoid(J), force_ellipsoid(J)
    np.testing.assert_allclose(force.radii, 1 / velocity.radii[::-1])
    np.testing.assert_allclose(np.abs(force.axes.T @ velocity.axes), np.eye(3)[::-1], atol=1e-9)
    efforts = J.T @ force.points().reshape(-1, 3).T
    np.testing.assert_allclose(np.linalg.norm(efforts, axis=0), 1)


def test_no_force_within_one_gives_more_power_than_one(rng):
    for (n, rank), J in zip(RANKS, blocks(rng), strict=True):
        force = force_ellipsoid(J)
        finite = force.radii < math.inf
        assert np.sum(finite) == rank
        np.testing.assert_allclose(J.T @ force.axes[:, ~finite], 0, atol=1e-12)
        rates, ball = unit_columns(rng, n, 200), unit_columns(rng, 3, 200)[finite]
        forces = force.axes[:, finite] @ (force.radii[finite, None] * ball)
        assert (forces.T @ J @ rates <= 1 + 1e-9).all()


def test_section_of_forces_meets_unit_effort(rng):
    for J in blocks(rng):
        for plane in planes(rng, J):
            section = force_ellipsoid(J).section(plane)
            for radius, axis in zip(section.radii, (section.basis @ section.axes).T, strict=True):
                effort = np.linalg.norm(J.T @ axis)
                assert effort == pytest.approx(1 / radius, rel=1e-6, abs=1e-9)


def test_projection_of_forces_is_the_polar_of_the_section_of_velocities(rng):
    """The shadow reaches to |t| along J t, the least rates that give an in-plane velocity."""
    for J in blocks(rng):
        for plane in planes(rng, J):
            shadow = force_ellipsoid(J).projection(plane)
            for radius, axis in zip(shadow.radii, (shadow.basis @ shadow.axes).T, strict=True):
                rates = np.linalg.pinv(J, rcond=1e-9) @ axis
                if radius < math.inf:
                    np.testing.assert_allclose(J @ rates, axis, atol=1e-7)
                    assert np.linalg.norm(rates) == pytest.approx(radius, rel=1e-6)
                else:
                    assert np.linalg.norm(J @ rates - axis) > 1e-6


def test_unbounded_figures_have_no_points():
    force = force_ellipsoid([[1.0], [0.0], [0.0]])
    message = r"^an unbounded figure has no outline; its radii \[inf inf 1\] must all be finite$"
    with pytest.raises(ArgumentError, match=message):
        force.points()
    with pytest.raises(ArgumentError, match=r"its radii \[inf 1\] must all be finite"):
        force.section("xy").points()


# --- values -----------------------------------------------------------------------------------


@pytest.mark.parametrize("clone", [lambda x: pickle.loads(pickle.dumps(x)), copy.deepcopy])
def test_copies_are_equal_and_read_only(rng, clone):
    for J in blocks(rng):
        ellipsoid = force_ellipsoid(J)
        figure = ellipsoid.section("zy")
        for value, names in ((ellipsoid, ("radii", "axes")), (figure, ("radii", "axes", "basis"))):
            twin = clone(value)
            assert type(twin) is type(value)
            assert repr(twin) == repr(value)
            assert twin.unit == value.unit == "N"
            for name in names:
                np.testing.assert_array_equal(getattr(twin, name), getattr(value, name))
                for array in (getattr(value, name), getattr(twin, name)):
                    with pytest.raises(ValueError, match="read-only"):
                        array[0] = 0


def test_the_arrays_given_are_copied_and_fields_are_frozen():
    J, radii = np.eye(3), np.array([3.0, 2.0, 1.0])
    made, given = velocity_ellipsoid(J), Ellipsoid(radii, np.eye(3), "N")
    J[:], radii[:] = 0, 0
    np.testing.assert_array_equal(made.radii, [1, 1, 1])
    np.testing.assert_array_equal(given.radii, [3, 2, 1])
    with pytest.raises(AttributeError):
        made.unit = "N"


def test_reprs_are_short():
    force = force_ellipsoid([[4.0], [0.0], [0.0]], unit="N m")
    assert repr(force) == "Ellipsoid(radii=[inf inf 0.25] N m, rank=3)"
    assert repr(force.section("xy")) == "Ellipse(radii=[inf 0.25] N m)"
    assert repr(velocity_ellipsoid(np.eye(3), unit="")) == "Ellipsoid(radii=[1 1 1], rank=3)"


# --- bad input --------------------------------------------------------------------------------

WANTED_BLOCK = "the Jacobian block must be a finite 3 × n array, linear or angular rows alone; got "
WANTED_PLANE = 'plane must be two different letters of "xyz", such as "xy", or a normal; got '
WANTED_AXES = "axes must be orthonormal columns with determinant +1; got "
NAN = np.full((3, 2), np.nan)


def refusal(call, *arguments, **keywords):
    with pytest.raises(ArgumentError) as caught:
        call(*arguments, **keywords)
    return str(caught.value)


@pytest.mark.parametrize(
    ("jacobian", "message"),
    [
        (np.zeros((6, 3)), WANTED_BLOCK + "shape (6, 3)"),
        (np.zeros(3), WANTED_BLOCK + "shape (3,)"),
        (1.0, WANTED_BLOCK + "shape ()"),
        (NAN, WANTED_BLOCK + "shape (3, 2) with NaN or infinite entries"),
        ([[np.inf], [0], [0]], WANTED_BLOCK + "shape (3, 1) with NaN or infinite entries"),
        (np.eye(3) * 1j, "the Jacobian block must hold real numbers; got complex128 values"),
        (None, "the Jacobian block must hold real numbers; got object values"),
        (np.eye(3) > 0, "the Jacobian block must hold real numbers; got bool values"),
        ([[1], [2, 3]], "the Jacobian block must be an array of numbers; got [[1], [2, 3]]"),
    ],
)
def test_bad_jacobians_are_refused(jacobian, message):
    for build in BUILD:
        assert refusal(build, jacobian) == message


@pytest.mark.parametrize(
    ("plane", "message"),
    [
        ("xx", WANTED_PLANE + "'xx'"),
        ("xw", WANTED_PLANE + "'xw'"),
        ("x", WANTED_PLANE + "'x'"),
        ("xyz", WANTED_PLANE + "'xyz'"),
        ("", WANTED_PLANE + "''"),
        ([0, 0, 0], "the plane's normal must be finite and not zero; got [0. 0. 0.]"),
        ([0, np.nan, 1], "the plane's normal must be finite and not zero; got [ 0. nan  1.]"),
        ([0, np.inf, 1], "the plane's normal must be finite and not zero; got [ 0. inf  1.]"),
        ([0, 1], "the plane's normal must have shape (3,); got shape (2,)"),
        (2, "the plane's normal must have shape (3,); got shape ()"),
        ([0, 1j, 0], "the plane's normal must hold real numbers; got complex128 values"),
    ],
)
def test_bad_planes_are_refused(plane, message):
    for build in BUILD:
        ellipsoid = build(np.eye(3)[:, :2])
        for ask in (ellipsoid.section, ellipsoid.projection):
            assert refusal(ask, plane) == message


@pytest.mark.parametrize(
    ("radii", "axes", "unit", "message"),
    [
        ([1, 2, 3], np.eye(3), "N", "radii must be descending and not negative; got [1. 2. 3.]"),
        (
            [1, 0, -1],
            np.eye(3),
            "N",
            "radii must be descending and not negative; got [ 1.  0. -1.]",
        ),
        (
            [1, np.nan, 0],
            np.eye(3),
            "N",
            "radii must be descending and not negative; got [ 1. nan  0.]",
        ),
        (
            [np.inf, 1, 0],
            np.eye(3),
            "N",
            "radii must not be both infinite and zero; got [inf  1.  0.]",
        ),
        ([1, 1], np.eye(3), "N", "radii must have shape (3,); got shape (2,)"),
        ([1, 1, 1], np.eye(2), "N", "axes must have shape (3, 3); got shape (2, 2)"),
        ([1, 1, 1], -np.eye(3), "N", WANTED_AXES + f"{(-np.eye(3)).tolist()}"),
        ([1, 1, 1], 1e200 * np.eye(3), "N", WANTED_AXES + f"{(1e200 * np.eye(3)).tolist()}"),
        ([1, 1, 1], np.full((3, 3), np.nan), "N", WANTED_AXES + str([[math.nan] * 3] * 3)),
        ([1, 1, 1], np.eye(3), None, 'unit must be a string, such as "m/s"; got None'),
    ],
)
def test_bad_ellipsoids_are_refused(radii, axes, unit, message):
    assert refusal(Ellipsoid, radii, axes, unit) == message


def test_bad_ellipses_are_refused():
    assert refusal(Ellipse, [1, 1, 1], np.eye(2), np.eye(3)[:, :2], "N") == (
        "radii must have shape (2,); got shape (3,)"
    )


@pytest.mark.parametrize("count", [3, 0, -5, 10.0, "10", None])
def test_bad_counts_are_refused(count):
    ellipsoid = velocity_ellipsoid(np.eye(3))
    message = f"must be a whole number of at least 4 and at most 5000; got {count!r}"
    assert refusal(ellipsoid.points, n_u=count) == f"n_u {message}"
    assert refusal(ellipsoid.points, n_v=count) == f"n_v {message}"
    assert refusal(ellipsoid.section("xy").points, count) == f"count {message}"
