"""What must not depend on how a machine is written: where it stands, its units, frames, gears."""

from __future__ import annotations

from functools import cache

import numpy as np
import pinocchio as pin
import pytest
import transformed
from mechanisms import SAMPLE, loaded, mostly_slow
from random_machines import random_machine

import pmjac_pin as pj

NAMES = [name for name in pj.list_mechanisms() if name != "ur5"]
RANDOM = [
    pytest.param(f"random {seed}", marks=[pytest.mark.slow] if seed >= 5 else [])
    for seed in range(50)
]
TURN = pin.SE3(pin.exp3(np.array([0.4, -1.1, 0.7])), np.zeros(3))


def machine(name):
    if name.startswith("random "):
        return random_machine(int(name.split()[1]))
    return loaded(name)


def far(distance):
    direction = np.array([0.107, 0.994, -0.02])
    return pin.SE3(np.eye(3), distance * direction / np.linalg.norm(direction))


WAYS = {
    "1 km away": lambda m: transformed.moved(m, far(1e3)),
    "1e7 m away": lambda m: transformed.moved(m, far(1e7)),
    "turned": lambda m: transformed.moved(m, TURN),
    "turned and far": lambda m: transformed.moved(m, far(1e7) * TURN),
    "in mm": lambda m: transformed.scaled(m, 1e3),
    "in km": lambda m: transformed.scaled(m, 1e-3),
    "more frames": lambda m: transformed.with_frames(m, np.random.default_rng(3)),
    "fewer frames": transformed.with_needed_frames_only,
    "gears from the other side": transformed.geared_from_the_other_side,
}


def same_twist(way, J_eq, mechanism):
    """J_eq of the first machine, written as the second's would be."""
    J_eq = J_eq.copy()
    if "turned" in way:
        J_eq = np.vstack([TURN.rotation @ J_eq[:3], TURN.rotation @ J_eq[3:]])
    if way.startswith("in "):
        factor = 1e3 if way == "in mm" else 1e-3
        slides = np.array([mechanism.units[name] == "m" for name in mechanism.actuated])
        J_eq[:3] *= np.where(slides, 1.0, factor)
        J_eq[3:] *= np.where(slides, 1.0 / factor, 1.0)
    return J_eq


def target(mechanism, way, share):
    """Motor values away from home, as the second machine has them."""
    rng = np.random.default_rng(11)
    length = mechanism.characteristic_length
    slides = np.array([mechanism.units[name] == "m" for name in mechanism.actuated])
    size = np.where(slides, length, 1.0)
    natural = mechanism.problem.partition
    size = size * natural.column_scale[natural.actuated] / np.where(slides, 1.0, 1.0 / length)
    step = share * size * rng.uniform(-1.0, 1.0, slides.size)
    if way.startswith("in "):
        step = step * np.where(slides, 1e3 if way == "in mm" else 1e-3, 1.0)
    return step


def verdict(mechanism, step):
    """Where `close` ends, what it says, and J_eq."""
    try:
        pose = mechanism.close(mechanism.home.actuated + step, enforce_limits=False)
    except pj.ClosureError as error:
        return error.share, error.reached.singularity(), None
    return 1.0, pose.singularity(), pose.jacobian().J_eq


def compare_paths(mechanism, other, way=""):
    """`close` ends at the same places, with the same kind and the same J_eq."""
    rounding = max(1e-9, 100.0 * other.tolerance / other.characteristic_length)
    for share in (0.0, 0.1, 1.5):
        ended, pose, J_eq = verdict(mechanism, target(mechanism, "", share))
        its_end, its_pose, its_J_eq = verdict(other, target(mechanism, way, share))
        assert its_end == pytest.approx(ended, abs=1e-6 + (10.0 * rounding) ** 0.5)
        if min(ended, its_end) < 1.0:
            continue
        assert its_pose.kind == pose.kind
        expected = same_twist(way, J_eq, mechanism)
        # A block that vanishes is rounding beside the other one, by the machine's own length.
        length = other.characteristic_length
        linear, angular = (np.abs(rows).max() for rows in (expected[:3], expected[3:]))
        room = rounding * max(1.0, pose.condition) ** 2
        sizes = np.repeat([max(linear, angular * length), max(angular, linear / length)], 3)
        assert (np.abs(its_J_eq - expected) <= room * sizes[:, None]).all()


