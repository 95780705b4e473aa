"""One tolerance: what `close` calls closed and regular, searches, proofs and homotopies do, too."""

from __future__ import annotations

from functools import cache

import numpy as np
import pinocchio as pin
import pytest
import transformed
from mechanisms import loaded

import pmjac_pin as pj

TILT, TOLERANCE = 3e-5, 1e-4  # rad, m
JOINTS = {
    "four_bar": "phi2",
    "slider_crank": "beta",
    "five_bar": "phi1",
    "watt_six_bar": "B",
    "planar_3rpr": "theta1",
    "planar_3rrr": "phi1",
    "bennett": "theta2",
}
QUICK = ("four_bar", "slider_crank", "five_bar")


def tilted(name):
    """The machine with one hinge tilted, which its tolerance lets pass."""
    exact = loaded(name)
    model = exact.model
    joint = model.getJointId(JOINTS[name])
    turn = pin.SE3(pin.exp3(TILT * np.array([1.0, 0.33, 0.0])), np.zeros(3))
    model.jointPlacements[joint] = model.jointPlacements[joint] * turn
    spec = exact.spec
    other = pj.Mechanism.from_pinocchio(
        model,
        transformed.resolved(exact),
        spec.actuated,
        spec.tool.frame,
        passive=spec.passive,
        home=exact.home.q,
        tolerance=TOLERANCE,
    )
    return exact, other


def same_place(one, other, room):
    difference = one.tool_pose().homogeneous - other.tool_pose().homogeneous
    return np.abs(difference).max() <= room


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[] if name in QUICK else pytest.mark.slow) for name in JOINTS],
)
def test_a_machine_with_a_tolerance_has_the_modes_of_the_exact_one(name):
    exact, mechanism = tilted(name)
    motors = exact.home.actuated
    expected = pj.assembly_modes(exact, motors, rng=0, limits=False)
    modes = pj.assembly_modes(mechanism, motors, rng=0, limits=False, proof=False)
    assert len(modes) == len(expected)
    room = 100.0 * TOLERANCE
    for mode in expected:
        assert any(same_place(mode, found, room) for found in modes)
    for mode in modes:
        again = mechanism.configuration(mode.q)
        assert again.singularity().kind == mode.singularity().kind == "regular"
    reached = mechanism.close(motors + 1e-3, guess=mechanism.home)
    back = mechanism.close(motors, guess=reached)
    assert any(same_place(back, found, 20.0 * TOLERANCE) for found in modes)


@pytest.mark.parametrize("name", QUICK)
def test_a_proof_under_a_tolerance_never_counts_otherwise(name):
    exact, mechanism = tilted(name)
    motors = exact.home.actuated
    proof = pj.prove(mechanism, motors, limits=False, budget=pj.Budget(boxes=1500))
    count = len(pj.assembly_modes(exact, motors, rng=0, limits=False))
    assert not proof or len(proof.q) == count


def test_a_homotopy_under_a_tolerance_finds_what_close_reaches():
    _, mechanism = tilted("four_bar")
    homotopy = pj.parameter_homotopy(mechanism, rng=0)
    found = homotopy.at([0.9])
    assert len(found.real) == 2
    modes = pj.assembly_modes(mechanism, [0.9], rng=0, proof=False, homotopy=homotopy)
    assert len(modes) == 2
    assert any(same_place(mechanism.close([0.9]), mode, 20.0 * TOLERANCE) for mode in modes)


def fold(mechanism):
    """Motor values at which this mode ends while the first motor turns on: by bisection."""
    home, first = mechanism.home, np.eye(len(mechanism.actuated))[0]
    near, far = 0.0, 4.0
    while far - near > 1e-10:
        middle = 0.5 * (near + far)
        try:
            mechanism.close(home.actuated + middle * first, guess=home, enforce_limits=False)
            near = middle
        except pj.ClosureError:
            far = middle
    return home.actuated + far * first, first


@pytest.mark.parametrize("name", ["five_bar", pytest.param("planar_3rrr", marks=pytest.mark.slow)])
def test_a_fold_that_is_missed_by_less_than_the_tolerance_is_no_crowd_of_modes(name):
    """Beyond the fold at most one pose nearly closes where two met; it is singular."""
    exact = loaded(name)
    end, first = fold(exact)
    spec = exact.spec
    mechanism = pj.Mechanism.from_pinocchio(
        exact.model,
        transformed.resolved(exact),
        spec.actuated,
        spec.tool.frame,
        passive=spec.passive,
        home=exact.home.q,
        tolerance=TOLERANCE,
    )

    def modes(beyond):
        motors = end + beyond * first
        return pj.assembly_modes(mechanism, motors, rng=0, limits=False, proof=False)

    before = len(modes(-1e-3))
    assert before >= 2
    for beyond in (1e-8, 1e-6, 1e-5):
        assert len(modes(beyond)) <= before - 1


PLACES = {
    "1 km away": pin.SE3(np.eye(3), np.array([1000.0, 300.0, 0.0])),
    "1e7 m away": pin.SE3(np.eye(3), np.array([1e7, 3e6, 0.0])),
    "turned": pin.SE3(pin.exp3(np.array([0.4, -1.1, 0.7])), np.zeros(3)),
}
COUNTED = ("four_bar", "five_bar", "three_rps", "planar_3rpr", "delta_rods")


def count(mechanism):
    motors = mechanism.home.actuated
    return len(pj.assembly_modes(mechanism, motors, rng=0, limits=False, proof=False))


@cache
def count_of(name):
    return count(loaded(name))


@pytest.mark.parametrize("way", [*PLACES, "in mm", "in km"])
@pytest.mark.parametrize(
    "name",
    [
        *COUNTED[:2],
        *(
            pytest.param(n, marks=pytest.mark.slow)
            for n in (*COUNTED[2:], "stewart_gough_dietmaier")
        ),
    ],
)
def test_how_many_modes_there_are_does_not_depend_on_how_a_machine_is_written(name, way):
    mechanism = loaded(name)
    if way in PLACES:
        other = transformed.moved(mechanism, PLACES[way])
    else:
        other = transformed.scaled(mechanism, 1e3 if way == "in mm" else 1e-3)
    assert count(other) == count_of(name)
