"""Efforts and forces in the loops that balance a load."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from test_dynamics import away, heavy, parallelogram
from transformed import rebuilt

import pmjac_pin as pj


def left_over(configuration, statics, wrench, springs=()):
    """What is not balanced on the tree's freedoms, by Pinocchio."""
    mechanism = configuration.mechanism
    model, split = mechanism.model, configuration.split_jacobian()
    load = pin.computeGeneralizedGravity(model, model.createData(), configuration.q)
    for column, stiffness, stretched in springs:
        load[column] += stiffness * stretched
    held = split.tool_jacobian.T @ wrench + split.constraint_jacobian.T @ statics.loop_forces
    held[mechanism.problem.partition.actuated] += statics.efforts
    return held - load


def column_size(mechanism):
    return mechanism.problem.partition.column_scale


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_everything_is_in_equilibrium(name, rng):
    configuration = away(heavy(name, rng), rng)
    wrench = rng.normal(size=6)
    statics = configuration.statics(wrench)
    np.testing.assert_allclose(left_over(configuration, statics, wrench), 0, atol=1e-9)
    J_eq, gravity = configuration.jacobian().J_eq, configuration.dynamics().gravity
    np.testing.assert_allclose(statics.efforts, gravity - J_eq.T @ wrench, atol=1e-9)
    lonely = configuration.statics(wrench, gravity=False).efforts
    np.testing.assert_allclose(lonely, -J_eq.T @ wrench, atol=1e-9)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_what_redundant_rows_may_do_to_each_other(name, rng):
    configuration = away(heavy(name, rng), rng)
    statics = configuration.statics()
    constraint = configuration.split_jacobian().constraint_jacobian
    redundant = len(constraint) - configuration.singularity().constraint_rank
    assert statics.self_stress.shape == (len(constraint), redundant)
    np.testing.assert_allclose(constraint.T @ statics.self_stress, 0, atol=1e-9)
    assert statics.determinate == (redundant == 0)
    row = configuration.mechanism.problem.partition.row_scale
    across = (statics.self_stress / row[:, None]).T @ (statics.loop_forces / row)
    np.testing.assert_allclose(
        across, 0, atol=1e-9 * max(1.0, np.abs(statics.loop_forces).max(initial=0.0))
    )


@pytest.mark.parametrize(
    ("name", "more"), [("five_bar", "phi1"), ("three_rps", "theta1"), ("four_bar", "phi1")]
)
def test_motors_against_each_other(name, more, rng):
    """The smallest efforts of all that balance a load; the others are told."""
    mechanism = pj.load(name)
    tied = pj.load(name, actuated=[*mechanism.actuated, more])
    wrench = rng.normal(size=6)
    configuration = tied.configuration(mechanism.home.q)
    statics = configuration.statics(wrench, gravity=False)
    assert statics.internal_efforts.shape == (len(tied.actuated), 1)
    one = np.append(mechanism.home.statics(wrench, gravity=False).efforts, 0.0)
    scale = column_size(tied)[tied.problem.partition.actuated]
    apart = statics.efforts - one
    way = statics.internal_efforts[:, 0]
    np.testing.assert_allclose(apart, way * (apart @ way) / (way @ way), atol=1e-9)
    assert np.linalg.norm(scale * statics.efforts) <= np.linalg.norm(scale * one) + 1e-12
    np.testing.assert_allclose((scale * statics.efforts) @ (scale * way), 0, atol=1e-9)
    np.testing.assert_allclose(left_over(configuration, statics, wrench), 0, atol=1e-9)


def test_a_spring_in_a_passive_joint():
    """τ = Φ k (x − x₀): of a parallelogram's rocker, Φ = 1."""
    configuration = parallelogram(0.7).home
    statics = configuration.statics(gravity=False, springs={"rocker": (5.0, 0.2)})
    assert statics.efforts[0] == pytest.approx(5.0 * 0.5, abs=1e-12)
    column = configuration.mechanism.coordinates.columns(["rocker"])[0]
    model = configuration.mechanism.model
    model.gravity = pin.Motion.Zero()
    still = rebuilt(configuration.mechanism, model)
    resting = left_over(still.home, statics, np.zeros(6), [(column, 5.0, 0.5)])
    np.testing.assert_allclose(resting, 0, atol=1e-12)


