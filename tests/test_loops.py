"""Loops: residual and Jacobian in the anchors' axes and in the world's, on and off closure."""

from __future__ import annotations

import re

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.closing.scales import column_scale, row_scale
from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.kinematics.pinocchio import Kinematics
from pmjac_pin.kinematics.tool import tool_kinematics
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.model.tool_spec import Tool

LOOPS = [
    pj.PointLoop(frames=("S1", "leg1_rod")),
    pj.PointLoop(frames=("leg2_rod", "S2")),
    pj.PointLoop(frames=("base", "S3")),
    pj.DistanceLoop(frames=("leg1_rod", "leg2_rod"), length=0.9),
    pj.DistanceLoop(frames=("base", "S3"), length={"a": 2.0}),
    pj.SphericalLoop(frames=("S1", "leg1_rod")),
    pj.FrameLoop(frames=("S1", "leg2_rod")),
    pj.FrameLoop(frames=("leg2_rod", "leg3_rod")),
    pj.RevoluteLoop(frames=("S2", "leg3_rod")),
    pj.RevoluteLoop(frames=("leg1_rod", "S2"), axis=(1, -2, 0.5)),
    pj.PrismaticLoop(frames=("S3", "leg1_rod"), axis=(1, 0, 0)),
    pj.CylindricalLoop(frames=("leg3_rod", "S1"), axis=(0.3, 1, 0)),
    pj.PlanarLoop(frames=("base", "tool"), axis=(0, 1, 1)),
    pj.UniversalLoop(frames=("S2", "leg2_rod")),
    pj.UniversalLoop(frames=("leg2_rod", "leg1_rod"), axes=((1, 1, 0), (0, 0, 1))),
    pj.JointLoop(joints=("l1", "theta2"), ratio=-2.5, offset=0.3),
]


@pytest.fixture(scope="module")
def model():
    return loaded("three_rps").model


@pytest.fixture(scope="module")
def system(model):
    return LoopSystem(model, LOOPS, {"a": 0.5})


def evaluate(system, model, q):
    data, scratch = model.createData(), system.create_data()
    pin.computeJointJacobians(model, data, q)
    residual, jacobian = system.evaluate(model, data, scratch, q)
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
    _, _, (data, scratch) = evaluate(system, model, q)
    residual, _ = system.in_world(model, data, scratch, q)
    pin.framesForwardKinematics(model, data, q)
    position = {frame.name: data.oMf[k].translation for k, frame in enumerate(model.frames)}
    for k, loop in enumerate(LOOPS[:3]):
        expected = position[loop.frames[0]] - position[loop.frames[1]]
        np.testing.assert_allclose(residual[3 * k : 3 * k + 3], expected, atol=1e-14)
    for k, (loop, length) in enumerate(zip(LOOPS[3:5], (0.9, 1.0), strict=True)):
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
        np.testing.assert_array_equal(system.evaluate(model, data, scratch, q)[1], expected)


def test_row_names_and_scales(model, system):
    assert system.row_names[:3] == ("S1-leg1_rod x", "S1-leg1_rod y", "S1-leg1_rod z")
    assert system.row_names[10] == "base-S3 distance²"
    assert system.row_names[-1] == "l1-theta2 ratio"
    columns = column_scale(
        system, JointCoordinates(model).rotational, 2.0, [2.0] * len(system.slices)
    )
    scales = row_scale(system, columns, 2.0, [2.0] * len(system.slices))
    np.testing.assert_allclose(scales[:11], [1] * 9 + [0.5 / 0.9, 0.5])
    for name, unit, scale in zip(
        system.row_names[11:-1], system.row_units[11:-1], scales[11:-1], strict=True
    ):
        angular = re.search(" (turn|tilt|right)", name) is not None
        assert (unit, scale) == (("rad", 2.0) if angular else ("m", 1.0))
    gear = np.abs(evaluate(system, model, pin.neutral(model))[1][-1] * columns * scales[-1])
    assert system.row_units[-1] == "rad"
    assert gear.max() == pytest.approx(1.0)


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


