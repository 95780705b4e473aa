"""Loci in slices of motor space, against closed equations that know no Jacobian."""

import numpy as np
import pytest
from locus_machines import BASE, cuspidal_3rpr, platform_corners
from mechanisms import loaded
from scipy.optimize import brentq

import pmjac_pin as pj


@pytest.fixture(scope="module")
def five_bar_locus():
    return pj.singularity_locus(loaded("five_bar"), ("theta1", "theta2"), cells=21)


@pytest.fixture(scope="module")
def cuspidal_locus():
    mechanism = cuspidal_3rpr()
    start = pj.assembly_modes(mechanism, [17.0, 18.04, 31.5], rng=0, limits=False)[0]
    window = {"rho2": (1, 50), "rho3": (1, 50)}
    return pj.singularity_locus(
        mechanism, ("rho2", "rho3"), at=start, window=window, kinds=["gain"], cells=31
    )


def elbows(theta):
    """Of the catalogue's five-bar: pivots 0.3 apart, proximal links of 0.3."""
    first = 0.3 * np.array([np.cos(theta[:, 0]), np.sin(theta[:, 0])])
    second = 0.3 * np.array([np.cos(theta[:, 1]), np.sin(theta[:, 1])])
    return first, second + np.array([[0.3], [0.0]])


def curves(locus, kind):
    return [curve for curve in locus.curves if curve.kind == kind]


def test_five_bar_gains_where_its_distal_links_are_in_line(five_bar_locus):
    found = curves(five_bar_locus, "gain")
    assert found
    for curve in found:
        first, second = elbows(curve.places)
        # Links of 0.4: stretched, the elbows are 0.8 apart.
        assert np.linalg.norm(first - second, axis=0) == pytest.approx(0.8, abs=1e-10)


def test_five_bar_gains_wherever_its_distal_links_are_in_line(five_bar_locus):
    """Points of the closed equation, contoured on a fine grid, lie on curves that were traced."""
    angles = np.linspace(-np.pi, np.pi, 200)
    theta = np.stack(np.meshgrid(angles, angles), axis=-1).reshape(-1, 2)
    first, second = elbows(theta)
    near = np.abs(np.linalg.norm(first - second, axis=0) - 0.8) < 1e-3
    assert near.sum() > 50
    assert max(five_bar_locus.distance(place) for place in theta[near]) < 0.1


def test_five_bar_loses_where_an_arm_is_in_line(five_bar_locus):
    found = curves(five_bar_locus, "loss")
    assert found
    for curve in found:
        bent = [np.abs(np.sin(curve.q[:, k])) for k in _elbow_entries()]
        assert np.minimum(*bent).max() < 1e-10


def _elbow_entries():
    mechanism = loaded("five_bar")
    coordinates, columns = mechanism.coordinates, mechanism.problem.partition.columns
    return [coordinates.entry(columns[name]) for name in ("phi1", "phi2")]


def test_five_bar_turns_about_its_elbows_where_these_coincide(five_bar_locus):
    """There it moves with both motors at rest: a curve in joint space, a point in the plane."""
    places = {tuple(np.round(p.place, 9)) for p in five_bar_locus.marked("isolated point")}
    third = np.pi / 3.0
    assert places == {
        (round(third, 9), round(2 * third, 9)),
        (round(-third, 9), round(-2 * third, 9)),
    }


def test_loss_touches_gain_where_an_arm_is_folded_in_line_with_both_distal_links(five_bar_locus):
    """The machine folds there, so that a curve of loss through the pose turns back along the gain.

    The tip is 0.1 behind the first pivot, the other elbow 0.5, and 0.3 from its own pivot.
    """
    expected = []
    for theta1 in (np.arccos(-0.25 / 0.3), -np.arccos(-0.25 / 0.3)):
        elbow = -0.5 * np.array([np.cos(theta1), np.sin(theta1)]) - [0.3, 0.0]
        assert np.linalg.norm(elbow) == pytest.approx(0.3, abs=1e-12)
        theta2 = np.arctan2(elbow[1], elbow[0])
        mirrored = np.remainder(2.0 * np.pi - np.array([theta2, theta1]), 2.0 * np.pi) - np.pi
        expected += [(theta1, theta2), mirrored]
    found = [p.place for p in five_bar_locus.marked("branch point") if p.kind == "gain"]
    assert len(found) == len(expected) == 4
    for place in expected:
        assert np.abs(np.array(found) - place).max(axis=1).min() < 1e-7