QUICK = ("turned and far", "in mm", "more frames", "gears from the other side")


def machines_and_ways():
    """Every machine of the catalogue written in every way; each random one in three of them."""
    for name in NAMES:
        for way in WAYS:
            quick = way in QUICK and name in SAMPLE
            yield pytest.param(name, way, marks=[] if quick else pytest.mark.slow)
    for seed in range(50):
        for way in list(WAYS)[seed % 3 :: 3]:
            quick = seed < 5 and way in QUICK
            yield pytest.param(f"random {seed}", way, marks=[] if quick else pytest.mark.slow)


@pytest.mark.parametrize(("name", "way"), list(machines_and_ways()))
def test_how_a_machine_is_written_changes_nothing(name, way):
    mechanism = machine(name)
    other = WAYS[way](mechanism)
    assert other.mobility == mechanism.mobility
    here, there = mechanism.home.singularity(), other.home.singularity()
    for what in ("rank", "generic_rank", "constraint_rank", "tool_rank", "kind", "idle"):
        assert getattr(here, what) == getattr(there, what), what
    np.testing.assert_allclose(there.smallest, here.smallest, rtol=1e-4)
    compare_paths(mechanism, other, way)


@pytest.mark.parametrize("name", [*mostly_slow(NAMES), *RANDOM])
def test_where_the_loops_are_cut_changes_nothing(name):
    mechanism = machine(name)
    for joint in mechanism.model.names[1:]:
        try:
            other = pj.recut(mechanism, joint)
        except pj.ArgumentError:  # in no loop
            continue
        here, there = mechanism.home.singularity(), other.home.singularity()
        # A distance cut elsewhere is a rod that spins.
        assert other.mobility - there.idle == mechanism.mobility - here.idle
        assert there.kind == here.kind
        compare_paths(mechanism, other)
        break


MODES = pj.list_mechanisms()
MODE_WAYS = ("1e7 m away", "turned", "turned and far", "in mm", "in km")
# A search of them takes seconds; each change of place and of units is in one of two ways.
LONG = ("agile_eye", "ankle", "delta", "sarrus", "stewart_gough_dietmaier")
QUICK_MODES = ("four_bar", "slider_crank", "five_bar", "bennett", "serial_2r")


def modes_and_ways():
    """Every machine of the catalogue written in every way; each random one in one of them."""
    for name in MODES:
        for way in MODE_WAYS if name not in LONG else ("turned and far", "in km"):
            quick = name in QUICK_MODES and way in QUICK
            yield pytest.param(name, way, marks=[] if quick else pytest.mark.slow)
    for seed in range(25):
        way = MODE_WAYS[seed // 5]  # each of the five kinds once in each
        yield pytest.param(f"random {seed}", way, marks=[] if seed in (4, 8) else pytest.mark.slow)


@cache
def modes_of(name, tolerance=None):
    """The modes at home; of the machine with this tolerance where one is given."""
    mechanism = machine(name)
    if tolerance is not None:
        mechanism = transformed.rebuilt(mechanism, tolerance=tolerance)
    return pj.assembly_modes(mechanism, mechanism.home.actuated, rng=0)


@pytest.mark.parametrize(("name", "way"), list(modes_and_ways()))
def test_how_many_modes_there_are_and_what_that_rests_on(name, way):
    """Beside the machine with the same tolerance: a proof is of poses that close to that."""
    other = WAYS[way](machine(name))
    tolerance = float(f"{other.tolerance:.2e}") if "far" in way or "away" in way else None
    here, there = modes_of(name, tolerance), pj.assembly_modes(other, other.home.actuated, rng=0)
    assert (len(there), there.ways) == (len(here), here.ways)
    assert there.evidence.kind == here.evidence.kind