def test_world_jacobian_is_exact_off_closure(model, rng):
    """The rows in world axes against central differences, at poses that are wide open."""
    system = LoopSystem(model, LOOPS, {"a": 0.5})
    kinematics = Kinematics(model, system, tool_kinematics(model, Tool(frame="tool")))
    h = 1e-6
    for _ in range(20):
        q = random_q(model, rng)
        columns = []
        for direction in np.eye(model.nv):
            ahead = kinematics.loop_equations(pin.integrate(model, q, h * direction))[0]
            behind = kinematics.loop_equations(pin.integrate(model, q, -h * direction))[0]
            columns.append((ahead - behind) / (2 * h))
        residual, jacobian = kinematics.loop_equations(q)
        turns = [k for k, name in enumerate(system.row_names) if " turn " in name]
        # Near half a turn Pinocchio's log R loses digits with the square of what is left to it.
        near = np.pi - np.linalg.norm(residual[turns].reshape(-1, 3), axis=1).max()
        np.testing.assert_allclose(jacobian, np.column_stack(columns), atol=1e-9 / near**2 + 1e-8)


AXIS = np.array([0.6, 0.0, 0.8])
HINGE = pin.SE3(pin.AngleAxis(0.7, AXIS).matrix(), np.zeros(3))
SLIDE = pin.SE3(np.eye(3), 0.3 * AXIS)
FLAT = pin.SE3(np.eye(3), np.array([0.8, 0.5, -0.6]))  # perpendicular to AXIS
SWIVEL = pin.SE3(pin.AngleAxis(0.4, np.array([1.0, 0.0, 0.0])).matrix(), np.zeros(3))
SWING = pin.SE3(pin.AngleAxis(-0.9, np.array([0.0, 1.0, 0.0])).matrix(), np.zeros(3))
TOSS = pin.SE3(pin.exp3(np.array([1.0, 0.4, -0.2])), np.zeros(3))
OFF = pin.SE3(pin.exp3(np.array([0.1, -0.2, 0.15])), np.array([0.1, 0.2, -0.3]))

# Each kind with motions that its joint allows, and how many it has.
ALLOWED = {
    "point": (pj.PointLoop(frames=("a", "b")), [TOSS, HINGE], 3),
    "spherical": (pj.SphericalLoop(frames=("a", "b")), [TOSS, HINGE], 3),
    "frame": (pj.FrameLoop(frames=("a", "b")), [pin.SE3.Identity()], 6),
    "revolute": (pj.RevoluteLoop(frames=("a", "b"), axis=tuple(AXIS)), [HINGE], 5),
    "prismatic": (pj.PrismaticLoop(frames=("a", "b"), axis=tuple(AXIS)), [SLIDE], 5),
    "cylindrical": (
        pj.CylindricalLoop(frames=("a", "b"), axis=tuple(AXIS)),
        [SLIDE, HINGE, SLIDE * HINGE],
        4,
    ),
    # The cross carries x of the first body and y of the second: first = second · Ry · Rx.
    "universal": (pj.UniversalLoop(frames=("a", "b")), [SWIVEL, SWING, SWING * SWIVEL], 4),
    "planar": (pj.PlanarLoop(frames=("a", "b"), axis=tuple(AXIS)), [FLAT, HINGE, FLAT * HINGE], 3),
    "distance": (
        pj.DistanceLoop(frames=("a", "b"), length=0.3),
        [SLIDE, TOSS * SLIDE, SLIDE * TOSS],
        1,
    ),
}


def two_bodies():
    """Two free bodies "a" and "b"."""
    model = pin.Model()
    for name in "ab":
        joint = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), name)
        model.addFrame(pin.Frame(name, joint, pin.SE3.Identity(), pin.FrameType.BODY))
    return model


