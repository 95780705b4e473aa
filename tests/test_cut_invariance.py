"""J_eq is invariant to the cut: the strongest law there is."""

from __future__ import annotations

import hand_derived as hand
import mechanisms
import numpy as np
import pytest
from mechanisms import loaded


def same_machine(configuration, other):
    """The pose of `other` with the same motors and legs: three_rps with three_rps_ss's angles."""
    tool = configuration.tool_pose().homogeneous
    turn = -5 * np.pi / 6  # plate axes from tool axes, about the common normal
    plate = tool.copy()
    plate[:3, :3] = tool[:3, :3] @ np.array(
        [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    )
    import pinocchio as pin

    names = configuration.mechanism.actuated + configuration.mechanism.passive
    guess = dict(configuration.joint_values)
    guess["platform"] = pin.SE3ToXYZQUAT(pin.SE3(plate))
    assert set(names) <= set(guess)
    return other.close(configuration.actuated, guess=guess)


@pytest.mark.slow
def test_contact_constraints_and_distance_loops_give_the_same_j_eq():
    other = loaded("three_rps")
    for configuration in mechanisms.random_poses("three_rps_ss", 3, 120):
        twin = same_machine(configuration, other)
        np.testing.assert_allclose(
            twin.tool_pose().homogeneous, configuration.tool_pose().homogeneous, atol=1e-9
        )
        for frame in ("LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"):
            J_eq = configuration.jacobian(frame).J_eq
            difference = np.abs(twin.jacobian(frame).J_eq - J_eq).max()
            # Two roots, each closed to 1e-12 m, differ by that over the smallest singular value.
            room = max(1.0, 1e-2 / configuration.singularity().smallest) * np.abs(J_eq).max()
            assert difference <= 1e-10 * room


@pytest.mark.parametrize("theta1", [0.3, 1.3, 2.9, -1.1, -2.6])
@pytest.mark.parametrize("branch", [1, -1])
def test_four_bar_cut_at_each_joint(theta1, branch):
    phi = hand.four_bar_closure(theta1, mechanisms.CRANK_ROCKER, branch)
    reference = loaded("four_bar").close(
        [theta1], guess={"theta1": theta1, "phi1": phi[0], "phi2": phi[1]}
    )
    for joint in "ABCD":
        cut = mechanisms.four_bar_cut_at(joint, theta1, phi)
        assert cut.mobility == 1
        np.testing.assert_allclose(
            cut.home.jacobian().J_eq, reference.jacobian().J_eq, atol=1e-10, err_msg=joint
        )


def test_rod_as_a_body_and_as_a_distance():
    for theta in np.linspace(-3, 3, 13):
        with_body = mechanisms.rssr().close([theta])
        as_distance = mechanisms.rssr(rod=False).close([theta])
        np.testing.assert_allclose(
            with_body.jacobian().J_eq, as_distance.jacobian().J_eq, atol=1e-10
        )