def test_a_rod_pulls_along_itself():
    """RSSR: the crank's torque is the moment of the rod's force, 2 l λ along the rod."""
    mechanism = mechanisms.rssr(rod=False)
    configuration, wrench = mechanism.close([0.9]), np.array([3.0, -2.0, 1.0, 0, 0, 0])
    statics = configuration.statics(wrench, gravity=False)
    model, data = mechanism.model, mechanism.model.createData()
    pin.framesForwardKinematics(model, data, configuration.q)
    one, other = (
        data.oMf[model.getFrameId(name)].translation for name in ("crank_tip", "rocker_tip")
    )
    way = (one - other) / mechanisms.RSSR["rod"]
    pull = 2 * mechanisms.RSSR["rod"] * statics.loop_forces[0] * way  # on the crank
    assert statics.efforts[0] == pytest.approx(-np.cross(one, pull)[2], abs=1e-12)
    hub = np.array([1.5, 0.5, 0.2])
    about = np.cross(other - hub, wrench[:3] - pull)  # of the rocker, about its axis
    assert about[1] == pytest.approx(0.0, abs=1e-12)


def test_a_cubic_hexapod():
    """Legs along a closed path of six edges of a cube: √2 four times and 1/√2 twice, published."""
    path = np.array([[1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1], [1, 0, 1]]) - 0.5
    legs = [(path[k], path[(k + 1) % 6])[:: 1 if k % 2 == 0 else -1] for k in range(6)]
    base, top = (np.array(ends) for ends in zip(*legs, strict=True))
    mechanism = pj.stewart(base, top, pin.SE3.Identity())
    statics = [mechanism.home.statics(wrench, gravity=False).efforts for wrench in np.eye(6)]
    values = np.linalg.svd(np.linalg.inv(statics), compute_uv=False)
    np.testing.assert_allclose(values, [2**0.5] * 4 + [0.5**0.5] * 2, atol=1e-12)


def test_what_idles_under_its_own_weight_is_in_no_equilibrium():
    mechanism = mechanisms.rssr()
    model = mechanism.model
    rod = model.getJointId("rz")
    model.inertias[rod] = pin.Inertia(2.0, np.array([1.0, 0.2, 0.0]), 0.02 * np.eye(3))
    mechanism = rebuilt(mechanism, model)
    with pytest.raises(pj.NoEquilibriumError, match=r"drives what idles \(r"):
        mechanism.home.statics()
    assert mechanism.home.statics(gravity=False).efforts == pytest.approx(0.0)
    model.gravity = pin.Motion(1e-12 * model.gravity.linear, np.zeros(3))  # little is not nothing
    with pytest.raises(pj.NoEquilibriumError, match="drives what idles"):
        rebuilt(mechanism, model).home.statics()


def test_at_a_singular_pose_nothing_is_half_computed():
    mechanism = mechanisms.rocker_rocker()
    l0, l1, l2, l3 = mechanism.parameters.values()
    fold = np.arccos((l0**2 + l1**2 - (l2 + l3) ** 2) / (2 * l0 * l1))
    with pytest.raises(pj.SingularError):
        mechanism.close([fold], enforce_limits=False).statics()


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"wrench": [1.0, 2.0]}, r"a wrench: 6 numbers expected, got shape \(2,\)"),
        ({"springs": {"phi3": (1.0, 0.0)}}, "unknown joint 'phi3'"),
        ({"springs": {"phi1": 3.0}}, r"takes \(stiffness, value at rest\)"),
        ({"springs": [1]}, "springs are a mapping"),
        ({"gravity": "no"}, "gravity"),
    ],
)
def test_loads_that_are_none(asked, message):
    with pytest.raises(pj.PmjacError, match=message):
        pj.load("four_bar").home.statics(**asked)
