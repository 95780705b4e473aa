"""The vectorised loop equations against Pinocchio's, one pose at a time."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded
from test_linkage import BALL
from test_loops import LOOPS

import pmjac_pin as pj
from pmjac_pin.algebra.tape_runner import tape_kernel
from pmjac_pin.kinematics import many
from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.kinematics.many import ManyLoops, ManyPoses
from pmjac_pin.studies.modes.search_problem import search_problem

MANY = many._MANY + 6  # poses, which go through a program


def random_rows(model, rng, count=7):
    neutral = pin.neutral(model)
    return np.array(
        [pin.integrate(model, neutral, rng.normal(size=model.nv)) for _ in range(count)]
    )


@pytest.mark.parametrize("name", [*mechanisms.CATALOGUE, "all kinds"])
def test_poses_and_motions_are_pinocchios(name, rng):
    model = pin.buildModelFromXML(BALL) if name == "all kinds" else loaded(name).model
    tree, data = ManyPoses(model), model.createData()
    q = random_rows(model, rng)
    poses = tree.poses(q)
    for row in range(len(q)):
        J = pin.computeJointJacobians(model, data, q[row])
        for body, placement in enumerate(data.oMi):
            np.testing.assert_allclose(poses.rotations[body, row], placement.rotation, atol=1e-13)
            np.testing.assert_allclose(
                poses.positions[body, row], placement.translation, atol=1e-13
            )
        np.testing.assert_allclose(poses.linear[row], J[:3], atol=1e-13)
        np.testing.assert_allclose(poses.angular[row], J[3:], atol=1e-13)


@pytest.mark.parametrize("name", ["three_rps", "ur5", "all kinds"])
def test_moved_is_pinocchios_integrate(name, rng):
    model = pin.buildModelFromXML(BALL) if name == "all kinds" else loaded(name).model
    q, v = random_rows(model, rng), rng.normal(size=(7, model.nv))
    # A turning slide in SE(2) or SE(3) is Pinocchio's way; ours slides straight, then turns.
    small = 1e-4 * v
    moved = ManyPoses(model).moved(q, small)
    for row in range(len(q)):
        np.testing.assert_allclose(moved[row], pin.integrate(model, q[row], small[row]), atol=1e-7)


@pytest.mark.parametrize("gear_first", [False, True])
def test_rows_are_pinocchios_in_the_order_of_the_loops(gear_first, rng):
    """Exact off closure, seen from the base that carries all of them here, the world."""
    model = loaded("three_rps").model
    loops = LOOPS[-1:] + LOOPS[:-1] if gear_first else LOOPS
    values = {"a": 0.5}
    system, tree = LoopSystem(model, loops, values), ManyPoses(model)
    q = random_rows(model, rng)
    residuals, jacobians = ManyLoops(model, tree, loops, values).evaluate(q)
    data, scratch = model.createData(), system.create_data()
    for row in range(len(q)):
        pin.computeJointJacobians(model, data, q[row])
        residual, jacobian = system.in_world(model, data, scratch, q[row])
        np.testing.assert_allclose(residuals[row], residual, atol=1e-12)
        system.add_turning(model, data, residual, jacobian)
        turns = [k for k, name in enumerate(system.row_names) if " turn " in name]
        # Near half a turn Pinocchio's own derivative of the logarithm loses digits.
        sizes = np.linalg.norm(residual[turns].reshape(-1, 3), axis=1)
        near = min(1.0, float(np.pi - sizes.max()))
        np.testing.assert_allclose(jacobians[row], jacobian, atol=1e-11 / near**2)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_many_rows_are_those_of_one(name, rng):
    """Many go through a program where there is a kernel; one alone does not."""
    mechanism = loaded(name)
    problem = search_problem(mechanism, mechanism.home.q)
    q = random_rows(problem.model, rng, MANY)
    residuals, jacobians = problem.loops.evaluate(q)
    assert residuals.shape == (MANY, len(problem.partition.row_scale))
    assert (problem.loops._tape is None) == (tape_kernel() is None or not problem.loops.loops.count)
    for rows in np.arange(10)[:, None]:
        some_residuals, some_jacobians = problem.loops.evaluate(q[rows])
        np.testing.assert_allclose(residuals[rows], some_residuals, atol=1e-12)
        np.testing.assert_allclose(jacobians[rows], some_jacobians, atol=1e-12)


@pytest.mark.parametrize("count", [2, MANY], ids=["by NumPy", "by a program"])
@pytest.mark.parametrize("short_of", [0.0, 1e-9, 1e-7, 1e-5, 1e-3])
@pytest.mark.parametrize(
    ("kind", "open_by"),
    [
        (pj.FrameLoop, np.pi),
        (pj.PrismaticLoop, np.pi),
        (pj.RevoluteLoop, 2.0),
        (pj.CylindricalLoop, 2.0),
        (pj.PlanarLoop, 2.0),
    ],
)
def test_nothing_is_closed_at_half_a_turn(kind, open_by, short_of, count):
    """There the polynomials of tilts and turns vanish, too."""
    gaps = turned_by_half(pin.JointModelRX(), kind, short_of, count)
    assert np.linalg.norm(gaps, axis=1) == pytest.approx(open_by, abs=1e-5 + short_of)


@pytest.mark.parametrize("count", [2, MANY], ids=["by NumPy", "by a program"])
@pytest.mark.parametrize("short_of", [1e-10, 1e-9, 1e-8, 1e-7, 1e-6])
def test_a_turn_keeps_its_axis_short_of_half_a_turn(short_of, count):
    """What turned about another one there would lead starts nowhere."""
    gaps = turned_by_half(pin.JointModelRZ(), pj.FrameLoop, short_of, count)
    assert abs(gaps[:, -1]) == pytest.approx(np.pi, abs=2e-6)


def turned_by_half(joint, kind, short_of, count):
    """Return the gaps between two bodies that turn about one line, half a turn apart."""
    model = pin.Model()
    for name in ("one", "two"):
        body = model.addJoint(0, joint, pin.SE3.Identity(), f"joint {name}")
        model.addFrame(pin.Frame(name, body, pin.SE3.Identity(), pin.FrameType.OP_FRAME), False)
    loop = kind(frames=("one", "two"))
    q = np.array([[0.4, 0.4 + np.pi - short_of]] * count)
    gaps, _ = ManyLoops(model, ManyPoses(model), [loop], {}).evaluate(q)
    return gaps
