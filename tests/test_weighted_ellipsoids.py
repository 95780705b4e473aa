"""Ellipsoids of rates and efforts in shares of each motor's limit, and what is told of units."""

from __future__ import annotations

import pickle
from functools import cache

import numpy as np
import pytest
from transformed import rebuilt, scaled

import pmjac_pin as pj
from pmjac_pin.words.tables import report_blocks

#: Motors that slide and motors that turn, in one machine, or of one kind.
MACHINES = {
    "mixed": (("three_rps", ("l1", "l2", "theta3")), "m/s and rad/s", "N and N m"),
    "sliding": (("stewart_gough", None), "m/s", "N"),
    "turning": (("delta", None), "rad/s", "N m"),
}


@cache
def machine(kind):
    name, motors = MACHINES[kind][0]
    whole = pj.load(name) if motors is None else pj.load(name, actuated=list(motors))
    step = 0.02 * whole.characteristic_length * whole.problem.partition.motor_scale
    return whole.close(whole.home.actuated + step, enforce_limits=False)


def sizes(kind, rng):
    return rng.uniform(0.2, 5.0, machine(kind).actuated.size)


@pytest.mark.parametrize("kind", MACHINES)
def test_rates_in_shares_of_limits_are_those_that_a_ball_of_shares_makes(kind, rng):
    """Against |u| ≤ 1 itself: its farthest in any direction; and the polytope of |uᵢ| ≤ 1."""
    jacobian, limits = machine(kind).jacobian(), sizes(kind, rng)
    found = jacobian.velocity_ellipsoid(limits)
    ways = rng.normal(size=(50, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    farthest = [np.linalg.norm(limits * (jacobian.Jv_eq.T @ way)) for way in ways]
    drawn = np.linalg.norm(found.radii[:, None] * (found.axes.T @ ways.T), axis=0)
    np.testing.assert_allclose(drawn, farthest, rtol=1e-9)
    rows = [
        row
        for row, speed in zip(("vx", "vy", "vz"), jacobian.Jv_eq, strict=True)
        if np.abs(speed).max() > 1e-9
    ]
    if found.rank == len(rows) == 3:
        box = jacobian.velocity_polytope(limits, rows)
        ball = rng.normal(size=(50, 3))
        ball /= np.linalg.norm(ball, axis=1)[:, None]
        for point in (found.axes * found.radii @ ball.T).T:
            assert box.contains(point * (1.0 - 1e-9))


@pytest.mark.parametrize("kind", MACHINES)
def test_angular_rates_are_counted_alike(kind, rng):
    jacobian, limits = machine(kind).jacobian(), sizes(kind, rng)
    values = np.linalg.svd(jacobian.Jw_eq @ np.diag(limits), compute_uv=False)
    found = jacobian.angular_ellipsoid(limits).radii
    np.testing.assert_allclose(found[: values.size], values, atol=1e-9 * max(1.0, values[0]))


@pytest.mark.parametrize("kind", MACHINES)
def test_forces_in_shares_of_limits_are_held_by_efforts_of_length_1(kind, rng):
    """Each principal force is balanced by statics, at motor efforts τ with |τ/limit| = 1."""
    configuration, limits = machine(kind), sizes(kind, rng)
    found = configuration.jacobian().force_ellipsoid(limits)
    bounded = np.isfinite(found.radii)
    assert bounded.any()
    for radius, way in zip(found.radii[bounded], found.axes.T[bounded], strict=True):
        force = np.append(radius * way, np.zeros(3))
        efforts = configuration.statics(force, gravity=False).efforts
        assert np.linalg.norm(efforts / limits) == pytest.approx(1.0, abs=1e-9)


def test_a_unit_of_length_does_not_matter_to_shares(rng):
    """In millimetres, motors that slide have other numbers, and the tool's speeds with them."""
    home, limits = machine("mixed").mechanism.home, np.array([0.3, 0.2, 1.5])
    other = scaled(machine("mixed").mechanism, 1000.0).home
    of_slides = np.array([1000.0, 1000.0, 1.0])
    one = home.jacobian().velocity_ellipsoid(limits)
    both = other.jacobian().velocity_ellipsoid(limits * of_slides)
    np.testing.assert_allclose(both.radii, 1000.0 * one.radii, rtol=1e-9, atol=1e-9)
    angular = [
        home.jacobian().angular_ellipsoid(limits).radii,
        other.jacobian().angular_ellipsoid(limits * of_slides).radii,
    ]
    np.testing.assert_allclose(*angular, rtol=1e-9, atol=1e-9)
    plain = [home.jacobian().angular_ellipsoid().radii, other.jacobian().angular_ellipsoid().radii]
    assert not np.allclose(*plain, rtol=1e-2)  # without limits it does


@pytest.mark.parametrize("kind", MACHINES)
def test_every_ellipsoid_says_in_what_motors_are_counted(kind):
    _, rates, efforts = MACHINES[kind]
    jacobian = machine(kind).jacobian()
    assert jacobian.velocity_ellipsoid().motor_unit == rates
    assert jacobian.angular_ellipsoid().motor_unit == rates
    assert jacobian.force_ellipsoid().motor_unit == efforts
    assert repr(jacobian.velocity_ellipsoid()).endswith(f", motors in {rates})")
    limits = np.ones(jacobian.partition.actuated.size)
    for of in (jacobian.velocity_ellipsoid, jacobian.angular_ellipsoid, jacobian.force_ellipsoid):
        weighted = of(limits)
        assert weighted.motor_unit == "shares of their limits"
        assert pickle.loads(pickle.dumps(weighted)).motor_unit == weighted.motor_unit
        assert "motors in shares of their limits" in weighted._repr_html_()
        np.testing.assert_allclose(weighted.radii, of().radii)
    told = pj.report(machine(kind))
    assert told.told()["ellipsoids"]["force"]["motor_unit"] == efforts
    titles = [getattr(block, "title", "") for block in report_blocks(told)]
    for title in (
        f"Linear velocity of the tool, all motor rates together of length 1, motors in {rates}",
        f"Force at the tool that motor efforts of length 1 together can hold, motors in {efforts}",
    ):
        assert title in titles


def test_pictures_say_so():
    pytest.importorskip("matplotlib")
    from pmjac_pin.pictures.plotting import plot_ellipsoid

    jacobian = machine("mixed").jacobian()
    for ellipsoid, counted in (
        (jacobian.angular_ellipsoid(), "m/s and rad/s"),
        (jacobian.angular_ellipsoid([0.2, 0.2, 1.5]), "shares of their limits"),
    ):
        space = plot_ellipsoid(ellipsoid, title="").axes[0]
        wanted = f"Angular velocity of the tool, |motor rates| = 1 in {counted}"
        assert space.get_title().replace("\n", " ") == wanted
    figure = pj.plot(machine("sliding"), quantity="force")
    assert "|motor efforts| = 1 in N" in figure.subfigs[0]._suptitle.get_text()


@pytest.fixture
def stated():
    """The mixed 3-RPS: rates within 10 m/s or rad/s and efforts within 100 N or N m, one unlike."""
    mechanism = machine("mixed").mechanism
    model, (first, _, last) = mechanism.model, mechanism.problem.partition.actuated
    model.upperVelocityLimit[first] = model.lowerVelocityLimit[first] = 3.0
    model.upperEffortLimit[last], model.lowerEffortLimit[last] = 7.0, -7.0
    return mechanism, model


def test_limits_of_the_model(stated):
    jacobian = rebuilt(*stated).home.jacobian()
    for of, limits in (
        (jacobian.velocity_ellipsoid, [3.0, 10.0, 10.0]),
        (jacobian.angular_ellipsoid, [3.0, 10.0, 10.0]),
        (jacobian.force_ellipsoid, [100.0, 100.0, 7.0]),
    ):
        np.testing.assert_array_equal(of("model").radii, of(limits).radii)
    box = jacobian.velocity_polytope("model", ["vz"]).vertices
    np.testing.assert_array_equal(box, jacobian.velocity_polytope([3, 10, 10], ["vz"]).vertices)
    box = jacobian.force_polytope("model", ["vz"]).vertices
    np.testing.assert_array_equal(box, jacobian.force_polytope([100, 100, 7], ["vz"]).vertices)


@pytest.mark.parametrize("none", [0.0, np.inf, 1e16])
def test_a_limit_that_the_model_does_not_state_is_named(stated, none):
    mechanism, model = stated
    first, _, last = mechanism.problem.partition.actuated
    for column in (first, last):
        model.upperVelocityLimit[column] = model.lowerVelocityLimit[column] = none
    model.upperEffortLimit[last], model.lowerEffortLimit[last] = none, -none
    jacobian = rebuilt(mechanism, model).home.jacobian()
    with pytest.raises(pj.ArgumentError, match=r"states no rate limit of l1, theta3: give limits"):
        jacobian.velocity_ellipsoid("model")
    with pytest.raises(pj.ArgumentError, match=r"states no effort limit of theta3: give limits"):
        jacobian.force_ellipsoid("model")


def test_matrices_from_elsewhere_know_no_limits():
    split = machine("mixed").split_jacobian()
    known = pj.Partition.from_matrices(
        split.constraint_jacobian,
        split.tool_jacobian,
        split.partition.actuated.tolist(),
        split.partition.passive.tolist(),
    )
    bare = pj.SplitJacobian(split.constraint_jacobian, split.tool_jacobian, "LOCAL", known)
    jacobian = pj.equivalent_jacobian(bare)
    assert jacobian.velocity_ellipsoid().motor_unit == ""
    assert jacobian.velocity_ellipsoid([1.0, 2.0, 3.0]).motor_unit == "shares of their limits"
    with pytest.raises(pj.ArgumentError, match="states no rate limit of theta0, theta1, theta2"):
        jacobian.velocity_ellipsoid("model")


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ("limits", "motor limits are numbers or 'model', got 'limits'"),
        ([1.0, 2.0], r"motor limits: 3 numbers expected, got shape \(2,\)"),
        ([1.0, 2.0, 0.0], "motor limits are numbers above 0"),
        ([1.0, 2.0, np.nan], "finite"),
    ],
)
def test_limits_that_are_none(limits, message):
    jacobian = machine("mixed").jacobian()
    for of in (jacobian.velocity_ellipsoid, jacobian.angular_ellipsoid, jacobian.force_ellipsoid):
        with pytest.raises(pj.ArgumentError, match=message):
            of(limits)
