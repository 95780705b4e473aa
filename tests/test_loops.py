"""Loops: residual and Jacobian in the anchors' axes and in the world's, on and off closure."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest

import pmjac_pin as pj
from pmjac_pin.loops import LoopSystem

LOOPS = [
    pj.PointLoop(frames=("S1", "leg1_rod")),
    pj.PointLoop(frames=("leg2_rod", "S2")),
    pj.PointLoop(frames=("base", "S3")),
    pj.DistanceLoop(frames=("leg1_rod", "leg2_rod"), length=0.9),
    pj.DistanceLoop(frames=("base", "S3"), length={"a": 2.0}),
]


@pytest.fixture(scope="module")
def model():
    return pj.load("three_rps").model


@pytest.fixture(scope="module")
def system(model):
    return LoopSystem(model, LOOPS, {"a": 0.5})


def evaluate(system, model, q):
    data, scratch = model.createData(), system.create_data()
    pin.computeJointJacobians(model, data, q)
    residual, jacobian = system.evaluate(model, data, scratch)
    return residual.copy(), jacobian.copy(), (data, scratch)


def random_q(model, rng):
    return pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))


def test_anchor_axes_jacobian_is_exact_off_closure(system, model, rng):
    h = 1e-6
    for _ in range(20):
        q = random_q(model, rng)
        jacobian = evaluate(system, model, q)[1]
        columns = []
        for direction in np.eye(model.nv):
            ahead = evaluate(system, model, pin.integrate(model, q, h * direction))[0]
            behind = evaluate(system, model, pin.integrate(model, q, -h * direction))[0]
            columns.append((ahead - behind) / (2 * h))
        np.testing.assert_allclose(jacobian, np.column_stack(columns), atol=1e-7)


def test_world_rows_are_first_minus_second(system, model, rng):
    q = random_q(model, rng)
    residual, jacobian, (data, scratch) = evaluate(system, model, q)
    system.to_world(scratch, residual, jacobian)
    pin.framesForwardKinematics(model, data, q)
    position = {frame.name: data.oMf[k].translation for k, frame in enumerate(model.frames)}
    for k, loop in enumerate(LOOPS[:3]):
        expected = position[loop.frames[0]] - position[loop.frames[1]]
        np.testing.assert_allclose(residual[3 * k : 3 * k + 3], expected, atol=1e-14)
    for k, (loop, length) in enumerate(zip(LOOPS[3:], (0.9, 1.0), strict=True)):
        gap = position[loop.frames[0]] - position[loop.frames[1]]
        assert residual[9 + k] == pytest.approx(gap @ gap - length**2, abs=1e-14)


def test_world_jacobian_is_exact_on_closure():
    for configuration in mechanisms.random_poses("three_rps", 7, 10):
        model = configuration.mechanism.model
        jacobian = configuration.split_jacobian().constraint_jacobian
        data = model.createData()
        pin.computeJointJacobians(model, data, configuration.q)
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

        def point(name, model=model, data=data, aligned=aligned):
            return pin.getFrameJacobian(model, data, model.getFrameId(name), aligned)[:3]

        for k in range(3):
            expected = point(f"S{k + 1}") - point(f"leg{k + 1}_rod")
            np.testing.assert_allclose(jacobian[3 * k : 3 * k + 3], expected, atol=1e-11)


def test_the_jacobian_is_never_the_one_of_another_q(model, system, rng):
    """The same scratch data at two poses in turn: nothing is left over from the other."""
    first, second = random_q(model, rng), random_q(model, rng)
    fresh = [evaluate(system, model, q)[1] for q in (first, second)]
    data, scratch = model.createData(), system.create_data()
    for q, expected in ((first, fresh[0]), (second, fresh[1]), (first, fresh[0])):
        pin.computeJointJacobians(model, data, q)
        np.testing.assert_array_equal(system.evaluate(model, data, scratch)[1], expected)


def test_row_names_and_scales(system):
    assert system.row_names[:3] == ("S1-leg1_rod x", "S1-leg1_rod y", "S1-leg1_rod z")
    assert system.row_names[-1] == "base-S3 distance²"
    np.testing.assert_allclose(system.row_scale, [1] * 9 + [0.5 / 0.9, 0.5])


def test_agrees_with_pinocchios_own_stacked_jacobian(model, rng):
    """Up to the anchors' rotation: ``getConstraintsJacobian`` of the same anchors."""
    loops = [pj.PointLoop(frames=(f"S{k}", f"leg{k}_rod")) for k in (1, 2, 3)]
    system = LoopSystem(model, loops, {})
    q = random_q(model, rng)
    _, jacobian, (data, _) = evaluate(system, model, q)
    models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
    for loop in loops:
        first, second = (model.frames[model.getFrameId(name)] for name in loop.frames)
        anchor = pin.PointAnchorConstraintModel(
            model, second.parentJoint, second.placement, first.parentJoint, first.placement
        )
        scratch = anchor.createData()
        anchor.calc(model, data, scratch)
        models.append(pin.ConstraintModel(anchor))
        datas.append(pin.ConstraintData(scratch))
    stacked = pin.getConstraintsJacobian(model, data, models, datas)
    np.testing.assert_allclose(jacobian, stacked, atol=1e-15)
