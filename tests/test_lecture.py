"""The library against the lecture: its printed figures, and its closed formulas at random poses."""

from __future__ import annotations

import hand_derived as hand
import mechanisms
import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj

PRINT = 5e-5  # rounding of four printed digits
EXACT = 1e-10


@pytest.fixture(scope="module")
def three_rps_ss():
    return loaded("three_rps_ss")


def test_pose_a_agrees_with_the_print(three_rps_ss):
    jacobian = three_rps_ss.pose("lecture_a").jacobian()
    np.testing.assert_allclose(jacobian.Jw, hand.POSE_A_JW, atol=PRINT)
    np.testing.assert_allclose(jacobian.Jw_star, hand.POSE_A_JW_STAR, atol=PRINT)
    np.testing.assert_allclose(jacobian.Jv_eq, hand.POSE_A_JV_EQ, atol=PRINT)
    np.testing.assert_allclose(jacobian.Jw_eq, hand.POSE_A_JW_EQ, atol=PRINT)


def test_the_misprinted_digit_is_not_ours(three_rps_ss):
    entry, printed = hand.POSE_A_JW_STAR_MISPRINT
    value = three_rps_ss.pose("lecture_a").jacobian().Jw_star[entry]
    assert abs(value - printed) > 10 * PRINT
    assert value == pytest.approx(0.6686, abs=PRINT)


@pytest.mark.parametrize("mode", hand.POSE_A_MODES)
def test_all_modes_of_pose_a_are_reached_from_their_angles(three_rps_ss, mode):
    guess = dict(zip(three_rps_ss.passive, np.round(mode, 3), strict=True))
    configuration = three_rps_ss.close(hand.POSE_A_L, guess=guess)
    np.testing.assert_allclose(configuration.passive, mode, atol=2e-8)


@pytest.mark.parametrize("name", ["three_rps", "three_rps_ss"])
def test_pose_b_by_direct_kinematics(name):
    mechanism = loaded(name)
    configuration = mechanism.close(hand.POSE_B_L, guess="lecture_b")
    np.testing.assert_allclose(configuration.passive[:3], hand.POSE_B_THETA, atol=PRINT)
    ellipsoid = configuration.jacobian().velocity_ellipsoid()
    np.testing.assert_allclose(ellipsoid.radii, [2.3429, 0.5645, 0.2980], atol=PRINT)
    assert np.abs(ellipsoid.radii - hand.POSE_B_PRINTED_VELOCITIES).min() > 0.09


@pytest.mark.slow
def test_three_rps_ss_against_the_closed_formulas_at_200_poses():
    for configuration in mechanisms.random_poses("three_rps_ss", 1, 210):
        lengths, theta = configuration.actuated, configuration.passive
        jacobian = configuration.jacobian()
        Jv_eq, Jw_eq = hand.rps_equivalent(lengths, theta, 0.5)
        scale = 1.0 + np.abs(Jw_eq).max()
        expected = {
            "K": hand.rps_K(lengths, theta),
            "K_star": hand.rps_K_star(lengths, theta),
            "Jv": hand.rps_Jv(lengths, theta),
            "Jv_star": hand.rps_Jv_star(lengths, theta),
            "Jw": hand.rps_Jw(lengths, theta),
            "Jw_star": hand.rps_Jw_star(lengths, theta),
        }
        for name, formula in expected.items():
            np.testing.assert_allclose(getattr(jacobian, name), formula, atol=EXACT, err_msg=name)
        np.testing.assert_allclose(jacobian.Jv_eq, Jv_eq, atol=EXACT * scale)
        np.testing.assert_allclose(jacobian.Jw_eq, Jw_eq, atol=EXACT * scale)
        np.testing.assert_allclose(
            configuration.residual, hand.rps_residual(lengths, theta, 0.5), atol=1e-12
        )


@pytest.mark.parametrize("lengths", [mechanisms.CRANK_ROCKER, (4.0, 3.0, 2.5, 2.0)])
def test_four_bar_against_the_closed_formulas_at_200_poses(lengths):
    mechanism = pj.load(
        "four_bar", parameters=dict(zip(("l0", "l1", "l2", "l3"), lengths, strict=True))
    )
    rng = np.random.default_rng(2)
    for configuration in mechanisms.random_closed(mechanism, rng, 200):
        theta1, phi = float(configuration.actuated[0]), configuration.passive
        jacobian = configuration.jacobian()
        expected = {
            name: getattr(hand, f"four_bar_{name}")(theta1, phi, lengths)
            for name in ("K", "K_star", "Jv", "Jv_star", "Jw", "Jw_star")
        }
        for name, formula in expected.items():
            np.testing.assert_allclose(getattr(jacobian, name), formula, atol=EXACT, err_msg=name)
        rates = np.linalg.solve(expected["K_star"], expected["K"])
        for block in ("Jv", "Jw"):
            by_hand = expected[block] - expected[f"{block}_star"] @ rates
            np.testing.assert_allclose(
                getattr(jacobian, f"{block}_eq"), by_hand, atol=EXACT * (1 + np.abs(by_hand).max())
            )


def test_four_bar_direct_kinematics_is_the_circle_intersection():
    mechanism = loaded("four_bar")
    configuration = mechanism.home
    branch = np.sign(configuration.jacobian().det_K_star)
    for theta1 in np.linspace(0.9, 2 * np.pi, 25):
        configuration = mechanism.close([theta1], guess=configuration)
        phi = hand.four_bar_closure(theta1, mechanisms.CRANK_ROCKER, branch)
        turns = (configuration.passive - phi) / (2 * np.pi)
        np.testing.assert_allclose(turns, np.round(turns), atol=1e-12)


@pytest.mark.parametrize("b", [0.8, 1.3])
def test_parameters_reach_the_kinematics(b):
    mechanism = pj.load("three_rps_ss", parameters={"a": 0.6, "b": b})
    configuration = mechanism.home
    lengths, theta = configuration.actuated, configuration.passive
    np.testing.assert_allclose(hand.rps_residual(lengths, theta, 0.6, b), 0.0, atol=1e-12)
    np.testing.assert_allclose(
        configuration.jacobian().K_star, hand.rps_K_star(lengths, theta, b), atol=EXACT
    )
