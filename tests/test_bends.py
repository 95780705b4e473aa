"""Bounds on derivatives along curves, from lengths alone, against derivatives of sampled curves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded
from numpy.polynomial import Chebyshev
from test_certificate_rows import CASES, random_q, residuals

import pmjac_pin as pj
from pmjac_pin.closing.arms import Segment, _bounded_rows, arms_of
from pmjac_pin.closing.bends import Bends
from pmjac_pin.kinematics.loop_system import LoopSystem
from pmjac_pin.kinematics.pinocchio import Kinematics

STEP = 3e-4  # of central differences
NODES = 0.5 - 0.5 * np.cos(np.pi * (np.arange(15) + 0.5) / 15)


@pytest.fixture(params=[name for name in CASES if name != "all loops of three_rps"])
def case(request):
    return CASES[request.param]()


def rates(model, loops, values, q):
    """∂η/∂v by central differences, and η."""
    columns = []
    for v in STEP * np.eye(model.nv):
        ahead, behind = (
            np.concatenate(residuals(model, loops, values, pin.integrate(model, q, way)))
            for way in (v, -v)
        )
        columns.append((ahead - behind) / (2 * STEP))
    return np.array(columns).T, np.concatenate(residuals(model, loops, values, q))


def closed_rods(arms, model, loops, values, q):
    """The arms with each rod as long as the gap at q: all rods are closed where a path starts."""
    gaps = iter(residuals(model, loops, values, q))
    blocks = [
        block._replace(rod=float(np.sqrt(next(gaps)[0] + block.rod**2)))
        if block.rod
        else (next(gaps), block)[1]
        for block in arms.blocks
    ]
    return replace(arms, blocks=tuple(blocks))


def largest_derivative(samples, order):
    """Of a curve sampled at the nodes, over the whole of it: shape of one sample."""
    flat = np.array(samples).reshape(len(NODES), -1)
    s = np.linspace(0.0, 1.0, 41)
    fits = [Chebyshev.fit(NODES, column, 12, domain=[0, 1]) for column in flat.T]
    values = np.array([np.abs(fit.deriv(order)(s)).max() for fit in fits])
    return values.reshape(np.shape(samples)[1:])


@pytest.mark.slow
def test_no_derivative_along_a_cubic_curve_exceeds_its_bound(case, rng):
    """The fourth of η and the third of its rates; and a single joint nearly reaches them."""
    model, loops, values = case
    closest = 0.0
    for trial in range(6):
        q = random_q(model, rng)
        bends = Bends(closed_rods(arms_of(model, loops, values), model, loops, values, q))
        x = rng.normal(size=(3, model.nv)) * rng.choice([0.3, 1.0])
        x[1:] *= trial % 2  # straight ones, too
        if trial % 3 == 0:
            x *= np.eye(model.nv)[rng.integers(model.nv)]
        x[2] *= 0.3
        curve = [pin.integrate(model, q, s * (x[0] + s * (x[1] + s * x[2]))) for s in NODES]
        s = np.linspace(0.0, 1.0, 101)[:, None]
        speeds = np.array(
            [
                bends.speeds(way).max(axis=0)
                for way in (
                    x[0] + s * (2 * x[1] + s * 3 * x[2]),
                    2 * x[1] + 6 * s * x[2],
                    6 * x[2] + 0 * s,
                )
            ]
        )
        motion = bends.motion(q, speeds)
        found = [rates(model, loops, values, at) for at in curve]
        fourth = largest_derivative([residual for _, residual in found], 4)
        third = largest_derivative([jacobian for jacobian, _ in found], 3)
        noise = 1e-4 * (1.0 + speeds.sum() ** 4)
        assert (fourth <= bends.residual(motion) + noise).all()
        assert (third <= bends.rates(motion) + noise).all()
        shares = fourth / (bends.residual(motion) + 30 * noise)
        closest = max(closest, shares.max())
    assert closest > 0.05


@pytest.mark.slow
def test_no_derivative_along_a_straight_motion_exceeds_its_bound(case, rng):
    """The second of η and of its rates; and a single joint nearly reaches them."""
    model, loops, values = case
    closest = 0.0
    for trial in range(6):
        q = random_q(model, rng)
        bends = Bends(closed_rods(arms_of(model, loops, values), model, loops, values, q))
        way = rng.normal(size=model.nv) * rng.choice([0.3, 1.0])
        if trial % 3 == 0:
            way *= np.eye(model.nv)[rng.integers(model.nv)]
        motion = bends.straight(q, bends.speeds(way))
        found = [rates(model, loops, values, pin.integrate(model, q, s * way)) for s in NODES]
        of_rows = largest_derivative([residual for _, residual in found], 2)
        of_rates = largest_derivative([jacobian for jacobian, _ in found], 2)
        open_by, left_out = bends.bending(motion)
        noise = 1e-6 * (1.0 + np.abs(way).sum() ** 2)
        assert (of_rows <= open_by + noise).all()
        assert (of_rates <= left_out + noise).all()
        closest = max(closest, (of_rows / (open_by + 30 * noise)).max())
    assert closest > 0.05


def test_rates_change_no_more_than_bounded_within_a_reach(case, rng):
    model, loops, values = case
    for _ in range(6):
        q = random_q(model, rng)
        bends = Bends(closed_rods(arms_of(model, loops, values), model, loops, values, q))
        rest = bends.motion(q, np.zeros((3, bends.speeds(np.zeros(model.nv)).size)))
        reach = rng.exponential(size=model.nv) * rng.choice([0.01, 0.3])
        reach *= rng.random(model.nv) < 0.6
        away = pin.integrate(model, q, reach * rng.choice([-1.0, 1.0], size=model.nv))
        change = rates(model, loops, values, away)[0] - rates(model, loops, values, q)[0]
        assert (np.abs(change) <= bends.within(rest, reach) + 1e-6).all()


def test_rates_as_evaluated_off_closure_differ_by_the_gap_at_most(case, rng):
    """In the axes of the body that carries both ends of a loop."""
    model, loops, values = case
    for loop in loops:
        closure = Kinematics(model, LoopSystem(model, [loop], values), None).closure
        bends = Bends(arms_of(model, [loop], values))
        q = random_q(model, rng)
        for _ in range(20):
            residual, jacobian = closure(q)
            step = np.linalg.lstsq(jacobian, -residual, rcond=1e-6)[0]
            q = pin.integrate(model, q, step / max(1.0, np.linalg.norm(step)))
        if np.linalg.norm(closure(q)[0]) > 1e-9:
            continue
        for size in (1e-3, 0.03):
            away = pin.integrate(model, q, size * rng.normal(size=model.nv))
            residual, jacobian = closure(away)
            exact, _ = rates(model, [loop], values, away)
            allowed = bends.off_closure * bends.block_norms(residual)[:, None]
            assert (np.abs(jacobian - exact) <= 1.1 * allowed + 1e-6).all()


def test_loops_with_joints_that_are_not_known_are_followed_all_the_same():
    """A four-bar with a composite joint: named by the arms, judged by what is measured alone."""
    four_bar = loaded("four_bar")
    model = four_bar.model.copy()
    nothing = np.full(1, np.inf)
    joint = pin.JointModelComposite(pin.JointModelRZ())
    model.addJoint(0, joint, pin.SE3.Identity(), "own", nothing, nothing, -nothing, nothing)
    with pytest.raises(pj.ArgumentError, match=r"'own' is a JointModelComposite, .*: revolute"):
        arms_of(model, four_bar.spec.loops, {})
    motors = [*four_bar.actuated, "own"]
    home = [*four_bar.home.q, 0.0]
    mechanism = pj.Mechanism.from_pinocchio(
        model, four_bar.spec.loops, motors, "coupler_midpoint", home=home
    )
    reached = mechanism.close([1.4, 0.3])
    expected = four_bar.close([1.4])
    np.testing.assert_allclose(reached.passive, expected.passive, atol=1e-12)


def test_rows_that_are_not_known_are_not_bounded():
    class Unknown:
        names, measures = ("x",), "colours"

    with pytest.raises(pj.ArgumentError, match="rows of Unknown: how they bend is not known here"):
        _bounded_rows(Unknown(), [Segment((), 1.0)], [Segment((), 1.0)])
