"""Models with rounded numbers: which tolerance would do is said wherever it is met."""

from __future__ import annotations

import re

import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded, mostly_slow
from transformed import scaled

import pmjac_pin as pj

OVERCONSTRAINED = ("bennett", "bricard", "sarrus", "slider_crank", "four_bar", "planar_3rpr")


def rounded(name, size, tolerance=None, seed=0, scale=1.0):
    """Return a machine whose axes are tilted at random, but for home, which stays closed."""
    machine = scaled(loaded(name), scale)
    model, rng = machine.model, np.random.default_rng(seed)
    for joint in range(1, model.njoints):
        if model.names[joint] in machine.actuated:
            continue
        tilt = pin.SE3(pin.exp3(size * rng.normal(size=3)), np.zeros(3))
        model.jointPlacements[joint] = model.jointPlacements[joint] * tilt
    spec = machine.spec
    return pj.Mechanism.from_pinocchio(
        model,
        spec.loops,
        spec.actuated,
        spec.tool.frame or spec.tool.points,
        home=machine.home.q,
        name=name,
        tolerance=tolerance,
    )


@pytest.mark.parametrize(
    ("name", "scale"),
    mostly_slow(
        [(name, scale) for name in OVERCONSTRAINED for scale in (1.0, 1e-3, 1e4)],
        [*((name, 1.0) for name in OVERCONSTRAINED), ("bennett", 1e-3), ("four_bar", 1e4)],
    ),
)
def test_the_tolerance_that_is_named_does(name, scale):
    """A few questions and answers lead to a machine that closes, whatever its size."""
    machine = scaled(loaded(name), scale)
    slides = np.array([machine.units[motor] == "m" for motor in machine.actuated])
    target = machine.home.actuated + 0.05 * np.where(slides, scale, 1.0)
    tolerance = None
    for _ in range(5):
        try:
            closed = rounded(name, 1e-8, tolerance, scale=scale).close(target)
        except pj.ClosureError as error:
            named = re.search(r"a `tolerance` of (\S+) where numbers are rounded", str(error))
            assert named, str(error)
            assert tolerance is None or float(named[1]) > tolerance
            tolerance = float(named[1])
        else:
            assert closed.residual_norm <= closed.mechanism.tolerance <= 1e-5 * scale
            return
    pytest.fail("no tolerance was enough")


def one_axis(tolerance=None, tilt=2e-8):
    """A four-bar that closes exactly at home, and whose rod is tilted elsewhere, rad."""
    machine = loaded("four_bar")
    model, home = machine.model, machine.home.q
    joint = model.getJointId("phi2")
    angle = home[model.joints[joint].idx_q]
    turn = pin.SE3(pin.exp3(np.array([0.0, 0.0, angle])), np.zeros(3))
    tilt = pin.SE3(pin.exp3(np.array([tilt, 0.5 * tilt, 0.0])), np.zeros(3))
    place = model.jointPlacements[joint]
    # Tilted about its own axis's pose at home, and the body behind it back again.
    model.jointPlacements[joint] = place * tilt
    back = turn.inverse() * tilt.inverse() * turn
    for frame in model.frames:
        if frame.parentJoint == joint:
            frame.placement = back * frame.placement
    spec = machine.spec
    return pj.Mechanism.from_pinocchio(
        model, spec.loops, spec.actuated, spec.tool.frame, home=home, tolerance=tolerance
    )


def test_close_and_check_name_it_where_home_closes():
    machine = one_axis()
    with pytest.raises(pj.ClosureError, match=r"`tolerance` of 1e-0[78] where numbers are rounded"):
        machine.close(machine.home.actuated + 0.3)
    [found] = [f for f in pj.check(machine).findings if f.code == "rounded-numbers"]
    assert found.severity in ("warning", "error")
    assert "isolated" not in [f.code for f in pj.check(machine).findings]
    assert "a `tolerance` of 1e-0" in found.advice
    better = one_axis(1e-7)
    assert better.close(better.home.actuated + 0.3).residual_norm < 1e-7
    assert "rounded-numbers" not in [f.code for f in pj.check(better).findings]


@pytest.mark.parametrize("name", ["four_bar", "bennett", "delta", "three_rps", "planar_3rpr"])
def test_exact_machines_are_not_suspected(name):
    assert pj.check(name).rounding is None


def test_far_out_of_reach_is_no_rounding():
    rocker = pj.load("four_bar", parameters={"l0": 4.0, "l1": 3.0, "l2": 2.5, "l3": 2.0})
    with pytest.raises(pj.ClosureError, match="out of reach from here") as caught:
        rocker.close([1.5])
    assert "tolerance`" not in str(caught.value)


@pytest.mark.parametrize(
    "tilt", mostly_slow([1e-13, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4], (1e-13, 1e-10, 1e-7))
)
def test_everything_says_which_tolerance_would_do(tilt):
    """Modes, close and check of one machine agree: closed, or open for want of a tolerance."""
    machine = one_axis(tilt=tilt)
    target = machine.home.actuated + 0.3
    modes = pj.assembly_modes(machine, target, rng=0)
    if tilt == 1e-13:
        assert (len(modes), modes.evidence.kind) == (2, "proof")
        machine.close(target)
        return
    assert modes.evidence.kind == "nothing"
    assert len(modes) < 2
    named = re.search(r"a `tolerance` of (\S+) where numbers are rounded", str(modes.evidence))
    assert named, str(modes.evidence)
    with pytest.raises(pj.ClosureError, match=r"a `tolerance` of \S+ where numbers") as caught:
        machine.close(target)
    assert "other motors" not in str(caught.value)
    codes = [finding.code for finding in pj.check(machine).findings]
    assert "rounded-numbers" in codes
    tolerant = one_axis(10.0 * float(named[1]), tilt)
    found = pj.assembly_modes(tolerant, target, rng=0)
    assert len(found) == 2
    assert found.evidence.kind != "nothing"
    assert tolerant.close(target).residual_norm <= tolerant.tolerance


@pytest.mark.parametrize("beyond", [1e-2, 1e-4, 1e-6, 1e-9])
def test_beyond_a_fold_no_mode_is_missing(beyond):
    """A small gap alone says nothing: there the motor's value is out of reach."""
    lengths = {"l0": 4.0, "l1": 3.0, "l2": 2.5, "l3": 2.0}
    rocker = pj.load("four_bar", parameters=lengths)
    fold = np.arccos((16.0 + 9.0 - 4.5**2) / 24.0)
    modes = pj.assembly_modes(rocker, [fold + beyond], rng=0, limits=False)
    assert (len(modes), modes.evidence.kind) == (0, "proof")
