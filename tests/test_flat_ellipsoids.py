"""What the tool cannot do is exactly zero: ellipsoids are as flat as the ranks say."""

from __future__ import annotations

import math

import hand_derived as hand
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.viewer.tool_ranks import ToolRanks

FRAMES = ("LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD")


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_ellipsoids_are_as_flat_as_the_ranks_of_the_tools_motion(name, rng):
    mechanism = loaded(name)
    poses = [mechanism.home, *mechanisms.random_closed(mechanism, rng, 3, spread=0.1)]
    for pose in poses:
        jacobian, singularity = pose.jacobian(), pose.singularity()
        linear, angular = jacobian.velocity_ellipsoid(), jacobian.angular_ellipsoid()
        assert linear.rank == np.count_nonzero(linear.radii) == singularity.linear_rank
        assert angular.rank == np.count_nonzero(angular.radii) == singularity.angular_rank
        assert jacobian.tool_ranks.twist == singularity.tool_rank
        force = jacobian.force_ellipsoid()
        assert np.count_nonzero(np.isfinite(force.radii)) == linear.rank
        assert max(linear.rank, angular.rank) <= singularity.tool_rank <= linear.rank + angular.rank
        # What was set to zero was rounding, and nothing else changed.
        for ellipsoid, block in ((linear, jacobian.Jv_eq), (angular, jacobian.Jw_eq)):
            values = np.linalg.svd(block, compute_uv=False)
            np.testing.assert_allclose(ellipsoid.radii[: values.size], values, atol=1e-13)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_the_frame_does_not_decide_how_many_ways_the_tool_can_move(name):
    jacobians = {frame: loaded(name).home.jacobian(frame) for frame in FRAMES}
    assert len({jacobian.tool_ranks.twist for jacobian in jacobians.values()}) == 1
    assert len({jacobian.tool_ranks.angular for jacobian in jacobians.values()}) == 1
    aligned, local, _ = jacobians.values()
    assert aligned.tool_ranks == local.tool_ranks


def test_a_tool_at_rest_has_no_velocity_and_bears_every_force(rng):
    """The point about which the eye turns: arms as long as the machine end in it."""
    mechanism = pj.load("agile_eye", {"front": 0.0})
    for pose in mechanisms.random_closed(mechanism, rng, 10, spread=0.3):
        jacobian = pose.jacobian()
        velocity, force = jacobian.velocity_ellipsoid(), jacobian.force_ellipsoid()
        assert velocity.radii.tolist() == [0.0] * 3
        assert velocity.rank == 0
        assert force.radii.tolist() == [math.inf] * 3
        assert jacobian.angular_ellipsoid().rank == 3
        for plane in ("xy", "yz", "zx"):
            assert velocity.section(plane).radii.tolist() == [0.0] * 2
            assert velocity.projection(plane).radii.tolist() == [0.0] * 2


@pytest.mark.parametrize("name", ["delta", "delta_rods", "sarrus"])
def test_a_plate_that_never_turns_has_no_angular_velocity(name, rng):
    mechanism = loaded(name)
    for pose in mechanisms.random_closed(mechanism, rng, 5, spread=0.1):
        assert pose.jacobian().angular_ellipsoid().radii.tolist() == [0.0] * 3
    ranks = ToolRanks.of(mechanism)
    assert ranks.generic[1] == 0
    assert ranks.loss(mechanism.home.jacobian()) == ""


@pytest.mark.parametrize("distance", [1e-2, 1e-5, 1e-8])
def test_a_large_motion_hides_no_small_one(distance):
    """Beside a singularity of K* one radius grows beyond bounds; the others stay, and count."""
    mechanism = loaded("three_rps_ss")
    with pytest.raises(pj.ClosureError) as caught:
        mechanism.close(hand.POSE_B_L, guess="lecture_a")
    end, start = caught.value.reached.actuated, mechanism.pose("lecture_a").actuated
    near = mechanism.close(end + distance * (start - end), guess="lecture_a")
    ellipsoid = near.jacobian().velocity_ellipsoid()
    assert ellipsoid.rank == 3
    assert ellipsoid.radii[0] > 0.05 / math.sqrt(distance)
    assert ellipsoid.radii[2] > 0.05


@pytest.mark.parametrize("angle", [1e-3, 1e-7, 1e-8])
def test_a_radius_is_shown_as_long_as_it_is_no_rounding(angle):
    """Two links in line but for an angle: J is sin(angle) from losing a rank."""
    jacobian = loaded("serial_2r").configuration([0.3, angle]).jacobian()
    values = np.linalg.svd(jacobian.Jv_eq, compute_uv=False)
    np.testing.assert_allclose(jacobian.velocity_ellipsoid().radii[:2], values[:2], rtol=1e-6)
    assert 0.0 < values[1] < 2.0 * angle


@pytest.mark.parametrize("far", [1.0, 1e6])
def test_turning_counts_wherever_the_worlds_origin_is(far):
    """In the WORLD frame the linear rows are as long as the way to the origin."""
    model = pin.buildModelFromXML(
        mechanisms.tree(
            ("theta1", "revolute", "base", "arm", (far, 0, 0), (0, 0, 1)),
            ("theta2", "revolute", "arm", "hand", (0.5, 0, 0), (1, 0, 0)),
            ("tip", "fixed", "hand", "tool", (0.5, 0, 0)),
        )
    )
    mechanism = pj.Mechanism.from_pinocchio(model, [], ["theta1", "theta2"], "tool")
    for frame in FRAMES:
        assert mechanism.home.jacobian(frame).angular_ellipsoid().rank == 2