@pytest.mark.parametrize("kind", ALLOWED)
def test_a_kind_is_closed_by_the_motions_of_its_joint_and_no_others(kind, rng):
    loop, motions, rows = ALLOWED[kind]
    model = two_bodies()
    system = LoopSystem(model, [loop], {})
    for motion in motions:
        second = pin.SE3.Random()
        q = np.concatenate([pin.SE3ToXYZQUAT(second * motion), pin.SE3ToXYZQUAT(second)])
        residual, jacobian, _ = evaluate(system, model, q)
        np.testing.assert_allclose(residual, 0.0, atol=1e-14)
        assert np.linalg.matrix_rank(jacobian) == rows
        away = np.concatenate([pin.SE3ToXYZQUAT(second * motion * OFF), pin.SE3ToXYZQUAT(second)])
        assert np.abs(evaluate(system, model, away)[0]).max() > 1e-2


@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "planar", "frame", "prismatic"])
def test_half_a_turn_is_not_closed(kind):
    loop, _, _ = ALLOWED[kind]
    model = two_bodies()
    system = LoopSystem(model, [loop], {})
    over = pin.SE3(pin.AngleAxis(np.pi, np.array([0.0, 1.0, 0.0])).matrix(), np.zeros(3))
    q = np.concatenate([pin.SE3ToXYZQUAT(over), pin.SE3ToXYZQUAT(pin.SE3.Identity())])
    residual, jacobian, _ = evaluate(system, model, q)
    assert np.linalg.norm(residual) >= 2.0 - 1e-12
    assert np.isfinite(jacobian).all()


def test_geared_joints():
    """A rack and its pinion, and two endless wheels of one shaft."""
    model = pin.Model()
    for name, kind in (
        ("pinion", pin.JointModelRZ()),
        ("rack", pin.JointModelPX()),
        ("wheel", pin.JointModelRUBZ()),
        ("other", pin.JointModelRUBZ()),
    ):
        model.addJoint(0, kind, pin.SE3.Identity(), name)
    loops = [
        pj.JointLoop(joints=("pinion", "rack"), ratio=0.05, offset=0.1),
        pj.JointLoop(joints=("wheel", "other"), ratio=-3.0),
    ]
    system = LoopSystem(model, loops, {})
    q = np.array([2.0, 0.2, np.cos(2.0), np.sin(2.0), np.cos(-6.0), np.sin(-6.0)])
    residual, jacobian, _ = evaluate(system, model, q)
    np.testing.assert_allclose(residual, 0.0, atol=1e-15)
    np.testing.assert_array_equal(jacobian, [[-0.05, 1, 0, 0], [0, 0, 3, 1]])
    assert system.row_units == ("m", "rad")
    for ratio, joints in ((0.5, ("wheel", "other")), (2.0, ("wheel", "pinion"))):
        with pytest.raises(pj.ArgumentError, match="'wheel' turns without end"):
            LoopSystem(model, [pj.JointLoop(joints=joints, ratio=ratio)], {})


@pytest.mark.parametrize(
    "kind", [pj.PointLoop, pj.FrameLoop, pj.RevoluteLoop, pj.PrismaticLoop, pj.UniversalLoop]
)
def test_a_model_of_one_joint_has_loops_too(kind):
    """Pinocchio returns its Jacobians as vectors."""
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), "turn")
    for name, body, place in (("one", 0, (0.3, 0.1, 0.4)), ("two", joint, (0.2, -0.5, 0.1))):
        placement = pin.SE3(pin.exp3(np.array(place)), np.array(place))
        model.addFrame(pin.Frame(name, body, placement, pin.FrameType.OP_FRAME))
    system = LoopSystem(model, [kind(frames=("one", "two"))], {})
    residual, jacobian, _ = evaluate(system, model, np.array([0.3]))
    ahead, _, _ = evaluate(system, model, np.array([0.3 + 1e-7]))
    behind, _, _ = evaluate(system, model, np.array([0.3 - 1e-7]))
    assert jacobian.shape == (residual.size, 1)
    np.testing.assert_allclose(jacobian[:, 0], (ahead - behind) / 2e-7, atol=1e-6)
