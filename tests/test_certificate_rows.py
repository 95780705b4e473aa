"""Enclosed loop equations against Pinocchio, and their bends against sampled second derivatives."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation
from test_linkage import BALL
from test_loops import LOOPS

import pmjac_pin as pj
from pmjac_pin.algebra.balls import middles, uppers
from pmjac_pin.model.linkage import edges_of, with_spherical
from pmjac_pin.model.rows import across
from pmjac_pin.studies.certificates.equations import LoopEquations

STEP = 1e-4  # of second differences: their error is about 1e-16 / STEP²


def slider_above():
    """A turn above a slide above a turn, twice, on a slide of their own."""
    arms = [
        (
            (f"a{k}", "revolute", "cart", f"arm{k}", (0.1, 0.2 * k, 0), (0, k, 1)),
            (f"s{k}", "prismatic", f"arm{k}", f"rod{k}", (0.3, 0, 0.1), (1, 1, k)),
            (f"b{k}", "continuous", f"rod{k}", f"hand{k}", (0, 0.4, 0), (1, 0, 1)),
            (f"c{k}", "prismatic", f"hand{k}", f"tip{k}", (0.2, 0, 0), (0, 1, 0)),
        )
        for k in (1, 2)
    ]
    return mechanisms.tree(
        ("base", "revolute", "ground", "table", (0, 0, 0), mechanisms.Z),
        ("cart", "prismatic", "table", "cart", (0.5, 0, 0), (1, 0, 0)),
        *arms[0],
        *arms[1],
    )


def all_kinds():
    """Every kind of joint; the ball is one."""
    return with_spherical(pin.buildModelFromXML(BALL), ["ball"])


def kinds(first, second):
    """One loop of each kind between two frames."""
    return [
        pj.PointLoop(frames=(first, second)),
        pj.DistanceLoop(frames=(second, first), length=0.9),
        pj.FrameLoop(frames=(first, second)),
        pj.RevoluteLoop(frames=(second, first), axis=(1, -2, 0.5)),
        pj.PrismaticLoop(frames=(first, second), axis=(1, 0, 0)),
        pj.CylindricalLoop(frames=(first, second), axis=(0.3, 1, 0)),
        pj.PlanarLoop(frames=(first, second), axis=(0, 1, 1)),
        pj.UniversalLoop(frames=(first, second), axes=((1, 1, 0), (0, 0, 1))),
    ]


CASES = {
    "four_bar": lambda: from_mechanism(pj.load("four_bar")),
    "watt_six_bar": lambda: from_mechanism(pj.load("watt_six_bar")),
    "three_rps": lambda: from_mechanism(pj.load("three_rps")),
    "three_rps_ss": lambda: from_mechanism(pj.load("three_rps_ss")),
    "rssr": lambda: from_mechanism(mechanisms.rssr()),
    "rssr as a distance": lambda: from_mechanism(mechanisms.rssr(rod=False)),
    "yawing four-bar": lambda: from_mechanism(mechanisms.yawing_four_bar()),
    "all loops of three_rps": lambda: (pj.load("three_rps").model, LOOPS[:-1], {"a": 0.5}),
    "slides": lambda: (pin.buildModelFromXML(slider_above()), kinds("tip1", "tip2"), {}),
    "all joints": lambda: (all_kinds(), kinds("plate", "ground"), {}),
}


def from_mechanism(mechanism):
    return mechanism.model, mechanism.spec.loops, mechanism.parameters


def random_q(model, rng):
    return pin.integrate(model, pin.neutral(model), rng.normal(size=model.nv))


def moved(model, q, x, edges):
    """q with the unknowns' steps: slides along a joint's axes at q, rotation vectors."""
    q = q.copy()
    for edge in edges:
        joint = model.joints[edge.child]
        entries = q[joint.idx_q : joint.idx_q + joint.nq]
        step = x[joint.idx_v : joint.idx_v + joint.nv]
        match edge.kind:
            case "revolute" | "prismatic":
                entries += step
            case "continuous":
                entries[:] = turned(entries, step[0])
            case "planar":
                c, s = entries[2:]
                entries[:2] += np.array([[c, -s], [s, c]]) @ step[:2]
                entries[2:] = turned(entries[2:], step[2])
            case "spherical":
                entries[:] = (Rotation.from_quat(entries) * Rotation.from_rotvec(step)).as_quat()
            case "free":
                entries[:3] += Rotation.from_quat(entries[3:]).apply(step[:3])
                ball = Rotation.from_quat(entries[3:]) * Rotation.from_rotvec(step[3:])
                entries[3:] = ball.as_quat()
    return q


def turned(entries, angle):
    angle += np.arctan2(entries[1], entries[0])
    return np.cos(angle), np.sin(angle)


def residuals(model, loops, values, q):
    """The rows of each block as plain NumPy, in the last common body's axes."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    found = []
    for loop in loops:
        ids = [
            next(k for k, frame in enumerate(model.frames) if frame.name == name and frame.type & 8)
            for name in loop.frames
        ]
        trees = [list(model.supports[model.frames[k].parentJoint]) for k in ids]
        common = [a for a, b in zip(*trees, strict=False) if a == b][-1]
        one, other = (data.oMi[common].actInv(data.oMf[k]) for k in ids)
        found += rows_of(loop, values, one, other)
    return found


