"""Enclosed loop equations and their derivatives around a pose, against independent formulas."""

from __future__ import annotations

import mechanisms
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded
from scipy.spatial.transform import Rotation
from test_linkage import BALL
from test_loops import LOOPS
from test_one_kinematics import middles

import pmjac_pin as pj
from pmjac_pin.algebra.balls import uppers
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.model.linkage import edges_of, with_spherical
from pmjac_pin.model.rows import across
from pmjac_pin.studies.certificates.equations import LoopEquations

LENGTH = 0.7  # m, of a unit of slides
RADII = np.array([0.0, 1e-6, 1e-3, 0.1, 0.5])


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


def fast_screw():
    """A screw across a hinge, whose slide is nearly all that moves."""
    model, aside = pin.Model(), pin.SE3(np.eye(3), np.array([0.01, 0.0, 0.02]))
    hinge = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "hinge")
    screw = model.addJoint(hinge, pin.JointModelHX(3.0), aside, "screw")
    for name, joint in (("ground", 0), ("nut", screw)):
        model.addFrame(pin.Frame(name, joint, aside, pin.FrameType.BODY))
    return model


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
    "four_bar": lambda: from_mechanism(loaded("four_bar")),
    "watt_six_bar": lambda: from_mechanism(loaded("watt_six_bar")),
    "three_rps": lambda: from_mechanism(loaded("three_rps")),
    "three_rps_ss": lambda: from_mechanism(loaded("three_rps_ss")),
    "rssr": lambda: from_mechanism(mechanisms.rssr()),
    "rssr as a distance": lambda: from_mechanism(mechanisms.rssr(rod=False)),
    "yawing four-bar": lambda: from_mechanism(mechanisms.yawing_four_bar()),
    "all loops of three_rps": lambda: (loaded("three_rps").model, LOOPS[:-1], {"a": 0.5}),
    "slides": lambda: (pin.buildModelFromXML(slider_above()), kinds("tip1", "tip2"), {}),
    "all joints": lambda: (all_kinds(), kinds("plate", "ground"), {}),
    "fast screw": lambda: (fast_screw(), kinds("nut", "ground"), {}),
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
        match edge.kind.name:
            case "revolute" | "prismatic" | "helical":
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
def test_steps_up_to_each_radius_change_the_rows_by_what_the_derivatives_allow(case, rng):
    """η(x) − η(0) ∈ J(X) x for |x| ≤ r; and no derivative is so wide that it would be of no use."""
    model, loops, values, equations = case
    edges = edges_of(model).values()
    groups, unit = equations.unknowns.groups, equations.unknowns.scale(LENGTH)
    closest = np.zeros(len(RADII))
    for trial in range(15):
        q = random_q(model, rng)
        at, here = equations.at(q), rows(model, loops, values, q)
        found, jacobian = equations.residual(at, q), equations.around(at, RADII, LENGTH).jacobian
        np.testing.assert_allclose(middles(found), here, atol=1e-13)
        assert uppers(found - middles(found)).max() < 1e-12
        assert jacobian[0].width.max() < 1e-11
        for place, radius in enumerate(RADII[1:].tolist(), 1):
            for _ in range(8):
                x = rng.normal(size=model.nv)
                for group in groups:
                    size = rng.choice([0.0, 1.0, rng.uniform()]) * radius
                    x[group > 0] *= size / np.linalg.norm(x[group > 0])
                if trial % 2:
                    x *= groups[rng.integers(len(groups))]
                allowed = (jacobian[place] * Intervals.exact(x)).sum(axis=1)
                change = rows(model, loops, values, moved(model, q, unit * x, edges)) - here
                assert np.all(allowed.widened(1e-13).holds(change))
                if allowed.magnitude.max() > 0.1 * radius:
                    share = (abs(change) / allowed.magnitude.max()).max()
                    closest[place] = max(closest[place], share)
    assert closest[1] > 0.999
    assert closest[2] > 0.9
    assert closest[3] > 0.2


def rows(model, loops, values, q):
    return np.concatenate(residuals(model, loops, values, q))
