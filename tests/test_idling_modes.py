"""What idles makes no modes of its own, and hides none: those inside an idling part count."""

from __future__ import annotations

import idling_machines
import numpy as np
import pinocchio as pin
import pytest
from mechanisms import loaded, mostly_slow
from test_same_machine import QUICKLY, THETA, rusr

import pmjac_pin as pj
from pmjac_pin.studies.modes import random_search
from pmjac_pin.studies.modes.recognition import Recognition

UPRIGHT = pin.SE3.Identity()
TILTED = pin.SE3(pin.exp3(np.array([0.4, -0.7, 1.1])), np.array([3.0, -1.0, 0.5]))
#: Crank angles, hinges and ends of the flap: the inner modes make legs of one length, or of two.
EQUAL = (0.0, np.array([2.0, 3.0, 0.0]), np.array([2.0, 0.3, 0.0]))


def standing(theta=0.5):
    """A leg that in one of its modes stands along the world's z, and in the others does not."""
    length = idling_machines._length(idling_machines._rocker_angles(theta)[1])
    hinge = np.array([1.0, 0.0, 0.5])
    return theta, hinge, np.array([0.0, 0.0, length]) - hinge


def leg(theta, hinge, end, placed):
    return idling_machines.leg_with_a_four_bar(hinge, end, theta, placed)


def angles_of(configuration):
    values = configuration.joint_values
    return np.array([values["rocker"], values["flap"]])


@pytest.mark.parametrize("seed", mostly_slow([0, 2], (0,)))
@pytest.mark.parametrize("placed", [UPRIGHT, TILTED], ids=["upright", "tilted"])
@pytest.mark.parametrize("case", [EQUAL, standing()], ids=["equal", "standing"])
def test_all_modes_of_a_leg_that_spins_count_once(case, placed, seed):
    mechanism, expected = leg(*case, placed)
    modes = pj.assembly_modes(mechanism, [case[0]], rng=seed, **QUICKLY)
    assert modes.evidence.kind == "statistics"
    assert modes.ways == (1,) * len(expected) == (1, 1, 1, 1)
    found = np.array([np.exp(1j * angles_of(mode)) for mode in modes])
    for angles in np.exp(1j * expected):
        assert np.abs(found - angles).max(axis=1).min() <= 1e-8


def test_modes_inside_a_leg_of_one_length_have_their_own_jacobians():
    mechanism, expected = leg(*EQUAL, UPRIGHT)
    modes = pj.assembly_modes(mechanism, [0.0], rng=0, **QUICKLY)
    rates = sorted(mode.jacobian().Jw_eq[1, 0] for mode in modes)
    np.testing.assert_allclose(np.array(rates) / rates[-1], [-1, -1, 1, 1], atol=1e-9)
    assert len(expected) == len(rates)


@pytest.mark.parametrize("placed", [UPRIGHT, TILTED], ids=["upright", "tilted"])
@pytest.mark.parametrize("case", [EQUAL, standing()], ids=["equal", "standing"])
def test_a_mode_is_known_however_far_it_has_idled(case, placed):
    mechanism, _ = leg(*case, placed)
    modes = pj.assembly_modes(mechanism, [case[0]], rng=0, **QUICKLY)
    recognition = Recognition(modes)
    for index, mode in enumerate(modes):
        line = idling_machines.frame_origin(mode, "leg_end") - placed.translation
        for angle in (1e-3, 2.0):
            spin = pin.exp3(angle * line / np.linalg.norm(line))
            turned = placed.rotation.T @ spin @ placed.rotation
            q = mode.q.copy()
            q[:4] = pin.Quaternion(turned @ pin.Quaternion(q[:4]).matrix()).coeffs()
            assert recognition.index(mechanism.configuration(q)) == index


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 1, 0), (0.48, 0.6, 0.64)])
@pytest.mark.parametrize("name", ["four_bar", pytest.param("watt_six_bar", marks=pytest.mark.slow)])
def test_an_idle_turntable_changes_no_count(name, axis):
    mechanism = loaded(name)
    theta = mechanism.home.actuated
    expected = pj.assembly_modes(mechanism, theta, rng=0)
    turning = idling_machines.on_a_turntable(mechanism, axis)
    assert turning.home.singularity().idle == 1
    for seed in (0, 1):
        modes = pj.assembly_modes(turning, theta, rng=seed, **QUICKLY)
        assert modes.ways == expected.ways
        inner = [np.exp(1j * np.array(mode.passive)[1:]) for mode in modes]
        order = [turning.passive[1:].index(joint) for joint in mechanism.passive]
        for mode in expected:
            apart = np.abs(np.array(inner)[:, order] - np.exp(1j * mode.passive)).max(axis=1)
            assert apart.min() <= 1e-8


def test_bodies_turned_over_unseen_are_so_on_a_turntable():
    still = rusr("rocker_tip")
    fixed = idling_machines.with_tool_at_rest(still.model, still)
    expected = pj.assembly_modes(fixed, THETA, rng=0, **QUICKLY)
    turning = idling_machines.on_a_turntable(still, (0.48, 0.6, 0.64))
    modes = pj.assembly_modes(turning, THETA, rng=0, **QUICKLY)
    assert modes.ways == expected.ways == (4, 4)


@pytest.mark.parametrize("seed", range(2))
def test_an_apex_between_legs_that_spin_is_on_either_side(seed):
    mechanism, theta, sides = idling_machines.tripod()
    modes = pj.assembly_modes(mechanism, theta, rng=seed, **QUICKLY)
    assert modes.ways == (1, 1)
    found = [idling_machines.frame_origin(mode, "tip0") for mode in modes]
    for side in sides:
        assert np.abs(np.array(found) - side).max(axis=1).min() <= 1e-9


def test_a_flap_that_comes_loose_is_no_mode_though_its_leg_always_spins(monkeypatch):
    monkeypatch.setattr(random_search, "_MOST_MODES", 100)
    mechanism, theta = idling_machines.flap_on_a_leg()
    assert len(pj.assembly_modes(mechanism, mechanism.home.actuated, rng=0, **QUICKLY)) == 2
    modes = pj.assembly_modes(mechanism, theta, rng=0, **QUICKLY)
    assert (len(modes), modes.evidence.kind) == (0, "nothing")
    assert "the loops also move with all motors locked" in str(modes.evidence)


@pytest.mark.parametrize("off", [1e-4, 1e-3])
def test_rounded_numbers_hide_no_modes(off):
    mechanism = idling_machines.four_bar_of_rounded_numbers(off)
    assert mechanism.home.singularity().idle == 1
    modes = pj.assembly_modes(mechanism, [0.9], rng=0, **QUICKLY)
    assert modes.ways == (1, 1)
