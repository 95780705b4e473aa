"""The hand-derived formulas against the lecture's print and against central differences."""
# ruff: noqa: E741 - l is the lecture's leg length

import hand_derived as hand
import numpy as np
import pytest
from numpy.testing import assert_allclose

PRINT = 5e-5  # rounding of four decimals
RPS_A_THETA = hand.rps_newton(hand.POSE_A_L, hand.POSE_A_THETA, hand.RPS_A)
STRETCHED, FOLDED_LONG, FOLDED_SHORT = (1.0, 0.9, 0.7, 0.6), (2.0, 1.5, 2.6, 1.0), (2, 1.5, 1, 2.6)
CRANK_ROCKER = (1.0, 0.3, 0.8, 0.7)


def spin(rotation, x):
    """Angular velocity Jacobian of x -> R(x), by central differences."""
    W = np.einsum("ijk,lj->ilk", hand.central_difference(rotation, x), rotation(np.asarray(x)))
    return np.array([W[2, 1], W[0, 2], W[1, 0]])


def close_to_difference(analytic, numeric):
    assert analytic.shape == numeric.shape
    assert_allclose(analytic, numeric, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("name", ["JW", "JW_STAR", "JV_EQ", "JW_EQ"])
def test_pose_a_agrees_with_the_print(name):
    l, theta = hand.POSE_A_L, RPS_A_THETA
    computed = dict(zip(["JV_EQ", "JW_EQ"], hand.rps_equivalent(l, theta, hand.RPS_A), strict=True))
    computed |= {"JW": hand.rps_Jw(l, theta), "JW_STAR": hand.rps_Jw_star(l, theta)}
    assert_allclose(computed[name], getattr(hand, f"POSE_A_{name}"), rtol=0, atol=PRINT)


def test_pose_a_exact_root_and_misprint():
    assert_allclose(RPS_A_THETA, hand.POSE_A_THETA_EXACT, rtol=0, atol=5e-9)
    assert_allclose(RPS_A_THETA, hand.POSE_A_THETA, rtol=0, atol=PRINT)
    entry, printed = hand.POSE_A_JW_STAR_MISPRINT
    assert abs(hand.rps_Jw_star(hand.POSE_A_L, RPS_A_THETA)[entry] - printed) > 9e-4


@pytest.mark.parametrize(
    ("l", "modes", "dets", "normal", "digits"),
    [
        (hand.POSE_A_L, hand.POSE_A_MODES, hand.POSE_A_DET_K_STAR, 1, 5e-9),
        (hand.POSE_B_L, hand.POSE_B_MODES, hand.POSE_B_DET_K_STAR, -1, PRINT),
        (hand.SYMMETRIC_L, [hand.SYMMETRIC_THETA], [hand.SYMMETRIC_DET_K_STAR], 1, 1e-14),
    ],
)
def test_assembly_modes(l, modes, dets, normal, digits):
    for mode, det in zip(modes, dets, strict=True):
        theta = hand.rps_newton(l, mode, hand.RPS_A)
        assert_allclose(theta, mode, rtol=0, atol=digits)
        assert_allclose(np.linalg.det(hand.rps_K_star(l, theta)), det, rtol=0, atol=PRINT)
        assert np.sign(hand.rps_rotation(l, theta)[2, 2]) == normal
        assert_allclose(hand.rps_residual(l, -theta, hand.RPS_A), 0, atol=1e-13)


def test_pose_b_velocities_follow_the_equations_not_the_print():
    for mode, expected in zip(hand.POSE_B_MODES, hand.POSE_B_VELOCITIES, strict=True):
        theta = hand.rps_newton(hand.POSE_B_L, mode, hand.RPS_A)
        for mirrored in (theta, -theta):
            Jv_eq, _ = hand.rps_equivalent(hand.POSE_B_L, mirrored, hand.RPS_A)
            velocities = np.linalg.svd(Jv_eq, compute_uv=False)
            assert_allclose(velocities, expected, rtol=0, atol=PRINT)
            assert velocities[0] > 4 * hand.POSE_B_PRINTED_VELOCITIES[0]


@pytest.mark.parametrize("b", [1.0, 1.3])
@pytest.mark.parametrize("seed", range(5))
def test_rps_jacobians_against_differences(seed, b):
    rng = np.random.default_rng(seed)
    l, theta, a = rng.uniform(0.4, 1.5, 3), rng.uniform(-1.2, 1.2, 3), rng.uniform(0.2, 0.9)
    S = hand.rps_points(l, theta, b)
    squares = np.sum((S - np.roll(S, -1, axis=0)) ** 2, axis=1) - 3 * a**2
    assert_allclose(hand.rps_residual(l, theta, a, b), squares, atol=1e-13)
    R = hand.rps_rotation(l, theta, b)
    assert_allclose(np.cross(R[:, 0], R[:, 1]), R[:, 2], atol=1e-13)
    by_l, by_theta = (lambda f: lambda x: f(x, theta)), (lambda f: lambda x: f(l, x))
    for by, x, star in ((by_l, l, ""), (by_theta, theta, "_star")):
        K, Jv, Jw = (getattr(hand, f"rps_{name}{star}") for name in ("K", "Jv", "Jw"))
        eta = by(lambda l, theta: hand.rps_residual(l, theta, a, b))
        centroid = by(lambda l, theta: hand.rps_points(l, theta, b).mean(axis=0))
        rotation = by(lambda l, theta: hand.rps_rotation(l, theta, b))
        close_to_difference(K(l, theta, b), hand.central_difference(eta, x))
        close_to_difference(Jv(l, theta), hand.central_difference(centroid, x))
        close_to_difference(Jw(l, theta, b), spin(rotation, x))


@pytest.mark.parametrize("mode", hand.POSE_A_MODES)
def test_rps_equivalent_is_the_derivative_through_the_closure(mode):
    def closed(f):
        return lambda l: f(l, hand.rps_newton(l, mode, hand.RPS_A))

    theta = hand.rps_newton(hand.POSE_A_L, mode, hand.RPS_A)
    Jv_eq, Jw_eq = hand.rps_equivalent(hand.POSE_A_L, theta, hand.RPS_A)
    centroid = closed(lambda l, theta: hand.rps_points(l, theta).mean(axis=0))
    close_to_difference(Jv_eq, hand.central_difference(centroid, hand.POSE_A_L))
    close_to_difference(Jw_eq, spin(closed(hand.rps_rotation), hand.POSE_A_L))


def test_refusals():
    with pytest.raises(ValueError, match="turns fully"):
        hand.four_bar_crank_limit(CRANK_ROCKER)
    with pytest.raises(ValueError, match="not closed"):
        hand.rps_equivalent(hand.POSE_A_L, RPS_A_THETA + 0.1, hand.RPS_A)
    with pytest.raises(RuntimeError, match="no closure"):
        hand.rps_newton((0.1, 0.1, 0.1), hand.SYMMETRIC_THETA, hand.RPS_A)


@pytest.mark.parametrize(("a", "b"), [(0.5, 1.0), (0.6, 1.3)])
def test_rps_singular_poses(a, b):
    poses = hand.rps_singular_poses(np.random.default_rng(3), 20, a, b)
    assert len({tuple(np.round(np.append(*pose), 4)) for pose in poses}) == 20
    for l, theta in poses:
        assert 0.1 <= l.min() <= l.max() <= 3
        assert np.abs(hand.rps_residual(l, theta, a, b)).max() < 1e-13
        assert np.linalg.svd(hand.rps_K_star(l, theta, b), compute_uv=False)[2] < 1e-12


@pytest.mark.parametrize("lengths", [STRETCHED, FOLDED_LONG, FOLDED_SHORT, CRANK_ROCKER])
@pytest.mark.parametrize("branch", [1, -1])
@pytest.mark.parametrize("theta1", [1.0, 1.3, -1.2])
def test_four_bar_against_differences(theta1, branch, lengths):
    phi = hand.four_bar_closure(theta1, lengths, branch)
    assert_allclose(hand.four_bar_residual(theta1, phi, lengths), 0, atol=1e-14)
    assert np.sign(np.linalg.det(hand.four_bar_K_star(theta1, phi, lengths))) == branch
    x = np.append(theta1, phi + 0.1)  # the formulas hold off closure too
    numeric = {
        "K": hand.central_difference(lambda x: hand.four_bar_residual(x[0], x[1:], lengths), x),
        "Jv": hand.central_difference(lambda x: hand.four_bar_tool(x[0], x[1:], lengths)[0], x),
        "Jw": spin(lambda x: hand.four_bar_tool(x[0], x[1:], lengths)[1], x),
    }
    for name, J in numeric.items():
        both = [getattr(hand, f"four_bar_{name}"), getattr(hand, f"four_bar_{name}_star")]
        close_to_difference(np.hstack([f(x[0], x[1:], lengths) for f in both]), J)


@pytest.mark.parametrize("lengths", [STRETCHED, FOLDED_LONG, FOLDED_SHORT])
def test_four_bar_crank_limit(lengths):
    theta1, phi = hand.four_bar_crank_limit(lengths)
    assert (theta1 < np.pi) == (lengths == STRETCHED)
    assert_allclose(hand.four_bar_residual(theta1, phi, lengths), 0, atol=1e-14)
    assert abs(np.linalg.det(hand.four_bar_K_star(theta1, phi, lengths))) < 1e-14
    for branch in (1, -1):
        assert_allclose(hand.four_bar_closure(theta1 - 1e-8, lengths, branch), phi, atol=1e-3)
    with pytest.raises(ValueError, match="cannot be assembled"):
        hand.four_bar_closure(theta1 + 1e-8, lengths, 1)
