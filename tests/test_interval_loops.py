"""Enclosed poses and loop equations: Pinocchio's at every point of a box are inside."""

from __future__ import annotations

import hand_derived as hand
import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import pmjac_pin as pj
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.frames import find_frame
from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.kinematics.loops import loop_blocks
from pmjac_pin.modes.interval_loops import IntervalLoops, PairRows, tolerances
from pmjac_pin.modes.interval_tree import IntervalTree
from pmjac_pin.scales import row_scale

CLOSED = 1e-12
X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)
SLANTED = (0.6, 0.0, 0.8)
JOINTS = [
    ("motor", "revolute", "ground", "a", (0.1, 0.2, 0.3), Z, (0.3, -0.2, 0.5)),
    ("first", "continuous", "a", "b", (0.4, 0, 0), SLANTED, (0, 0.7, 0)),
    ("slide", "prismatic", "b", "c", (0, 0.1, 0), Y),
    ("last", "revolute", "c", "d", (0.2, 0, 0.1), X, (0.1, 0.2, 0.3)),
    ("other", "revolute", "ground", "e", (1, 0, 0), (0, 0.6, -0.8)),
    ("push", "prismatic", "e", "f", (0, 0, 0.3), SLANTED),
    ("one_at", "fixed", "d", "one", (0.1, 0.1, 0), None, (0.4, 0, 0.2)),
    ("two_at", "fixed", "f", "two", (0, 0.1, 0.2), None, (0, 0.3, 1.0)),
]
UNKNOWNS = ("first", "slide", "last", "other", "push")
MOTOR = {"motor": 0.4}
PAIR = ("one", "two")
LOOPS = {
    "point": pj.PointLoop(frames=PAIR),
    "spherical": pj.SphericalLoop(frames=PAIR),
    "distance": pj.DistanceLoop(frames=PAIR, length=0.7),
    "revolute": pj.RevoluteLoop(frames=PAIR, axis=SLANTED),
    "universal": pj.UniversalLoop(frames=PAIR),
    "cylindrical": pj.CylindricalLoop(frames=PAIR),
    "prismatic": pj.PrismaticLoop(frames=PAIR, axis=Y),
    "planar": pj.PlanarLoop(frames=PAIR),
    "frame": pj.FrameLoop(frames=PAIR),
}


@pytest.fixture(scope="module")
def model():
    return pin.buildModelFromXML(mechanisms.tree(*JOINTS))


def interval_loops(model, loop):
    first, second = (find_frame(model, name) for name in loop.frames)
    rows = [
        PairRows(first, second, block, block.names, tolerances(block, CLOSED, 1.0))
        for block in loop_blocks(loop, {})
    ]
    return IntervalLoops(IntervalTree(model, UNKNOWNS, MOTOR), rows, len(UNKNOWNS))


def random_boxes(rng, count, size):
    middle = rng.uniform(-4, 4, (count, len(UNKNOWNS)))
    half = size * rng.uniform(0, 1, middle.shape)
    return Intervals(middle - half, middle + half)


def random_points(rng, boxes):
    share = rng.random(boxes.shape)
    inside = boxes.lower + share * boxes.width
    return np.clip(inside, boxes.lower, boxes.upper)


