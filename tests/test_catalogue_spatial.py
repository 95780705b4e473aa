"""Spatial mechanisms of the catalogue: against formulas and published figures."""

from __future__ import annotations

from math import pi, tan

import hand_spatial as spatial
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.cli import main

EXACT = 1e-10


def pose_of(configuration):
    return configuration.tool_pose().translation, configuration.tool_pose().rotation


@pytest.mark.parametrize(
    ("name", "mobility", "by_count", "redundant"),
    [
        ("agile_eye", 3, -3, 6),
        ("ankle", 2, 2, 0),
        ("bennett", 1, -2, 3),
        ("bricard", 1, 0, 1),
        ("delta", 3, -9, 12),
        ("delta_rods", 3, 3, 0),
        ("head_6rss", 6, 6, 0),
        ("humanoid_ankle", 2, 2, 0),
        ("sarrus", 1, 0, 1),
        ("stewart_gough", 6, 6, 0),
        ("stewart_gough_dietmaier", 6, 6, 0),
    ],
)
def test_mobility_by_rank_beside_gruebler(name, mobility, by_count, redundant):
    """Freedoms of the cut tree less all rows are Grübler's count; redundant rows make up for it."""
    mechanism = loaded(name)
    assert mechanism.mobility == mobility
    assert mechanism.nv - len(mechanism.rows) == by_count
    jacobian = mechanism.home.jacobian()
    assert len(mechanism.rows) - len(jacobian.rows) == redundant
    assert jacobian.K_star.shape == (len(mechanism.passive),) * 2


# --- Delta ---------------------------------------------------------------------------------------

DELTA = {"base": 0.2, "arm": 0.3, "rod": 0.7, "plate": 0.06}
OTHER_DELTA = {"base": 0.3, "arm": 0.25, "rod": 0.6, "plate": 0.1}


@pytest.mark.parametrize("sizes", [DELTA, OTHER_DELTA], ids=["default", "other"])
def test_delta_is_its_closed_form_with_hinges_and_with_rods(sizes, rng):
    hinged, reduced = pj.load("delta", sizes), pj.load("delta_rods", sizes)
    geometry = [sizes[name] for name in ("base", "arm", "plate")]
    for configuration in mechanisms.random_closed(hinged, rng, 8, 0.5):
        theta = configuration.actuated
        twin = reduced.close(theta)
        t, R = pose_of(configuration)
        np.testing.assert_allclose(R, np.eye(3), atol=EXACT)
        centre = t + 0.065 * spatial.Z  # the tool is below the plate
        rods, _ = spatial.delta_rods(theta, centre, *geometry)
        np.testing.assert_allclose(np.linalg.norm(rods, axis=1), sizes["rod"], atol=EXACT)
        J_eq = configuration.jacobian().J_eq
        expected = np.vstack([spatial.delta_Jv(theta, centre, *geometry), np.zeros((3, 3))])
        np.testing.assert_allclose(J_eq, expected, atol=EXACT)
        np.testing.assert_allclose(twin.jacobian().J_eq, J_eq, atol=EXACT)
        same = (twin.tool_pose().homogeneous, configuration.tool_pose().homogeneous)
        np.testing.assert_allclose(*same, atol=EXACT)


def test_delta_parallelograms_stay_parallelograms(rng):
    for configuration in mechanisms.random_closed(loaded("delta"), rng, 5, 0.5):
        values = configuration.joint_values
        for leg in (1, 2, 3):
            assert values[f"sway{leg}a"] == pytest.approx(values[f"sway{leg}b"], abs=EXACT)
            assert values[f"level{leg}"] == pytest.approx(-values[f"sway{leg}a"], abs=EXACT)


# --- Stewart-Gough platform ----------------------------------------------------------------------


def coordinates(base, platform):
    """The 24 parameters of a platform: x of points 2, x and y of points 3, all of the others."""
    return {
        f"{letter}{k}{axis}": points[k - 1]["xyz".index(axis)]
        for letter, points in (("b", base), ("p", platform))
        for k, axes in ((2, "x"), (3, "xy"), (4, "xyz"), (5, "xyz"), (6, "xyz"))
        for axis in axes
    }


def points(parameters, letter):
    return [[parameters.get(f"{letter}{k}{axis}", 0.0) for axis in "xyz"] for k in range(1, 7)]


DIETMAIER = coordinates(spatial.DIETMAIER_BASE, spatial.DIETMAIER_PLATFORM)


def assert_textbook(configuration, parameters):
    base, platform = points(parameters, "b"), points(parameters, "p")
    lengths, inverse = spatial.stewart_inverse(*pose_of(configuration), base, platform)
    np.testing.assert_allclose(lengths, configuration.actuated, atol=EXACT)
    J_eq = configuration.jacobian().J_eq
    np.testing.assert_allclose(inverse @ J_eq, np.eye(6), atol=EXACT)
    np.testing.assert_allclose(J_eq @ inverse, np.eye(6), atol=EXACT)