def rows_of(loop, values, one, other):
    gap = one.translation - other.translation
    Q = one.rotation @ other.rotation.T
    twist = pin.unSkew(Q - Q.T) / 2
    if isinstance(loop, pj.DistanceLoop):
        return [np.array([gap @ gap - loop.resolved_length(values) ** 2])]
    if isinstance(loop, pj.UniversalLoop):
        cosine = (one.rotation @ loop.axes[0]) @ (other.rotation @ loop.axes[1])
        return [gap, np.array([cosine])]
    if isinstance(loop, pj.FrameLoop):
        return [gap, twist]
    if isinstance(loop, pj.PointLoop | pj.SphericalLoop):
        return [gap]
    aside, axis = across(np.array(loop.axis)) @ other.rotation.T, np.array(loop.axis)
    tilt = aside @ one.rotation @ axis
    if isinstance(loop, pj.RevoluteLoop):
        return [gap, tilt]
    if isinstance(loop, pj.PlanarLoop):
        return [np.array([axis @ other.rotation.T @ gap]), tilt]
    return [aside @ gap, twist if isinstance(loop, pj.PrismaticLoop) else tilt]


@pytest.fixture(params=CASES)
def case(request):
    model, loops, values = CASES[request.param]()
    equations = LoopEquations(model, loops, values, range(model.nv))
    return model, loops, values, equations


@pytest.mark.slow
def test_residuals_and_jacobians_are_enclosed(case, rng):
    model, loops, values, equations = case
    edges = edges_of(model).values()
    for _ in range(3):
        q = random_q(model, rng)
        blocks = equations.enclosed(q)
        expected = residuals(model, loops, values, q)
        assert len(blocks) == len(expected)
        for k, (block, residual) in enumerate(zip(blocks, expected, strict=True)):
            np.testing.assert_allclose(middles(block.residual), residual, atol=1e-13)
            assert uppers(block.residual - middles(block.residual)).max() < 1e-12
            for column in range(model.nv):
                x = np.zeros(model.nv)
                x[column] = 1e-6
                ahead, behind = (
                    residuals(model, loops, values, moved(model, q, s * x, edges))[k]
                    for s in (1, -1)
                )
                slope = (ahead - behind) / 2e-6
                np.testing.assert_allclose(
                    middles(block.jacobian[:, column]), slope, atol=3e-9 * (1 + abs(slope).max())
                )


@pytest.mark.slow
def test_bends_bound_sampled_second_derivatives(case, rng):
    """At random poses up to r away; and no bound is so loose that it would be of no use."""
    model, loops, values, equations = case
    length, groups, edges = 0.7, equations.unknowns.groups, edges_of(model).values()
    unit = equations.unknowns.scale(length)
    closest = np.zeros(len(residuals(model, loops, values, pin.neutral(model))))
    for trial in range(20):
        q = random_q(model, rng)
        blocks = equations.enclosed(q)
        for _ in range(10):
            radius = 0.0 if trial % 2 else rng.uniform(0.0, 0.5)
            x, h = np.zeros(model.nv), np.zeros(model.nv)
            for group, size in zip(groups, unit, strict=True):
                away, step = rng.normal(size=(2, len(group.columns)))
                x[list(group.columns)] = radius * size * away / np.linalg.norm(away)
                h[list(group.columns)] = rng.choice([0.0, 1.0, rng.normal()]) * step
            steps = np.array([np.linalg.norm(h[list(group.columns)]) for group in groups])
            here = [
                residuals(model, loops, values, moved(model, q, x + s * STEP * h, edges))
                for s in (1, 0, -1)
            ]
            for k, (ahead, middle, behind) in enumerate(zip(*here, strict=True)):
                second = np.linalg.norm(ahead - 2 * middle + behind) / STEP**2
                bound = blocks[k].bend.bound(steps, unit, length)(radius)
                assert second <= bound + 1e-5 * (1 + steps @ steps) ** 2
                if bound > 1e-2:
                    closest[k] = max(closest[k], second / bound)
    assert closest.min() > 0.25, closest