def q_of(model, values):
    q = pin.neutral(model)
    for name, value in {**MOTOR, **dict(zip(UNKNOWNS, values, strict=True))}.items():
        joint = model.joints[model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = (
            value if joint.nq == 1 else (np.cos(value), np.sin(value))
        )
    return q


def holds_nearly(intervals, values):
    """Pinocchio rounds, too: by less than 1e-13 here."""
    return intervals.widened(1e-13).holds(values).all()


@pytest.mark.parametrize("size", [0.0, 1e-6, 0.3, 3.0])
def test_poses_are_pinocchios(model, size, rng):
    frames = [find_frame(model, name) for name in ("one", "two", "c", "ground")]
    boxes = random_boxes(rng, 20, size)
    poses = IntervalTree(model, UNKNOWNS, MOTOR).frames(frames, boxes, ())
    data = model.createData()
    for row, values in enumerate(random_points(rng, boxes)):
        pin.framesForwardKinematics(model, data, q_of(model, values))
        for frame in frames:
            pose = poses[frame.index]
            exact = data.oMf[frame.index].homogeneous[None, :3]
            assert holds_nearly(pose[row % pose.shape[0]], exact)
            assert size > 0.0 or pose.width.max() < 1e-12


def pinocchios_rows(model, loop, q):
    """The rows that stand for Pinocchio's, and their derivatives by the unknowns."""
    system, data = LoopSystem(model, [loop], {}), model.createData()
    pin.computeJointJacobians(model, data, q)
    scratch = system.create_data()
    residual, jacobian = system.evaluate(model, data, scratch, q)
    system.to_world(scratch, residual, jacobian)
    system.add_turning(model, data, residual, jacobian)
    columns = [model.joints[model.getJointId(name)].idx_v for name in UNKNOWNS]
    return residual, jacobian[:, columns]


@pytest.mark.parametrize("size", [0.0, 1e-3, 1.0])
@pytest.mark.parametrize("kind", ["point", "spherical", "distance", "universal"])
def test_rows_and_derivatives_are_pinocchios(model, kind, size, rng):
    boxes = random_boxes(rng, 20, size)
    enclosed = interval_loops(model, LOOPS[kind]).evaluate(boxes)
    for row, values in enumerate(random_points(rng, boxes)):
        residual, jacobian = pinocchios_rows(model, LOOPS[kind], q_of(model, values))
        assert holds_nearly(enclosed.residual[row], residual)
        assert holds_nearly(enclosed.jacobian[row], jacobian)
    assert enclosed.possible.all()


@pytest.mark.parametrize("kind", LOOPS)
def test_derivatives_are_those_of_the_rows(model, kind, rng):
    loops = interval_loops(model, LOOPS[kind])
    values = rng.uniform(-3, 3, len(UNKNOWNS))

    def rows(at):
        return loops.residual(Intervals.exact(at[None])).middle[0]

    expected = hand.central_difference(rows, values)
    found = loops.evaluate(Intervals.exact(values[None])).jacobian
    np.testing.assert_allclose(found.middle[0], expected, atol=1e-8)
    assert found.width.max() < 1e-11


@pytest.mark.parametrize("kind", LOOPS)
def test_a_box_holds_its_parts(model, kind, rng):
    loops = interval_loops(model, LOOPS[kind])
    boxes = random_boxes(rng, 30, 0.7)
    points = Intervals.exact(random_points(rng, boxes))
    whole, part = loops.evaluate(boxes), loops.evaluate(points)
    assert part.residual.inside(whole.residual).all()
    assert part.jacobian.inside(whole.jacobian).all()
    assert (whole.possible >= part.possible).all()
    found = loops.residual(points)
    np.testing.assert_array_equal(found.lower, part.residual.lower)


@pytest.mark.parametrize("kind", ["revolute", "cylindrical", "prismatic", "planar", "frame"])
def test_turned_rows_are_pinocchios_shortened(model, kind, rng):
    """Tilts by cos α/2, turns by sin α / α and in the second frame's axes; slides as they are."""
    loop = LOOPS[kind]
    loops = interval_loops(model, loop)
    values = random_points(rng, random_boxes(rng, 40, 0.0))
    enclosed = loops.evaluate(Intervals.exact(values))
    data = model.createData()
    for row, at in enumerate(values):
        q = q_of(model, at)
        residual, _ = pinocchios_rows(model, loop, q)
        pin.framesForwardKinematics(model, data, q)
        one, other = (data.oMf[find_frame(model, name).index].rotation for name in PAIR)
        found = enclosed.residual[row].middle
        names = np.array(loops.names)
        tilts = np.char.startswith(names, "tilt")
        turns = np.char.startswith(names, "turn")
        np.testing.assert_allclose(found[~tilts & ~turns], residual[~tilts & ~turns], atol=1e-13)
        if tilts.any():
            axis = np.array(loop.axis)
            cosine = (one @ axis) @ (other @ axis)
            half = np.sqrt((1.0 + cosine) / 2.0)
            np.testing.assert_allclose(found[tilts], residual[tilts] * half, atol=1e-12)
            assert enclosed.possible[row] == (cosine > 0.0)
        if turns.any():
            turn = Rotation.from_matrix(other.T @ one)
            expected = turn.as_rotvec() * np.sinc(turn.magnitude() / np.pi)
            np.testing.assert_allclose(found[turns], expected, atol=1e-12)
            assert enclosed.possible[row] == (turn.magnitude() < np.pi / 2)


def test_tolerances_are_those_of_the_gap_in_metres():
    for loop in LOOPS.values():
        sizes = [size for block in loop_blocks(loop, {}) for size in tolerances(block, CLOSED, 4.0)]
        model = pin.buildModelFromXML(mechanisms.tree(*JOINTS))
        system = LoopSystem(model, [loop], {})
        scales = row_scale(system, np.ones(model.nv), 4.0, [4.0] * len(system.slices))
        np.testing.assert_allclose(np.array(sizes) * scales, CLOSED)