def test_stewart_times_its_textbook_inverse_is_one(rng):
    mechanism = loaded("stewart_gough")
    assert len(mechanism.parameters) == 24
    for configuration in mechanisms.random_closed(mechanism, rng, 8, 0.05):
        assert_textbook(configuration, mechanism.parameters)


def test_stewart_of_any_geometry(rng):
    regular = loaded("stewart_gough").parameters
    for _ in range(3):
        shifted = {name: value + rng.uniform(-0.05, 0.05) for name, value in regular.items()}
        mechanism = pj.load("stewart_gough", shifted)
        assert mechanism.home.actuated == pytest.approx([0.6] * 6)
        assert_textbook(mechanism.home, shifted)


def test_dietmaiers_platform_closes_at_its_published_lengths(rng):
    mechanism = loaded("stewart_gough_dietmaier")
    assert mechanism.home.actuated.tolist() == list(spatial.DIETMAIER_LENGTHS)
    assert mechanism.home.residual_norm < 1e-12
    for configuration in (mechanism.home, *mechanisms.random_closed(mechanism, rng, 4, 0.03)):
        assert_textbook(configuration, DIETMAIER)


def test_dietmaiers_platform_is_the_general_one_with_his_coordinates():
    mechanism = loaded("stewart_gough_dietmaier")
    general = pj.load("stewart_gough", DIETMAIER)
    twin = general.configuration(mechanism.home.q)
    np.testing.assert_allclose(twin.jacobian().J_eq, mechanism.home.jacobian().J_eq, atol=EXACT)


# --- Agile Eye -----------------------------------------------------------------------------------


def test_agile_eye_is_its_closed_form(rng):
    mechanism = loaded("agile_eye")
    for configuration in mechanisms.random_closed(mechanism, rng, 8, 0.5):
        t, R = pose_of(configuration)
        np.testing.assert_allclose(t, 0.05 * R[:, 2], atol=EXACT)  # all turns about the origin
        closure, Jw = spatial.agile_eye(configuration.actuated, R)
        np.testing.assert_allclose(closure, 0.0, atol=EXACT)
        jacobian = configuration.jacobian()
        np.testing.assert_allclose(jacobian.Jw_eq, Jw, atol=EXACT)
        np.testing.assert_allclose(jacobian.Jv_eq, np.cross(Jw, t, axisa=0).T, atol=EXACT)


@pytest.mark.parametrize("front", [0.0, 0.05, 0.3])
def test_agile_eyes_tool_is_as_far_in_front_of_its_centre_as_the_parameter_says(front, rng):
    mechanism = pj.load("agile_eye", {"front": front})
    for configuration in mechanisms.random_closed(mechanism, rng, 4, 0.5):
        t, R = pose_of(configuration)
        np.testing.assert_allclose(t, front * R[:, 2], atol=1e-12)
        jacobian = configuration.jacobian()
        default = loaded("agile_eye").close(configuration.actuated).jacobian()
        np.testing.assert_allclose(jacobian.Jw_eq, default.Jw_eq, atol=EXACT)
        np.testing.assert_allclose(jacobian.Jv_eq, default.Jv_eq * front / 0.05, atol=EXACT)
        assert jacobian.velocity_ellipsoid().rank == (2 if front else 0)


def test_agile_eye_turns_alike_in_all_directions_at_home():
    Jw = loaded("agile_eye").home.jacobian().Jw_eq
    np.testing.assert_allclose(Jw @ Jw.T, np.eye(3), atol=EXACT)


# --- Bennett -------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [0.2, 0.5, 1.5])
@pytest.mark.parametrize("theta", [0.2, 0.8, 1.7, 2.9])
def test_bennett_half_angles_have_a_constant_product(theta, size):
    configuration = pj.load("bennett", {"a": size, "b": 2 * size}).close([theta])
    values = configuration.joint_values
    product = tan(theta / 2) * tan(values["theta2"] / 2)
    assert product == pytest.approx(spatial.bennett_product(), rel=1e-9)
    assert values["theta3"] == pytest.approx(-theta, abs=EXACT)
    rates = configuration.jacobian().passive_rates[:, 0]
    ratio = -np.sin(values["theta2"]) / np.sin(theta)
    assert rates == pytest.approx([ratio, -1.0], abs=EXACT)


def test_bennett_turns_fully():
    """Through the pose where all four bars lie in one line, and back to where it came from."""
    mechanism = loaded("bennett")
    start = mechanism.home.joint_values
    around = mechanism.close([start["theta1"] - 2 * pi], enforce_limits=False)
    np.testing.assert_allclose(
        around.tool_pose().homogeneous, mechanism.home.tool_pose().homogeneous, atol=EXACT
    )


@pytest.mark.parametrize("a", [0.4, 0.6])
def test_bennett_is_rigid_with_other_sides(a):
    """Nothing is left of its motion but the pose with all four bars in one line."""
    mechanism = pj.load("bennett", {"a": a})
    assert mechanism.mobility == 0
    with pytest.raises(pj.PmjacError, match="forbid"):
        mechanism.home.jacobian()