@pytest.mark.slow
def test_curves_of_mirror_images_lie_on_each_other_and_do_not_cross():
    """The 3-RPS is its own mirror image in its base: poses over and under it have the same legs."""
    mechanism = loaded("three_rps")
    locus = pj.singularity_locus(mechanism, ("l1", "l2"), kinds=["gain"], cells=41)
    on_each_other = 0
    for curve in locus.curves:
        others = [one for one in locus.curves if one is not curve]
        on_each_other += any(
            max(np.linalg.norm(one.places - place, axis=1).min() for place in curve.places) < 0.05
            for one in others
        )
    assert on_each_other > 2
    assert not locus.marked("crossing")
    places = [
        (c.places, np.array([mechanism.configuration(q).tool_pose().translation for q in c.q]))
        for c in locus.curves
    ]
    every = np.vstack([np.column_stack(pair) for pair in places])
    for row in every[::9] * [1.0, 1.0, 1.0, 1.0, -1.0]:
        assert np.linalg.norm(every - row, axis=1).min() < 0.05


def test_other_working_modes_are_seen_where_they_are_named():
    """In a window that no curve of loss is in, no mode leads to another."""
    bar, window = loaded("five_bar"), {"x": (0.1, 0.2), "y": (0.1, 0.2)}
    at = pj.reach(bar, [0.15, 0.15, 0.0]).configuration
    every = list(pj.working_modes(bar, at.tool_pose().translation))
    assert len(every) == 4
    alone, found = (
        pj.singularity_locus(
            bar, ("x", "y"), at=at, kinds=["gain"], window=window, cells=9, modes=modes
        )
        for modes in (None, every)
    )
    assert (len(alone.modes), len(found.modes)) == (1, 4)
    assert len(alone.curves) < len(found.curves)


@pytest.mark.slow
def test_gain_of_similar_triangles_ends_in_branch_points_and_says_so():
    """Where the platform is turned as its base all poses are singular, and cross other such."""
    locus = pj.singularity_locus(loaded("planar_3rpr"), ("l1", "l2"), kinds=["gain"], cells=31)
    ends = [curve for curve in locus.curves if not curve.complete]
    assert ends
    assert all(curve.branches == 2 for curve in ends)
    assert len(locus.marked("branch point")) == 2 * len(ends)
    assert "are branch points" in locus.evidence.statement
    for point in locus.marked("branch point"):
        angle = locus.at.mechanism.configuration(point.q).joint_values["platform"][2]
        assert abs(np.sin(angle)) < 1e-5


def test_3rpr_gains_where_the_lines_of_its_legs_meet(cuspidal_locus):
    mechanism, corners = cuspidal_locus.at.mechanism, platform_corners()
    for curve in cuspidal_locus.curves:
        assert curve.complete
        for q in curve.q[::10]:
            values = mechanism.configuration(q).joint_values
            heading = values["turn1"] + values["angle"]
            turn = np.array(
                [[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]]
            )
            tip = values["rho1"] * np.array([np.cos(values["turn1"]), np.sin(values["turn1"])])
            ends = tip + corners @ turn.T
            ways = ends - BASE
            assert np.linalg.norm(ways[0]) == pytest.approx(17.0, abs=1e-10)
            lines = [
                (*w, f[0] * w[1] - f[1] * w[0]) / np.linalg.norm(w)
                for w, f in zip(ways, BASE, strict=True)
            ]
            # Three lines in a plane meet, or are parallel, where their coordinates are dependent.
            assert abs(np.linalg.det(lines)) < 1e-9


def test_3rpr_has_the_published_cusp(cuspidal_locus):
    cusps = np.array([point.place for point in cuspidal_locus.marked("cusp")])
    assert len(cusps) == 6
    apart = np.abs(cusps - [18.040919, 31.596386]).max(axis=1).min()
    assert apart < 1e-6


