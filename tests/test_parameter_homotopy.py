"""All complex solutions, against counts that are known and against the assembly modes."""

from __future__ import annotations

import pickle

import mechanisms
import numpy as np
import pytest
from mechanisms import loaded
from test_modes import LECTURE_A, LECTURE_B, angles, same_sets

import pmjac_pin as pj


@pytest.fixture(scope="module")
def three_rps():
    return mechanisms.homotopy_of("three_rps_ss")


@pytest.fixture(scope="module")
def gough():
    return mechanisms.homotopy_of("stewart_gough_dietmaier")


@pytest.mark.parametrize(
    ("name", "count"),
    mechanisms.mostly_slow(
        [
            ("serial_2r", 1),
            ("four_bar", 2),
            ("slider_crank", 2),
            ("five_bar", 2),
            ("watt_six_bar", 4),
        ],
        [("serial_2r", 1), ("four_bar", 2), ("five_bar", 2)],
    ),
)
def test_small_mechanisms(name, count):
    mechanism = loaded(name)
    homotopy = mechanisms.homotopy_of(name)
    assert homotopy.count == count
    found = homotopy.at(mechanism.home.actuated)
    assert (found.count, found.certified, found.evidence.kind) == (count, count, "tolerance")
    modes = pj.assembly_modes(mechanism, mechanism.home.actuated, rng=0, limits=False)
    same_sets([mode.q for mode in found.real], [mode.q for mode in modes], 1e-8)


@pytest.mark.slow
def test_similar_triangles_have_fewer_solutions():
    """Six for a 3-RRR or 3-RPR; four at most where platform and base are similar."""
    assert pj.parameter_homotopy(loaded("planar_3rrr"), rng=0).count == 6
    similar = pj.parameter_homotopy(loaded("planar_3rpr"), rng=0)
    assert similar.count == 4
    found = similar.at([0.34, 0.34, 0.34])
    assert (found.count, found.at_infinity, found.singular) == (2, 2, 0)
    assert found.evidence.kind == "tolerance"


def test_out_of_reach_all_are_complex():
    found = pj.parameter_homotopy(mechanisms.rocker_rocker(), rng=0).at([2.5])
    assert (found.count, found.real, found.certified) == (2, (), 2)


@pytest.mark.slow
def test_where_two_modes_meet_it_says_so():
    """Coupler and rocker in line: one double solution, which no path reaches regularly."""
    mechanism = pj.load("four_bar", {"l0": 4.0, "l1": 1.0, "l2": 2.0, "l3": 3.0})
    found = pj.parameter_homotopy(mechanism, rng=0).at([np.pi])
    assert found.at_infinity == 0
    assert found.singular >= 1
    assert found.certified == 0
    assert found.evidence.kind == "nothing"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lengths", "expected", "atol"),
    [([2 / 3, 3 / 5, 3 / 4], LECTURE_A, 1e-8), ([0.5, 1.0, 2.0], LECTURE_B, 6e-5)],
)
def test_sixteen_of_the_3_rps(three_rps, lengths, expected, atol):
    """Its eliminant has degree 16: eight or four of the solutions are real at these lengths."""
    found = three_rps.at(lengths)
    assert (three_rps.count, found.count, found.certified) == (16, 16, 16)
    assert (found.at_infinity, found.singular, found.evidence.kind) == (0, 0, "tolerance")
    same_sets(angles(found.real), np.vstack([expected, -expected]), atol)


@pytest.mark.slow
def test_the_count_does_not_depend_on_the_cut_nor_on_the_seed():
    for name, seed in (("three_rps", 0), ("three_rps_ss", 1)):
        homotopy = mechanisms.homotopy_of(name, seed)
        found = homotopy.at([2 / 3, 3 / 5, 3 / 4])
        assert (homotopy.count, found.count, len(found.real)) == (16, 16, 8)


@pytest.mark.slow
def test_dietmaiers_forty_are_all_there_are(gough):
    found = gough.at(gough.mechanism.home.actuated)
    assert (gough.count, found.count, len(found.real), found.certified) == (40, 40, 40, 40)
    signs = [np.sign(mode.jacobian().det_K_star) for mode in found.real]
    assert (signs.count(1.0), signs.count(-1.0)) == (20, 20)


@pytest.mark.slow
def test_at_other_lengths_most_of_the_forty_are_complex(gough, rng):
    home = gough.mechanism.home.actuated
    found = gough.at(home * rng.uniform(0.9, 1.1, home.size))
    assert (found.count, found.certified) == (40, 40)
    modes = pj.assembly_modes(
        gough.mechanism, found.real[0].actuated, rng=0, limits=False, homotopy=gough
    )
    assert modes.evidence.kind == "tolerance"
    assert len(modes) == len(found.real) < 40


@pytest.mark.slow
def test_few_rounds_leave_a_bent_trace():
    homotopy = pj.parameter_homotopy(loaded("three_rps_ss"), rng=0, most_rounds=2)
    found = homotopy.at([1.0, 1.0, 1.1])
    assert homotopy.bend > 1e-6
    assert found.evidence.kind == "nothing"
    assert "solutions are missing" in str(found.evidence)


