"""The tool: a frame, or three points, moving as a rigid body or not."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.kinematics.tool import tool_kinematics
from pmjac_pin.model.tool_spec import Tool


def at(model, tool, q):
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    jacobian, pose = tool.at(model, data)
    return pose.rotation, pose.translation, jacobian


@pytest.mark.parametrize("points", [("S1", "S2", "S3"), ("S2", "base", "leg1_rod")])
def test_points_tool_against_differences_while_the_triangle_deforms(points, rng):
    model = loaded("three_rps_ss").model
    tool = tool_kinematics(model, Tool(points=points))
    h = 1e-6
    for _ in range(20):
        q = pin.neutral(model) + rng.uniform(0.2, 1.2, model.nq)
        rotation, _, jacobian = at(model, tool, q)
        np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-14)
        assert np.linalg.det(rotation) == pytest.approx(1.0)
        for k, direction in enumerate(np.eye(model.nv)):
            ahead = at(model, tool, q + h * direction)
            behind = at(model, tool, q - h * direction)
            np.testing.assert_allclose(jacobian[:3, k], (ahead[1] - behind[1]) / (2 * h), atol=1e-8)
            spin = pin.log3(ahead[0] @ behind[0].T) / (2 * h)
            np.testing.assert_allclose(jacobian[3:, k], spin, atol=1e-7)


def test_points_of_one_body_give_that_bodys_twist(rng):
    """On a rigid triangle, a three-point tool is a frame at the centroid."""
    model = loaded("three_rps").model
    q = pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))
    by_points = at(model, tool_kinematics(model, Tool(points=("S1", "S2", "S3"))), q)
    by_frame = at(model, tool_kinematics(model, Tool(frame="tool")), q)
    for one, other in zip(by_points, by_frame, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-13)


def test_three_points_in_one_line_span_no_frame():
    mechanism = loaded("four_bar")
    with pytest.raises(pj.SingularError, match="in one line"):
        pj.Mechanism.from_pinocchio(
            mechanism.model,
            mechanism.spec.loops,
            ["theta1"],
            ["coupler", "coupler_midpoint", "coupler_tip"],
            home=mechanism.home.q,
        )


def test_tool_pose_is_a_copy():
    configuration = loaded("four_bar").home
    before = configuration.tool_pose().homogeneous
    configuration.tool_pose().translation[:] = 99.0
    np.testing.assert_array_equal(configuration.tool_pose().homogeneous, before)
