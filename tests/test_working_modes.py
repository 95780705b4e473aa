"""All motor values that put a tool at a target: as many, and where, as formulas say."""

from __future__ import annotations

import hand_reach as hand
import hand_spatial as spatial
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import CATALOGUE, loaded, mostly_slow, random_closed

import pmjac_pin as pj

# Of each way in which modes are found one: by legs, by boxes, in a plane and in space.
QUICK = ("bennett", "humanoid_ankle", "three_rps")


def same_rows(found, expected, atol):
    """Whether two sets of angles are the same, full turns aside."""
    assert found.shape == expected.shape
    turned = np.exp(1j * found)[:, None] - np.exp(1j * expected)[None]
    apart = np.abs(turned).max(axis=2)
    assert apart.min(axis=1).max() < atol
    assert apart.min(axis=0).max() < atol


def at_target(modes, mechanism, target):
    for mode in modes:
        assert mode.mechanism is mechanism
        assert mode.residual_norm <= mechanism.tolerance
        miss = target.actInv(mode.tool_pose())
        assert np.linalg.norm(pin.log6(miss).vector) < 1e-9


def test_a_five_bar_has_four(rng):
    mechanism = loaded("five_bar")
    for pose in random_closed(mechanism, rng, 1):
        tip = pose.tool_pose().translation
        modes = pj.working_modes(mechanism, tip, rng=0)
        angles = hand.five_bar_angles(tip[:2], *mechanism.parameters.values())
        same_rows(modes.actuated, hand.combinations(angles), 1e-9)
        assert modes.evidence.kind == "proof"


def test_a_planar_3rrr_has_eight(rng):
    mechanism = loaded("planar_3rrr")
    [pose] = random_closed(mechanism, rng, 1)
    modes = pj.working_modes(mechanism, pose.tool_pose(), rng=0)
    assert len(modes) == 8
    assert modes.evidence.kind == "proof"
    at_target(modes, mechanism, pose.tool_pose())


@pytest.mark.parametrize("name", ["delta_rods", pytest.param("delta", marks=pytest.mark.slow)])
def test_a_delta_has_eight(name, rng):
    mechanism = loaded(name)
    [pose] = random_closed(mechanism, rng, 1)
    target = pose.tool_pose()
    modes = pj.working_modes(mechanism, target, rng=0, limits=False)
    angles = hand.delta_angles(target.translation + 0.065 * spatial.Z)
    same_rows(modes.actuated, hand.combinations(angles), 1e-9)
    at_target(modes, mechanism, target)


def test_a_head_on_six_cranks_has_sixty_four(rng):
    mechanism = loaded("head_6rss")
    for pose in (mechanism.home, *random_closed(mechanism, rng, 1, 0.1)):
        target = pose.tool_pose()
        modes = pj.working_modes(mechanism, target, rng=0, limits=False)
        angles = hand.head_angles(target.translation, target.rotation)
        same_rows(modes.actuated, hand.combinations(angles), 1e-9)
        assert modes.evidence.kind == "proof"
        at_target(modes, mechanism, target)


def test_a_corner_of_the_plate_tells_as_much_as_its_middle(rng):
    mechanism = loaded("planar_3rrr")
    [pose] = random_closed(mechanism, rng, 1, 0.1)
    of_plate = pj.working_modes(mechanism, pose.tool_pose(), rng=0)
    of_corner = pj.working_modes(mechanism, pose.tool_pose("P1"), tool="P1", rng=0)
    same_rows(of_corner.actuated, of_plate.actuated, 1e-9)
    assert of_corner.evidence.kind == "proof"


def test_within_limits_a_head_has_fewer():
    mechanism = loaded("head_6rss")
    modes = pj.working_modes(mechanism, mechanism.home.tool_pose(), rng=0)
    np.testing.assert_allclose(modes.actuated, [mechanism.home.actuated], atol=1e-9)


def test_a_stewart_gough_platform_has_one(rng):
    mechanism = loaded("stewart_gough")
    [pose] = random_closed(mechanism, rng, 1, 0.1)
    modes = pj.working_modes(mechanism, pose.tool_pose(), rng=0)
    np.testing.assert_allclose(modes.actuated, [pose.actuated], atol=1e-9)
    assert modes.evidence.kind == "proof"


@pytest.mark.slow
def test_a_ur5_has_eight(rng):
    mechanism = loaded("ur5")
    target = mechanism.home.tool_pose()
    modes = pj.working_modes(mechanism, target, rng=0, limits=False)
    expected = hand.ur5_angles(target.homogeneous)
    assert len(expected) == 8
    same_rows(modes.actuated, expected, 1e-8)
    at_target(modes, mechanism, target)


def test_an_arm_of_two_links_has_two(rng):
    mechanism = loaded("serial_2r")
    [pose] = random_closed(mechanism, rng, 1, 0.5)
    modes = pj.working_modes(mechanism, pose.tool_pose().translation, rng=0)
    l1, l2 = mechanism.parameters.values()
    x, y, _ = pose.tool_pose().translation
    bend = np.arccos((x * x + y * y - l1**2 - l2**2) / (2 * l1 * l2))
    by_hand = [
        [np.arctan2(y, x) - np.arctan2(l2 * np.sin(q), l1 + l2 * np.cos(q)), q]
        for q in (bend, -bend)
    ]
    same_rows(modes.actuated, np.array(by_hand), 1e-9)


@pytest.mark.parametrize("name", mostly_slow(CATALOGUE, QUICK))
def test_where_a_pose_came_from_is_among_them(name, rng):
    mechanism = loaded(name)
    [pose] = random_closed(mechanism, rng, 1, 0.1)
    modes = pj.working_modes(mechanism, pose.tool_pose(), rng=0)
    turns = np.array([mechanism.units[one] == "rad" for one in mechanism.actuated])
    apart = np.abs(modes.actuated - pose.actuated)
    apart = np.where(turns, np.abs(np.exp(1j * modes.actuated) - np.exp(1j * pose.actuated)), apart)
    assert apart.max(axis=1).min() < 1e-9


def test_a_target_that_nothing_meets_has_none():
    mechanism = loaded("five_bar")
    modes = pj.working_modes(mechanism, [2.0, 0.0, 0.0], rng=0)
    assert not len(modes)
    assert modes.evidence.kind == "proof"


def test_freedom_that_is_left_is_no_mode():
    with pytest.raises(pj.ArgumentError, match="leaves the machine freedom"):
        pj.working_modes(loaded("ur5"), [0.4, 0.2, 0.3])