@pytest.mark.slow
def test_it_settles_what_a_short_search_leaves_open(gough):
    """Modes that the random starts did not meet are added."""
    mechanism = gough.mechanism
    theta = mechanism.home.actuated
    few = pj.assembly_modes(mechanism, theta, rng=0, limits=False, most_starts=1)
    assert (few.evidence.kind, len(few) < 40) == ("nothing", True)
    modes = pj.assembly_modes(mechanism, theta, rng=0, limits=False, most_starts=1, homotopy=gough)
    assert (modes.evidence.kind, len(modes), modes.starts) == ("tolerance", 40, 512)
    heights = [mode.tool_pose().translation[2] for mode in modes]
    assert heights == sorted(heights, reverse=True)


def limited_four_bar():
    """With a rocker that stays above the ground."""
    mechanism = loaded("four_bar")
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
    within = pj.assembly_modes(mechanism, theta, rng=0, homotopy=homotopy, proof=False)
    beyond = pj.assembly_modes(
        mechanism, theta, rng=0, homotopy=homotopy, proof=False, limits=False
    )
    assert within.evidence.kind == beyond.evidence.kind == "tolerance"
    assert (len(within), len(beyond), len(homotopy.at(theta).real)) == (1, 2, 2)


@pytest.mark.slow
def test_a_homotopy_of_another_mechanism_is_refused(three_rps):
    with pytest.raises(pj.ArgumentError, match="another mechanism"):
        pj.assembly_modes(loaded("four_bar"), [0.9], rng=0, homotopy=three_rps)


@pytest.mark.parametrize("values", [[1.0], [1.0, np.nan], "ab"])
def test_bad_motor_values(values):
    with pytest.raises(pj.ArgumentError):
        mechanisms.homotopy_of("five_bar").at(values)


@pytest.mark.parametrize(
    ("name", "count"),
    mechanisms.mostly_slow([("five_bar", 2), ("three_rps_ss", 16)], [("five_bar", 2)]),
)
def test_it_can_be_kept_in_a_file(name, count):
    kept = mechanisms.homotopy_of(name)
    again = pickle.loads(pickle.dumps(kept))
    motors = kept.mechanism.home.actuated + 0.05
    one, other = (homotopy.at(motors) for homotopy in (kept, again))
    assert one.count == other.count == count
    assert len(one.real) > 0
    same_sets([mode.q for mode in other.real], [mode.q for mode in one.real], 1e-12)
    assert f"{count} solutions" in repr(again)


def test_motors_that_cannot_move_one_by_one_are_refused():
    """All solutions would be at special motor values."""
    with pytest.raises(pj.ArgumentError, match="the loops forbid it"):
        pj.parameter_homotopy(mechanisms.over_actuated_four_bar(), rng=0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("four_bar",), "a Mechanism is wanted, got str"),
        ((loaded("four_bar"), 0), "most_rounds is a whole number ≥ 1, got 0"),
        ((loaded("four_bar"), 2.5), "most_rounds is a whole number ≥ 1, got 2.5"),
    ],
)
def test_bad_arguments(arguments, message):
    mechanism, *rounds = arguments
    with pytest.raises(pj.ArgumentError) as caught:
        pj.parameter_homotopy(mechanism, **({"most_rounds": rounds[0]} if rounds else {}))
    assert str(caught.value) == message


def test_what_is_no_homotopy_is_refused():
    with pytest.raises(pj.ArgumentError, match="or none at all"):
        pj.assembly_modes(loaded("four_bar"), [0.9], rng=0, homotopy=True)


@pytest.mark.slow
def test_the_solutions_solve_the_equations(three_rps):
    """The lecture's own: in the cosines and sines of the leg angles."""
    l1, l2, l3 = lengths = (2 / 3, 3 / 5, 3 / 4)
    found = three_rps.at(lengths)
    assert found.unknowns == tuple(f"{f} theta{k}" for k in (1, 2, 3) for f in ("cos", "sin"))
    c, s = found.solutions[:, ::2], found.solutions[:, 1::2]
    np.testing.assert_allclose(c * c + s * s, 1.0, atol=1e-9)
    for i, j, li, lj in ((0, 1, l1, l2), (1, 2, l2, l3), (2, 0, l3, l1)):
        turning = li * lj * (c[:, i] * c[:, j] - 2 * s[:, i] * s[:, j])
        rest = 3 - 3 / 4 + li**2 + lj**2 + turning - 3 * (li * c[:, i] + lj * c[:, j])
        np.testing.assert_allclose(rest, 0.0, atol=1e-8)
    real = np.abs(found.solutions.imag).max(axis=1) == 0.0
    assert real.sum() == len(found.real) == 8


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seed", "count"),
    [("three_rps_ss", 0, 16), ("three_rps_ss", 1, 16), ("delta_rods", 0, 28)],
)
def test_the_count_is_that_of_solutions_that_are_not_far_away(name, seed, count):
    """Rounded lengths bring some of infinity within reach: they do not count."""
    motors = loaded(name).home.actuated * 1.01
    assert mechanisms.homotopy_of(name, seed).at(motors).count == count
