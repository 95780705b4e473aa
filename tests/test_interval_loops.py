"""Enclosed loop equations: Pinocchio's at every point of a box are inside."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from test_one_kinematics import pinocchios, without_roots

import pmjac_pin as pj
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.closing.scales import row_scale
from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.kinematics.loops import pair_of
from pmjac_pin.kinematics.tree import Tree
from pmjac_pin.model.linkage import with_helical
from pmjac_pin.studies.modes.interval_loops import IntervalLoops, PairRows, tolerances
from pmjac_pin.studies.modes.interval_tree import IntervalTree

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
    return with_helical(pin.buildModelFromXML(mechanisms.tree(*JOINTS)), {"other": -0.3})


def interval_loops(model, loop):
    tree = IntervalTree(Tree(model), UNKNOWNS, MOTOR)
    pair = pair_of(model, tree.tree, loop, {})
    blocks = [block for _, block in pair.blocks]
    names = tuple(name for block in blocks for name in block.names)
    sizes = tuple(size for block in blocks for size in tolerances(block, CLOSED, 1.0))
    return IntervalLoops(tree, [PairRows(pair, names, sizes)])


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


def holds_nearly(intervals, values, near=1.0):
    """Pinocchio rounds, too: by less than 1e-13 here."""
    return intervals.widened(1e-13 / near).holds(values).all()


@pytest.mark.parametrize("size", [0.0, 1e-3, 0.3, 3.0])
@pytest.mark.parametrize("kind", LOOPS)
def test_a_box_holds_pinocchios_rows_and_derivatives(model, kind, size, rng):
    boxes = random_boxes(rng, 20, size)
    enclosed = interval_loops(model, LOOPS[kind]).evaluate(boxes)
    columns = [model.joints[model.getJointId(name)].idx_v for name in UNKNOWNS]
    for row, values in enumerate(random_points(rng, boxes)):
        exact = pinocchios(model, LOOPS[kind], q_of(model, values))
        residual, jacobian, cosine = without_roots(*exact)
        # Near half a turn the oracle loses digits: of a derivative twice as many.
        near = 1.0 if cosine is None else np.sqrt(1.0 + cosine)
        assert holds_nearly(enclosed.residual[row], residual, near)
        assert holds_nearly(enclosed.jacobian[row], jacobian[:, columns], near**2)
        assert cosine is None or cosine < 0.0 or enclosed.possible[row]
        assert size > 0.0 or cosine is None or enclosed.possible[row] == (cosine > 0.0)


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
    np.testing.assert_allclose(found.lower, part.residual.lower, rtol=0, atol=1e-14)


def test_tolerances_are_those_of_the_gap_in_metres():
    for loop in LOOPS.values():
        sizes = [size for block in loop.rows({}) for size in tolerances(block, CLOSED, 4.0)]
        model = pin.buildModelFromXML(mechanisms.tree(*JOINTS))
        system = LoopSystem(model, [loop], {})
        scales = row_scale(system, np.ones(model.nv), 4.0, [4.0] * len(system.slices))
        np.testing.assert_allclose(np.array(sizes) * scales, CLOSED)
