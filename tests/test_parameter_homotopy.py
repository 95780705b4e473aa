"""All complex solutions, against counts that are known and against the assembly modes."""

from __future__ import annotations

import pickle

import mechanisms
import numpy as np
import pytest
from test_modes import LECTURE_A, LECTURE_B, angles, same_sets

import pmjac_pin as pj


@pytest.fixture(scope="module")
def three_rps():
    return pj.parameter_homotopy(pj.load("three_rps_ss"), rng=0)


@pytest.fixture(scope="module")
def gough():
    return pj.parameter_homotopy(pj.load("stewart_gough_dietmaier"), rng=0)


@pytest.mark.parametrize(
    ("name", "count"),
    [("serial_2r", 1), ("four_bar", 2), ("slider_crank", 2), ("five_bar", 2), ("watt_six_bar", 4)],
)
def test_small_mechanisms(name, count):
    mechanism = pj.load(name)
    homotopy = pj.parameter_homotopy(mechanism, rng=0)
    assert homotopy.count == count
    found = homotopy.at(mechanism.home.actuated)
    assert (found.count, found.certified, found.complete.kind) == (count, count, "tolerance")
    modes = mechanism.assembly_modes(mechanism.home.actuated, rng=0, limits=False)
    same_sets([mode.q for mode in found.real], [mode.q for mode in modes], 1e-8)


def test_similar_triangles_have_fewer_solutions():
    """Six for a 3-RRR or 3-RPR; four at most where platform and base are similar."""
    assert pj.parameter_homotopy(pj.load("planar_3rrr"), rng=0).count == 6
    similar = pj.parameter_homotopy(pj.load("planar_3rpr"), rng=0)
    assert similar.count == 4
    found = similar.at([0.34, 0.34, 0.34])
    assert (found.count, found.at_infinity, found.singular) == (2, 2, 0)
    assert found.complete.kind == "tolerance"


def test_out_of_reach_all_are_complex():
    found = pj.parameter_homotopy(mechanisms.rocker_rocker(), rng=0).at([2.5])
    assert (found.count, found.real, found.certified) == (2, (), 2)


def test_where_two_modes_meet_it_says_so():
    """Coupler and rocker in line: one double solution, which no path reaches regularly."""
    mechanism = pj.load("four_bar", {"l0": 4.0, "l1": 1.0, "l2": 2.0, "l3": 3.0})
    found = pj.parameter_homotopy(mechanism, rng=0).at([np.pi])
    assert found.at_infinity == 0
    assert found.singular >= 1
    assert found.certified == 0
    assert found.complete.kind == "neither"


@pytest.mark.parametrize(
    ("lengths", "expected", "atol"),
    [([2 / 3, 3 / 5, 3 / 4], LECTURE_A, 1e-8), ([0.5, 1.0, 2.0], LECTURE_B, 6e-5)],
)
def test_sixteen_of_the_3_rps(three_rps, lengths, expected, atol):
    """Its eliminant has degree 16: eight or four of the solutions are real at these lengths."""
    found = three_rps.at(lengths)
    assert (three_rps.count, found.count, found.certified) == (16, 16, 16)
    assert (found.at_infinity, found.singular, found.complete.kind) == (0, 0, "tolerance")
    same_sets(angles(found.real), np.vstack([expected, -expected]), atol)


@pytest.mark.slow
def test_the_count_does_not_depend_on_the_cut_nor_on_the_seed(three_rps):
    for mechanism, seed in ((pj.load("three_rps"), 0), (three_rps.mechanism, 1)):
        homotopy = pj.parameter_homotopy(mechanism, rng=seed)
        found = homotopy.at([2 / 3, 3 / 5, 3 / 4])
        assert (homotopy.count, found.count, len(found.real)) == (16, 16, 8)


def test_dietmaiers_forty_are_all_there_are(gough):
    found = gough.at(gough.mechanism.home.actuated)
    assert (gough.count, found.count, len(found.real), found.certified) == (40, 40, 40, 40)
    signs = [np.sign(mode.jacobian().det_K_star) for mode in found.real]
    assert (signs.count(1.0), signs.count(-1.0)) == (20, 20)


def test_at_other_lengths_most_of_the_forty_are_complex(gough, rng):
    home = gough.mechanism.home.actuated
    found = gough.at(home * rng.uniform(0.9, 1.1, home.size))
    assert (found.count, found.certified) == (40, 40)
    modes = gough.mechanism.assembly_modes(
        found.real[0].actuated, rng=0, limits=False, homotopy=gough
    )
    assert modes.complete.kind == "tolerance"
    assert len(modes) == len(found.real) < 40


def test_few_rounds_leave_a_bent_trace():
    homotopy = pj.parameter_homotopy(pj.load("three_rps_ss"), rng=0, most_rounds=2)
    found = homotopy.at([1.0, 1.0, 1.1])
    assert homotopy.bend > 1e-6
    assert found.complete.kind == "neither"
    assert "solutions are missing" in str(found.complete)


def test_it_settles_what_a_short_search_leaves_open(gough):
    """Modes that the random starts did not meet are added."""
    mechanism = gough.mechanism
    theta = mechanism.home.actuated
    few = mechanism.assembly_modes(theta, rng=0, limits=False, most_starts=1)
    assert (few.complete.kind, len(few) < 40) == ("neither", True)
    modes = mechanism.assembly_modes(theta, rng=0, limits=False, most_starts=1, homotopy=gough)
    assert (modes.complete.kind, len(modes), modes.starts) == ("tolerance", 40, 512)
    heights = [mode.tool_pose.translation[2] for mode in modes]
    assert heights == sorted(heights, reverse=True)


def limited_four_bar():
    """With a rocker that stays above the ground."""
    mechanism = pj.load("four_bar")
    model = mechanism.model
    entry = model.joints[model.getJointId("phi1")].idx_q
    model.lowerPositionLimit[entry], model.upperPositionLimit[entry] = 0.0, np.pi
    loops = [pj.PointLoop(frames=("coupler_tip", "rocker_tip"))]
    return pj.Mechanism.from_pinocchio(
        model, loops, ["theta1"], "coupler_midpoint", home=mechanism.home.joint_values
    )


def test_limits_leave_solutions_out():
    mechanism = limited_four_bar()
    homotopy = pj.parameter_homotopy(mechanism, rng=0)
    theta = [0.9]
    within = mechanism.assembly_modes(theta, rng=0, homotopy=homotopy, proof=False)
    beyond = mechanism.assembly_modes(theta, rng=0, homotopy=homotopy, proof=False, limits=False)
    assert within.complete.kind == beyond.complete.kind == "tolerance"
    assert (len(within), len(beyond), len(homotopy.at(theta).real)) == (1, 2, 2)


def test_a_homotopy_of_another_mechanism_is_refused(three_rps):
    with pytest.raises(pj.ArgumentError, match="that of another mechanism"):
        pj.load("four_bar").assembly_modes([0.9], rng=0, homotopy=three_rps)


@pytest.mark.parametrize("values", [[1.0], [1.0, np.nan, 1.0], "abc"])
def test_bad_motor_values(three_rps, values):
    with pytest.raises(pj.ArgumentError):
        three_rps.at(values)


def test_it_can_be_kept_in_a_file(three_rps):
    again = pickle.loads(pickle.dumps(three_rps))
    one, other = (homotopy.at([0.9, 1.0, 1.1]) for homotopy in (three_rps, again))
    assert one.count == other.count
    np.testing.assert_allclose(angles(other.real), angles(one.real), atol=1e-12)
    assert "16 solutions" in repr(again)
