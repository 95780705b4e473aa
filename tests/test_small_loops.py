"""Loops much smaller than the machine that they are in: all is as if they were as large."""

from __future__ import annotations

import math

import numpy as np
import pytest
from random_machines import Tree, at

import pmjac_pin as pj

LINKS = (4.0, 1.0, 3.0, 2.5)
ANGLE = 0.9
SIZES = [1e-3, 3e-6]


def corner_and_tip():
    l0, l1, l2, l3 = LINKS
    corner = l1 * np.array([math.cos(ANGLE), math.sin(ANGLE), 0.0])
    x, y = l0 - corner[0], -corner[1]
    reach = math.hypot(x, y)
    turn = math.atan2(y, x) + math.acos((l2**2 + reach**2 - l3**2) / (2 * l2 * reach))
    return corner, corner + l2 * np.array([math.cos(turn), math.sin(turn), 0.0])


def add_four_bar(tree, prefix, place, size, crank=None):
    """Add a four-bar of this size; return the bodies of its crank, coupler and rocker."""
    corner, tip = corner_and_tip()
    a = crank or tree.joint(0, f"{prefix}a", at(place))
    b = tree.joint(a, f"{prefix}b", at(place + size * corner))
    d = tree.joint(0, f"{prefix}d", at(place + size * np.array([LINKS[0], 0.0, 0.0])))
    for end, body in ((0, b), (1, d)):
        tree.frame(body, f"{prefix}{end}", at(place + size * tip))
    return a, b, d


def mechanism(tree, actuated):
    loops = [pj.PointLoop(frames=(f"{prefix}0", f"{prefix}1")) for prefix in ("large", "small")]
    return pj.Mechanism.from_pinocchio(tree.model, loops, actuated, "tool")


def side_by_side(size, motor="a"):
    """Two four-bars that have nothing to do with each other; the tool is on the small one."""
    tree, place = Tree(), np.array([1.0, 0.4, 0.0])
    add_four_bar(tree, "large", np.zeros(3), 1.0)
    _, coupler, _ = add_four_bar(tree, "small", place, size)
    tree.frame(coupler, "tool", at(place + size * corner_and_tip()[1]))
    return mechanism(tree, [f"large{motor}", f"small{motor}"])


def one_drives_the_other(size):
    """The small one's rocker is the crank of the large one, whose coupler carries the tool."""
    tree, place = Tree(), np.array([1.0, 0.4, 0.0])
    *_, rocker = add_four_bar(tree, "small", place, size)
    pivot = place + size * np.array([LINKS[0], 0.0, 0.0])
    _, coupler, _ = add_four_bar(tree, "large", pivot, 1.0, crank=rocker)
    tree.frame(coupler, "tool", at(pivot + corner_and_tip()[1]))
    return mechanism(tree, ["smalla"])


@pytest.mark.slow
@pytest.mark.parametrize("size", SIZES)
def test_a_small_loop_beside_a_large_one(size):
    alike, small = side_by_side(1.0), side_by_side(size)
    assert small.mobility == alike.mobility == 2
    target = alike.home.actuated + np.array([0.2, -0.3])
    expected, found = (m.close(target) for m in (alike, small))
    assert found.singularity().kind == "regular"
    np.testing.assert_allclose(found.q, expected.q, atol=1e-9)
    unit = np.repeat([[size], [1.0]], 3, axis=0)
    np.testing.assert_allclose(
        found.jacobian().J_eq / unit, expected.jacobian().J_eq, atol=1e-8, rtol=0
    )
    assert len(pj.assembly_modes(small, target, rng=0)) == 4


@pytest.mark.parametrize("size", SIZES)
def test_a_small_loop_that_drives_a_large_one(size):
    alike, small = one_drives_the_other(1.0), one_drives_the_other(size)
    assert small.mobility == alike.mobility == 1
    target = alike.home.actuated + 0.2
    expected, found = (m.close(target) for m in (alike, small))
    assert found.singularity().kind == "regular"
    np.testing.assert_allclose(found.q, expected.q, atol=1e-9)
    np.testing.assert_allclose(found.jacobian().J_eq, expected.jacobian().J_eq, atol=1e-8, rtol=0)


@pytest.mark.parametrize("size", SIZES)
def test_a_small_loop_stops_where_a_large_one_does(size):
    """The rocker as motor, until crank and coupler are in line."""
    stops = []
    for machine in (side_by_side(1.0, "d"), side_by_side(size, "d")):
        with pytest.raises(pj.ClosureError) as caught:
            machine.close(machine.home.actuated + np.array([0.0, 2.0]))
        stops.append(caught.value.reached.actuated)
    np.testing.assert_allclose(*stops, atol=1e-4)


@pytest.mark.parametrize(
    ("size", "code"), [(1e-4, "small-loop"), (1e-8, "loop-without-size"), (1.0, None)]
)
def test_check_says_by_what_a_loop_is_measured(size, code):
    findings = pj.check(one_drives_the_other(size)).findings
    codes = {finding.code for finding in findings} & {"small-loop", "loop-without-size"}
    assert codes == ({code} if code else set())