@pytest.mark.parametrize("which", ["five_bar_locus", "cuspidal_locus"])
def test_each_point_is_closed_and_singular(which, request):
    locus = request.getfixturevalue(which)
    assert locus.residual < 1e-10
    mechanism = locus.at.mechanism
    for curve in locus.curves:
        for q in curve.q[::20]:
            pose = mechanism.configuration(q)
            found = pose.singularity()
            assert pose.residual_norm <= 1e-10
            assert found.gained if curve.kind == "gain" else found.lost
    for point in locus.points:
        assert mechanism.configuration(point.q).singularity().kind != "regular"


def test_crossings_are_two_poses_at_one_place(cuspidal_locus):
    for point in cuspidal_locus.marked("crossing"):
        for number in point.curves:
            places = cuspidal_locus.curves[number].places
            step = np.linalg.norm(np.diff(places, axis=0), axis=1).max()
            assert np.linalg.norm(places - point.place, axis=1).min() <= step
    assert len(cuspidal_locus.marked("crossing")) >= 4


def test_finer_grids_find_the_same_curves(five_bar_locus):
    finer = pj.singularity_locus(loaded("five_bar"), ("theta1", "theta2"), cells=33, kinds=["gain"])
    for curve in curves(five_bar_locus, "gain"):
        assert max(finer.distance(place) for place in curve.places) < 0.1


def test_it_says_what_it_rests_on(five_bar_locus):
    assert five_bar_locus.evidence.kind == "tolerance"
    assert "21 x 21 cells on 2 assembly modes" in five_bar_locus.evidence.statement
    assert "may be missed" in five_bar_locus.evidence.statement


def test_as_a_dataset(five_bar_locus):
    pytest.importorskip("xarray")
    found = five_bar_locus.to_xarray()
    assert found.sizes["vertex"] == sum(len(curve.places) for curve in five_bar_locus.curves)
    first = found.isel(vertex=found["curve"] == 0)
    assert (first["place"].to_numpy() == five_bar_locus.curves[0].places).all()
    assert found.attrs["evidence"] == str(five_bar_locus.evidence)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"plane": ("theta1", "theta3")}, "theta2"),
        ({"plane": "theta1"}, "two motors"),
        ({"plane": ("theta1", "theta1")}, "two motors"),
        ({"plane": ("x", "y", "z")}, "of two motors, .* got 'x', 'y', 'z'"),
        ({"plane": ("x", "theta1")}, "one of each: 'x' is the tool's"),
        ({"plane": ("theta1", "phi1")}, "'phi1', which is passive"),
        ({"plane": ()}, "got none"),
        ({"plane": 3}, "got 3"),
        ({"window": {"theta1": (2, 1)}}, "lower, upper"),
        ({"window": {"phi1": (1, 2)}}, "phi1"),
        ({"kinds": ["gained"]}, "did you mean 'gain'"),
        ({"kinds": "gain"}, r"in a list: \['gain'\]; got 'gain'"),
        ({"kinds": []}, "got none"),
        ({"kinds": 3}, "got 3"),
        ({"cells": 1}, "cells"),
        ({"cells": 100_000}, "`cells` is a number, 2 to 2000, got 100000"),
        ({"at": 3}, "at"),
    ],
)
def test_what_is_wrong_is_said(given, says):
    with pytest.raises(pj.PmjacError, match=says):
        pj.singularity_locus(loaded("five_bar"), **{"plane": ("theta1", "theta2"), **given})


@pytest.mark.parametrize("study", [pj.singularity_locus, pj.workspace])
@pytest.mark.parametrize("plane", [("theta1", "phi1"), ("x", "y"), ("theta1",)])
def test_a_mechanism_with_one_motor_has_no_plane(study, plane):
    with pytest.raises(pj.ArgumentError, match="mobility 1, and moves over no plane: `follow`"):
        study(loaded("four_bar"), plane)


def test_a_home_right_beside_a_fold_is_on_a_mode_of_any_grid():
    """Elbows 0.747 apart of 0.748: paths from there take many steps to the nearest cell."""
    lengths = {"l0": 0.35, "l1": 0.327, "l2": 0.477, "l3": 0.271, "l4": 0.359}
    locus = pj.singularity_locus(
        pj.load("five_bar", lengths), ("theta1", "theta2"), kinds=["gain"], cells=21
    )
    assert len(locus.modes) == 2
    assert len(locus.curves) > 1


