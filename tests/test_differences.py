"""Analytic Jacobians against central differences through the closure, and the laws of J_eq."""

from __future__ import annotations

from itertools import pairwise

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from differences import difference_quotient
from mechanisms import loaded

import pmjac_pin as pj

MECHANISMS = {
    **{name: (lambda name=name: loaded(name)) for name in mechanisms.CATALOGUE},
    "rocker_rocker": mechanisms.rocker_rocker,
    "yawing_four_bar": mechanisms.yawing_four_bar,
    "rssr": mechanisms.rssr,
    "three_crank_parallelogram": mechanisms.three_crank_parallelogram,
}


def generic(mechanism, rng):
    return mechanisms.random_closed(mechanism, rng, 8, 0.2)


def near_singular(mechanism, rng):
    """Poses close to where a path from home meets its first singularity; none if it never does."""
    poses = []
    reach, count = (6, 6) if mechanism.nv < 15 else (2, 2)  # long paths of large ones take long
    for _ in range(count):
        direction = rng.normal(size=len(mechanism.actuated))
        try:
            mechanism.close(mechanism.home.actuated + reach * direction, enforce_limits=False)
        except pj.ClosureError as error:
            path = error.reached.actuated - mechanism.home.actuated
            near = mechanism.home.actuated + 0.999 * path
            poses.append(mechanism.close(near, enforce_limits=False))
        except pj.LimitError:
            continue
    return poses


QUICK = {*mechanisms.SAMPLE, "four_bar", "yawing_four_bar", "rssr", "three_crank_parallelogram"}


@pytest.fixture(scope="module", params=mechanisms.mostly_slow(MECHANISMS, QUICK))
def mechanism(request):
    return MECHANISMS[request.param]()


@pytest.fixture(scope="module", params=[generic, near_singular])
def poses(request, mechanism):
    seed = list(f"{mechanism.name} {request.param.__name__}".encode())
    found = request.param(mechanism, np.random.default_rng(seed))
    if not found:
        pytest.skip("no singularity is met on a path from home")
    return found


def derivative(configuration):
    """The difference quotient at that of four steps where it changes least to the next one.

    Near a singularity rounding, divided by K*, spoils small steps, and the fold large ones.
    """
    smallest = min(1.0, configuration.singularity().smallest)
    quotients = []
    for factor in (1, 10, 100, 1000):
        try:
            h = factor * (1e-3 * smallest**2 + 1e-7)
            quotients.append(difference_quotient(configuration, h))
        except pj.ClosureError:  # it reaches beyond the singularity
            break
    changes = [np.abs(second - first).max() for first, second in pairwise(quotients)]
    return quotients[int(np.argmin(changes)) if changes else 0]


def test_j_eq_is_the_derivative_through_the_closure(poses):
    for configuration in poses:
        J_eq = configuration.jacobian().J_eq
        assert np.abs(derivative(configuration) - J_eq).max() <= 1e-6 * np.abs(J_eq).max()


def test_the_loops_stay_closed_to_first_order(poses):
    for configuration in poses:
        jacobian = configuration.jacobian()
        scale = 1e-10 * (1 + np.abs(jacobian.passive_rates).max(initial=0))
        closing = jacobian.K + jacobian.K_star @ jacobian.passive_rates
        assert np.abs(closing).max(initial=0) <= scale
        whole = jacobian.constraint_jacobian @ jacobian.motion_map
        assert np.abs(whole).max(initial=0) <= scale


def test_j_eq_is_the_tool_jacobian_on_the_motion_map(poses):
    for configuration in poses:
        jacobian = configuration.jacobian()
        J_eq = jacobian.tool_jacobian @ jacobian.motion_map
        np.testing.assert_allclose(jacobian.J_eq, J_eq, atol=1e-12 * (1 + np.abs(J_eq).max()))
        np.testing.assert_array_equal(jacobian.J_eq, np.vstack([jacobian.Jv_eq, jacobian.Jw_eq]))
        np.testing.assert_allclose(jacobian.gv_eq, jacobian.Jv_eq.T @ jacobian.Jv_eq)
        np.testing.assert_allclose(jacobian.gw_eq, jacobian.Jw_eq.T @ jacobian.Jw_eq)


def test_frames_change_by_the_adjoint(poses):
    for configuration in poses:
        local = configuration.jacobian("LOCAL").J_eq
        pose = configuration.tool_pose()
        aligned = pin.SE3(pose.rotation, np.zeros(3))
        scale = 1e-12 * (1 + np.abs(local).max())
        for frame, action in (
            ("LOCAL_WORLD_ALIGNED", aligned.action),
            (pin.ReferenceFrame.LOCAL_WORLD_ALIGNED, aligned.action),
            ("WORLD", pose.action),
            (pin.WORLD, pose.action),
        ):
            J_eq = configuration.jacobian(frame).J_eq
            np.testing.assert_allclose(J_eq, action @ local, atol=scale)


def test_power_is_the_same_at_the_motors_and_at_the_tool(poses, rng):
    """τ = J_eqᵀ w balances the tool wrench w, and the loop forces do no work."""
    for configuration in poses:
        jacobian = configuration.jacobian()
        wrench, rates = rng.normal(size=6), rng.normal(size=len(configuration.actuated))
        effort = jacobian.J_eq.T @ wrench
        q_dot = jacobian.motion_map @ rates
        multipliers = rng.normal(size=jacobian.constraint_jacobian.shape[0])
        loop_power = q_dot @ (jacobian.constraint_jacobian.T @ multipliers)
        tool_power = wrench @ (jacobian.tool_jacobian @ q_dot)
        scale = 1e-10 * (1 + np.abs(q_dot).max() ** 2)
        assert abs(loop_power) <= scale
        assert effort @ rates == pytest.approx(tool_power, abs=scale)


def test_linear_rows_come_first():
    """A unit test on row order: the 2R arm turns about z at 1 rad/s for each motor."""
    J_eq = loaded("serial_2r").close([0.0, 0.0]).jacobian().J_eq
    np.testing.assert_allclose(
        J_eq, [[0, 0], [1.8, 0.8], [0, 0], [0, 0], [0, 0], [1, 1]], atol=1e-15
    )


@pytest.mark.parametrize("name", ["serial_2r", "ur5"])
def test_open_chains_are_the_trivial_case(name):
    mechanism = loaded(name)
    jacobian = mechanism.home.jacobian()
    assert jacobian.K.shape == (0, len(mechanism.actuated))
    assert jacobian.K_star.shape == (0, 0)
    model = mechanism.model
    data = model.createData()
    frame = model.getFrameId(mechanism.spec.tool.frame)
    pin.computeJointJacobians(model, data, mechanism.home.q)
    expected = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
    np.testing.assert_allclose(jacobian.J_eq, expected, atol=1e-14)
