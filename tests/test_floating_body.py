"""Floating bodies held at points: their rows say what the loops say, and nothing else."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.studies.modes.box_problem import box_problem, given_values, start

POSES = {
    "planar_3rpr": ("home", "mirrored", "shifted"),
    "planar_3rrr": ("home", "turned", "elbow_right"),
    "three_rps": ("home", "lecture_a", "lecture_b", "view"),
}


def at_pose(name, pose):
    configuration = loaded(name).pose(pose)
    mechanism = configuration.mechanism
    motors = given_values(mechanism, configuration.actuated)
    problem = box_problem(mechanism, motors, False)
    values = np.array([configuration.joint_values[joint] for joint in problem.names])
    return configuration, problem, values


@pytest.mark.parametrize(("name", "pose"), [(n, p) for n, poses in POSES.items() for p in poses])
def test_closed_poses_are_within_the_tolerances(name, pose):
    _, problem, values = at_pose(name, pose)
    whole = problem.loops.evaluate(Intervals.exact(values[None]))
    assert whole.possible.all()
    assert (whole.residual.magnitude[0] <= problem.loops.tolerance).all()


@pytest.mark.parametrize(("name", "pose"), [(n, p) for n, poses in POSES.items() for p in poses])
def test_the_body_is_put_where_it_is_held(name, pose):
    configuration, problem, values = at_pose(name, pose)
    mechanism = configuration.mechanism
    columns = mechanism.problem.partition.actuated
    neutral = pin.neutral(mechanism.kinematics.model)
    q = mechanism.coordinates.with_values(neutral, columns, configuration.actuated)
    found = configuration.mechanism.configuration(start(mechanism, problem, q, values))
    np.testing.assert_allclose(
        found.tool_pose().homogeneous, configuration.tool_pose().homogeneous, atol=1e-10
    )


@pytest.mark.parametrize("name", POSES)
def test_rows_are_off_where_the_loops_gape(name, rng):
    _, problem, values = at_pose(name, POSES[name][0])
    for size in (1e-9, 1e-6, 1e-3):
        away = values + size * rng.choice([-1.0, 1.0], values.size)
        off = problem.loops.residual(Intervals.exact(away[None])).magnitude[0]
        assert (off > problem.loops.tolerance).any()


def test_a_platform_turned_over_is_no_pose_of_the_plane():
    """Its three distances alone would allow the mirror image, which the rows exclude."""
    with_platform = pj.prove(loaded("planar_3rpr"), [0.34, 0.3, 0.4], limits=False)
    modes = pj.assembly_modes(loaded("planar_3rpr"), [0.34, 0.3, 0.4], rng=0)
    assert with_platform
    assert len(with_platform.enclosures) == len(modes)


class Machine(SimpleNamespace):
    """What a proof asks of a mechanism."""

    __hash__ = object.__hash__


def test_a_hinge_the_wrong_way_up_is_no_pose():
    """The same legs and points; one leg's frame turned over, so that its hinge points down."""
    configuration, problem, values = at_pose("planar_3rpr", "home")
    assert problem.loops.evaluate(Intervals.exact(values[None])).possible.all()
    mechanism, model = configuration.mechanism, configuration.mechanism.model
    frame = model.frames[model.getFrameId("leg1_rod")]
    frame.placement = frame.placement * pin.SE3(np.diag([1.0, -1.0, -1.0]), np.zeros(3))
    turned = Machine(
        spec=mechanism.spec,
        parameters=mechanism.parameters,
        coordinates=mechanism.coordinates,
        problem=mechanism.problem,
        home=mechanism.home,
        kinematics=SimpleNamespace(model=model),
    )
    over = box_problem(turned, given_values(turned, configuration.actuated), False)
    assert not over.loops.evaluate(Intervals.exact(values[None])).possible.any()