def test_a_window_that_is_not_reached_is_no_empty_locus():
    """The second elbow may not be 0.9 from the first."""
    window = {"theta1": (3.0, 3.2), "theta2": (-0.1, 0.1)}
    with pytest.raises(pj.ArgumentError, match="no cell"):
        pj.singularity_locus(loaded("five_bar"), ("theta1", "theta2"), window=window, cells=5)


def test_an_arm_loses_where_its_elbow_is_in_line():
    """det J = l1 l2 sin θ2, l1 = 1 and l2 = 0.8: by default, a chain gains nothing."""
    arm = loaded("serial_2r")
    locus = pj.singularity_locus(arm, ("theta1", "theta2"), cells=15)
    assert {curve.kind for curve in locus.curves} == {"loss"}
    bends = sorted(np.unique(np.round(curve.places[:, 1], 9)).tolist() for curve in locus.curves)
    assert bends == [[-round(np.pi, 9)], [0.0], [round(np.pi, 9)]]


@pytest.mark.parametrize("cells", [15, 41])
def test_a_circle_of_the_tool_is_one_curve_that_closes(cells):
    """Once around an arm's base the first joint has made a full turn."""
    locus = pj.singularity_locus(loaded("serial_2r"), ("x", "y"), cells=cells)
    radii = [np.linalg.norm(curve.places, axis=1) for curve in locus.curves]
    assert sorted(radius.mean().round(9) for radius in radii) == [0.2, 1.8]
    assert max(np.ptp(radius) for radius in radii) < 1e-10
    assert all(curve.is_closed for curve in locus.curves)


def ur5_shoulder(second, third, fourth):
    """The factor of det J that vanishes where the wrist is above the first axis, m."""
    bent = 0.39225 * np.cos(second + third) - 0.09465 * np.sin(second + third + fourth)
    return 0.425 * np.cos(second) + bent


@pytest.mark.parametrize("cells", [11, 15, 31, 41])
def test_straight_curves_of_an_arm_meet_where_two_factors_of_its_determinant_vanish(cells):
    """At sin θ5 = 0 with sin θ3 = 0 or the shoulder's factor, whatever the grid."""
    arm = loaded("ur5")
    second, fourth = arm.home.actuated[1], arm.home.actuated[3]
    bent = brentq(lambda third: ur5_shoulder(second, third, fourth), -1.5, 0.0)
    window = {"elbow_joint": (-1.5, 0.9), "wrist_2_joint": (-1.0, 1.0)}
    locus = pj.singularity_locus(arm, tuple(window), window=window, cells=cells)
    assert {point.mark for point in locus.points} == {"branch point"}
    places = sorted(tuple(point.place) for point in locus.points)
    np.testing.assert_allclose(places, [(bent, 0.0), (0.0, 0.0)], atol=1e-6)


def test_a_ur5_loses_where_its_determinant_vanishes():
    """det J = a2 a3 sin θ3 sin θ5 (a2 cos θ2 + a3 cos θ23 + d5 sin θ234)."""
    arm = loaded("ur5")
    locus = pj.singularity_locus(arm, arm.actuated[1:3], cells=21)
    second, third, fourth = np.vstack([curve.q for curve in locus.curves])[:, 1:4].T
    shoulder = ur5_shoulder(second, third, fourth)
    assert max(np.abs(np.sin(third)).max(), np.abs(shoulder).max()) > 0.1  # both factors are met
    assert np.abs(np.sin(third) * shoulder).max() < 1e-10
    assert min(np.abs(np.sin(third)).min(), np.abs(shoulder).min()) < 1e-10


def test_kinds_that_a_mechanism_cannot_have_are_told():
    with pytest.raises(pj.ArgumentError, match="no loops, and gains nothing: ask for 'loss'"):
        pj.singularity_locus(loaded("serial_2r"), ("theta1", "theta2"), kinds=["gain"])
    whole = loaded("five_bar")
    spec, home = whole.spec, whole.home.q
    bar = pj.Mechanism.from_pinocchio(whole.model, spec.loops, spec.actuated, home=home)
    locus = pj.singularity_locus(bar, ("theta1", "theta2"), cells=15)
    assert {curve.kind for curve in locus.curves} == {"gain"}
    with pytest.raises(pj.NoToolError):
        pj.singularity_locus(bar, ("theta1", "theta2"), kinds=["loss"])