# --- Bricard -------------------------------------------------------------------------------------


@pytest.mark.parametrize("edge", [0.3, 1.0])
@pytest.mark.parametrize("theta", [-0.5, -0.2, 0.4, 1.0, 1.5, 2.4, 3.1, 3.6])
def test_bricard_is_threefold_symmetric(theta, edge):
    configuration = pj.load("bricard", {"edge": edge}).close([theta], enforce_limits=False)
    second, rate = spatial.bricard_second(theta)
    np.testing.assert_allclose(configuration.passive, [second, theta] * 2, atol=1e-9)
    rates = configuration.jacobian().passive_rates[:, 0]
    np.testing.assert_allclose(rates, [rate, 1.0] * 2, atol=1e-9 * (1 + abs(rate)))


def test_bricard_stops_at_thirty_degrees():
    """At sin θ₁ = −1/2 the others are at 90 degrees, where θ₁ turns back."""
    with pytest.raises(pj.ClosureError, match="meets a singularity") as caught:
        loaded("bricard").close([-0.6])
    assert caught.value.reached.actuated[0] == pytest.approx(-pi / 6, abs=1e-6)


# --- Sarrus --------------------------------------------------------------------------------------


@pytest.mark.parametrize(("panel", "half"), [(0.5, 0.3), (0.8, 0.2)])
@pytest.mark.parametrize("alpha", [0.2, 0.8, 1.5])
def test_sarrus_moves_straight_up(alpha, panel, half):
    configuration = pj.load("sarrus", {"l": panel, "d": half}).close([alpha])
    height, rate = spatial.sarrus_height(alpha, panel)
    t, R = pose_of(configuration)
    np.testing.assert_allclose(t, [0, 0, height + 0.02], atol=EXACT)  # tool 2 cm above the hinges
    np.testing.assert_allclose(R, np.eye(3), atol=EXACT)
    J_eq = configuration.jacobian().J_eq[:, 0]
    np.testing.assert_allclose(J_eq, [0, 0, rate, 0, 0, 0], atol=EXACT)


# --- Ankle ---------------------------------------------------------------------------------------

ANKLE = {"crank": 0.06, "heel": 0.06, "half": 0.05, "rod1": 0.24, "rod2": 0.16}
OTHER_ANKLE = {"crank": 0.04, "heel": 0.07, "half": 0.03, "rod1": 0.3, "rod2": 0.2}


@pytest.mark.parametrize("sizes", [ANKLE, OTHER_ANKLE], ids=["default", "other"])
def test_ankle_is_its_rod_rows(sizes, rng):
    mechanism = pj.load("ankle", sizes)
    crank, heel, half, *rods = sizes.values()
    for configuration in mechanisms.random_closed(mechanism, rng, 8, 0.2):
        t, R = pose_of(configuration)
        lengths, Jw = spatial.ankle(configuration.actuated, R, crank, heel, half, rods)
        np.testing.assert_allclose(lengths, rods, atol=EXACT)
        jacobian = configuration.jacobian()
        np.testing.assert_allclose(jacobian.Jw_eq, Jw, atol=EXACT)
        np.testing.assert_allclose(jacobian.Jv_eq, np.cross(Jw, t, axisa=0).T, atol=EXACT)


@pytest.mark.parametrize("angle", [-0.4, 0.3, 0.7])
def test_ankle_with_equal_cranks_and_heel_pitches_as_its_motors(angle):
    """Crank, rod, foot and shank are then two parallelograms side by side."""
    configuration = loaded("ankle").close([angle, angle])
    np.testing.assert_allclose(
        configuration.tool_pose().rotation, pin.rpy.rpyToMatrix(0.0, angle, 0.0), atol=EXACT
    )
    np.testing.assert_allclose(configuration.jacobian().Jw_eq.sum(axis=1), [0, 1, 0], atol=EXACT)


@pytest.mark.parametrize("name", ["three_rps", "three_rps_ss"])
def test_the_page_of_the_3_rps_opens_on_an_ellipsoid_that_is_no_needle(name, monkeypatch):
    """On home's assembly mode, where the needle is; other mechanisms open at home."""
    opened = []
    monkeypatch.setattr(
        "pmjac_pin.viewer.serving.serve_until_interrupted",
        lambda configuration, port, open_browser: opened.append(configuration),
    )
    assert [main(["view", machine]) for machine in (name, "four_bar")] == [0, 0]
    assert main(["view", name, "--from", "home"]) == 0
    assert main(["view", name, "--at", "1,1,1"]) == 0
    radii = opened[0].jacobian().velocity_ellipsoid().radii
    assert radii[2] > 0.2 * radii[0]
    mechanism = opened[0].mechanism
    np.testing.assert_allclose(
        mechanism.close([1.0, 1.0, 1.0], guess=opened[0]).q, mechanism.home.q, atol=1e-6
    )
    assert opened[1] is opened[1].mechanism.home
    for configuration in opened[2:]:
        np.testing.assert_allclose(configuration.q, mechanism.home.q, atol=1e-9)
