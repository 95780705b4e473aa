"""Transmissions over a rectangle: maps of them, and tables whose error is bounded.

What is said of an ankle is held against its closed formula, of other machines against `close`.
"""

from __future__ import annotations

import csv
import re
from dataclasses import replace

import mechanisms
import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline
from test_transmission import motors_by_hand
from transmission_machines import CASES, SMALL, drawn, table_of

import pmjac_pin as pj
from pmjac_pin.studies.transmissions.enclosure import bounds_of


def test_an_ankles_table_beside_its_closed_formula(rng):
    """Everywhere as near as the proven bound says; and the bound is no empty one."""
    table = table_of("humanoid_ankle")
    x = drawn(table, rng, 3000)
    by_hand = np.array([motors_by_hand(*row) for row in x])
    off = np.abs(table.motor_values(x) - by_hand)
    assert (off <= table.error).all()
    assert (table.error < 15.0 * off.max(axis=0)).all()
    exact, ratio = table.exact(x)
    np.testing.assert_allclose(exact, by_hand, rtol=0, atol=1e-12)
    h = 1e-5
    for k, step in enumerate(h * np.eye(2)):
        sides = [np.array([motors_by_hand(*row) for row in x[:200] + s * step]) for s in (1, -1)]
        np.testing.assert_allclose(
            ratio[:200, :, k], (sides[0] - sides[1]) / (2 * h), rtol=0, atol=1e-8
        )
    assert ((table.lower <= ratio) & (ratio <= table.upper)).all()
    assert table.evidence.kind == "proof"


@pytest.mark.parametrize("name", CASES)
def test_a_table_is_as_near_as_it_says(name, rng):
    table = table_of(name)
    x = drawn(table, rng, 12)
    exact, ratio = table.exact(x)
    for k, row in enumerate(x):
        geared = table.transmission.at_joints(row, guess=table.transmission.by_joints.home)
        np.testing.assert_allclose(exact[k], geared.motors, rtol=0, atol=1e-11)
        np.testing.assert_allclose(ratio[k], geared.ratio, rtol=1e-9, atol=1e-9)
        assert (np.abs(table.motor_values(row) - geared.motors) <= table.error + 1e-12).all()
        assert ((table.lower <= geared.ratio) & (geared.ratio <= table.upper)).all()
    assert table.evidence.kind == "proof"


@pytest.mark.parametrize("name", CASES)
def test_an_estimate_is_called_one_and_holds(name, rng):
    make, over, points = CASES[name]
    guessed = pj.transmission_table(make(), over, points, proof=False)
    assert guessed.evidence.kind == "tolerance"
    assert "an estimate" in guessed.evidence.statement
    x = drawn(guessed, rng, 4000)
    exact, _ = table_of(name).exact(x)
    assert (np.abs(guessed.motor_values(x) - exact) <= guessed.error + 1e-14).all()
    assert (guessed.error <= 4.0 * table_of(name).error + 1e-14).all()


@pytest.mark.parametrize("name", ["humanoid_ankle", "four_bar"])
def test_a_proof_sees_a_wrong_number(name):
    """One value of the table off by 1e-4: so is what is proven, or nothing is."""
    table = table_of(name)
    data = table.sheet.data.copy()
    middle = tuple(size // 2 for size in table.map.status.shape)
    motor = table.transmission.by_motors.coordinates.entry(int(table.program.followers[0]))
    data[(*middle, *(0,) * len(middle), motor)] += 1e-4
    found = bounds_of(table.program, replace(table.sheet, data=data))
    assert found.failed or found.error[0] >= 1e-4


def test_more_points_are_nearer_by_the_fourth_power():
    errors = [
        pj.transmission_table(mechanisms.loaded("humanoid_ankle"), SMALL, points).error
        for points in (5, 9)
    ]
    assert (errors[0] > 10.0 * errors[1]).all()


@pytest.mark.parametrize("name", CASES)
def test_a_map_is_what_single_poses_say(name):
    found = table_of(name).map
    limits = np.arange(1.0, 1.0 + len(found.joints))
    efforts, rates = found.efforts_alone(limits), found.rates_alone(limits)
    shape = found.status.shape
    for place in [(0,) * len(shape), tuple(size // 2 for size in shape)]:
        geared = found.transmission.at(found.transmission.by_joints.configuration(found.q[place]))
        np.testing.assert_allclose(found.motors[place], geared.motors, rtol=0, atol=1e-10)
        np.testing.assert_allclose(found.ratio[place], geared.ratio, rtol=0, atol=1e-8)
        np.testing.assert_allclose(
            found.reflected(limits)[place], geared.armature(limits), atol=1e-8
        )
        for k, unit in enumerate(np.eye(len(found.joints))):
            for reach, polytope in (
                (efforts, geared.effort_limits(limits)),
                (rates, geared.rate_limits(limits)),
            ):
                assert polytope.contains(unit * reach[place][k] * (1 - 1e-6))
                assert not polytope.contains(unit * reach[place][k] * (1 + 1e-6))


@pytest.mark.parametrize("name", ["humanoid_ankle", "ankle", "five_bar"])
def test_the_mixed_derivative_is_that_of_single_poses(name):
    table = table_of(name)
    twist, place = table.tabulated()["twist"], tuple(s // 3 for s in table.map.status.shape)
    driven = table.transmission.by_joints
    geared = table.transmission.at(driven.configuration(table.map.q[place]))
    np.testing.assert_allclose(twist[place], geared.curvature[:, 0, 1], rtol=0, atol=1e-9)


def test_where_an_ankles_transmission_exists():
    """Exactly where both rods reach: its closed formula has a real angle."""
    found = pj.transmission_map(
        mechanisms.loaded("humanoid_ankle"),
        {"pitch": (-0.9, 0.6), "roll": (-0.4, 0.4)},
        13,
        enforce_limits=False,
    )
    mesh = np.stack(np.meshgrid(*found.axes, indexing="ij"), axis=-1)
    with np.errstate(invalid="ignore"):
        by_hand = np.array([motors_by_hand(*row) for row in mesh.reshape(-1, 2)])
    real = np.isfinite(by_hand).all(axis=1).reshape(found.status.shape)
    assert 20 < real.sum() < real.size - 20
    np.testing.assert_array_equal(found.exists, real)
    np.testing.assert_allclose(found.motors[real], by_hand[real.ravel()], rtol=0, atol=1e-9)
    assert np.isnan(found.ratio[~real]).all()
    assert np.isnan(found.efforts_alone([1.0, 1.0])[~real]).all()
    covered = found.covered()
    whole = pj.transmission_map(
        mechanisms.loaded("humanoid_ankle"), covered, 9, enforce_limits=False
    )
    assert whole.exists.all()


def test_limits_of_motors_count_unless_they_are_not_asked_for():
    wide = {"pitch": (-0.5, 0.0), "roll": (-0.3, 0.3)}
    mechanism = mechanisms.loaded("humanoid_ankle")
    within = pj.transmission_map(mechanism, wide, 7)
    beyond = pj.transmission_map(mechanism, wide, 7, enforce_limits=False)
    assert (within.status == pj.Status.LIMITS).any()
    assert beyond.exists.all()
    assert (np.abs(beyond.motors[within.status == pj.Status.LIMITS]).max(axis=-1) > 1.2).all()
    with pytest.raises(pj.ArgumentError, match=r"a joint is beyond its limits, so at pitch=-0\.5"):
        pj.transmission_table(mechanism, wide, 7)


def dead_points():
    """A rocker that drives a crank: at its ends the crank moves on, and the rocker rests."""
    lengths = dict(zip(("l0", "l1", "l2", "l3"), mechanisms.CRANK_ROCKER, strict=True))
    l0, l1, l2, l3 = mechanisms.CRANK_ROCKER
    straight, folded = (
        np.arccos((l0**2 + arm**2 - l3**2) / (2 * l0 * arm)) for arm in (l1 + l2, l2 - l1)
    )
    return pj.load("four_bar", lengths, actuated=["phi1"]), straight, np.pi + folded


def test_a_singularity_between_the_points_is_seen_and_told_where():
    mechanism, first, second = dead_points()
    found = pj.transmission_map(mechanism, {"theta1": (0.1, 5.9)}, 12, enforce_limits=False)
    assert found.exists.all()
    (axis,) = found.axes
    expected = np.unique(np.searchsorted(axis, [first, second]) - 1)
    assert np.flatnonzero(found.crossed).tolist() == expected.tolist()
    near = {"theta1": (first - 0.3, first + 0.5)}
    with pytest.raises(pj.ArgumentError, match="singular inside theta1") as caught:
        pj.transmission_table(mechanism, near, 8, enforce_limits=False)
    low, high = (float(axis) for axis in re.findall(r"theta1=([-\d.]+)", str(caught.value)))
    assert low < first < high


def test_a_singularity_that_signs_do_not_show_is_no_proof():
    """Two dead points in one cell: det R has one sign at its ends."""
    mechanism, first, second = dead_points()
    middle, half = 0.5 * (first + second), 0.5 * (second - first) + 0.4
    over = {"theta1": (middle - half, middle + half)}
    found = pj.transmission_map(mechanism, over, 2, enforce_limits=False)
    assert found.exists.all()
    assert not found.crossed.any()
    with pytest.raises(pj.ArgumentError, match="singular inside theta1"):
        pj.transmission_table(mechanism, over, 2, enforce_limits=False)


def test_at_a_singularity_a_point_is_told():
    mechanism, first, _ = dead_points()
    found = pj.transmission_map(
        mechanism, {"theta1": (first - 0.2, first + 0.2)}, 5, enforce_limits=False
    )
    assert found.status.tolist() == [0, 0, int(pj.Status.SINGULAR), 0, 0]
    assert np.isnan(found.ratio[2]).all()
    with pytest.raises(pj.ArgumentError, match=r"at 1 of 5 points .* the transmission is singular"):
        found.check_whole()


FOUR_BAR = {"phi1": (2.2, 2.4)}


@pytest.mark.parametrize(
    ("over", "keywords", "message"),
    [
        ({"phi3": (0.0, 1.0)}, {}, "phi3"),
        ({"phi1": (2.4, 2.2)}, {}, "of 'phi1' two numbers are wanted, the lower one first"),
        ({"phi1": (2.2, 2.3, 2.4)}, {}, "two numbers are wanted"),
        ({"phi1": "wide"}, {}, "real numbers"),
        ({}, {}, "`over` is a mapping of joints"),
        (["phi1"], {}, "`over` is a mapping of joints"),
        ({"phi1": (2.2, 2.4), "phi2": (0.0, 1.0)}, {}, "as many joints as motors, 1, got 2"),
        (dict.fromkeys("abc", (0.0, 1.0)), {}, "a rectangle is of one joint or two"),
        (FOUR_BAR, {"points": 1}, "`points` is 2 to 1000 along each joint"),
        (FOUR_BAR, {"points": 2.5}, "`points` is a number"),
        (FOUR_BAR, {"points": True}, "`points` is a number"),
        (FOUR_BAR, {"guess": "away"}, "away"),
        (FOUR_BAR, {"proof": "yes"}, "proof is True or False"),
        ({"phi1": (1.0, 3.0)}, {}, "the loops do not close, so at phi1=1; it exists for phi1"),
        ({"phi1": (0.1, 0.2)}, {}, "the loops do not close, so at phi1=0.1$"),
    ],
)
def test_what_no_table_is_made_of(over, keywords, message):
    with pytest.raises(pj.PmjacError, match=message):
        pj.transmission_table(mechanisms.loaded("four_bar"), over, **keywords)


@pytest.mark.parametrize("given", [[[2.1]], [2.41], [float("nan")], [2.2, 2.3], 2.3])
def test_values_that_are_not_in_a_table(given):
    table = pj.transmission_table(mechanisms.loaded("four_bar"), FOUR_BAR, 5)
    for asked in (table.motor_values, table.exact):
        with pytest.raises(pj.ArgumentError):
            asked(given)


def test_joints_that_do_not_determine_the_motors():
    mechanism = mechanisms.rssr()
    spun = pj.Mechanism.from_pinocchio(
        mechanism.model, mechanism.spec.loops, ["rz"], "rocker_tip", home=mechanism.home.q
    )
    value = mechanism.home.joint_values["theta"]
    with pytest.raises(pj.ArgumentError, match="do not determine what idles: rz"):
        pj.transmission_map(spun, {"theta": (value - 0.1, value + 0.1)})


@pytest.mark.parametrize("name", CASES)
def test_an_npz_has_all_that_interpolation_takes(name, tmp_path, rng):
    """By SciPy: of one joint its own Hermite polynomials, of two those of rows along columns."""
    table = table_of(name)
    table.save(tmp_path / "table.npz")
    with np.load(tmp_path / "table.npz") as file:
        saved = dict(file)
    assert saved["joints"].tolist() == list(table.joints)
    assert saved["motors"].tolist() == list(table.motors)
    assert str(saved["evidence"]) == str(table.evidence)
    for key in ("error", "lower", "upper"):
        np.testing.assert_array_equal(saved[key], getattr(table, key))
    x, values, ratio = drawn(table, rng, 50), saved["motor_values"], saved["ratio"]
    found = []
    for row in x:
        if len(row) == 1:
            found.append(CubicHermiteSpline(saved["axis0"], values, ratio[..., 0])(row[0]))
            continue
        along = CubicHermiteSpline(saved["axis1"], values, ratio[..., 1], axis=1)(row[1])
        across = CubicHermiteSpline(saved["axis1"], ratio[..., 0], saved["twist"], axis=1)(row[1])
        found.append(CubicHermiteSpline(saved["axis0"], along, across)(row[0]))
    endless = table.transmission.by_motors.coordinates.wraps.any()
    atol = 10.0 * table.error.max() if endless else 1e-12
    np.testing.assert_allclose(found, table.motor_values(x), rtol=0, atol=atol)


@pytest.mark.parametrize("name", CASES)
def test_a_csv_has_a_row_for_each_point(name, tmp_path):
    table = table_of(name)
    table.save(tmp_path / "table.csv")
    header, *rows = csv.reader((tmp_path / "table.csv").read_text().splitlines())
    n = len(table.joints)
    assert header[: 2 * n] == [*table.joints, *table.motors]
    assert header[2 * n] == f"d{table.motors[0]}/d{table.joints[0]}"
    numbers = np.array(rows, dtype=float)
    assert len(numbers) == table.map.status.size
    exact, ratio = table.exact(numbers[:, :n])
    np.testing.assert_allclose(numbers[:, n : 2 * n], exact, rtol=0, atol=1e-13)
    np.testing.assert_allclose(numbers[:, 2 * n :], ratio.reshape(len(ratio), -1), rtol=1e-12)


def test_a_saved_header_is_the_tables(tmp_path):
    table = table_of("four_bar")
    table.save(tmp_path / "rocker.h")
    assert (tmp_path / "rocker.h").read_text() == table.c()


def test_files_are_not_replaced_unasked(tmp_path):
    table, place = table_of("four_bar"), tmp_path / "table.csv"
    place.write_text("mine")
    with pytest.raises(pj.OutputError, match=r"table.csv: exists already; --force replaces it"):
        table.save(place)
    assert place.read_text() == "mine"
    table.save(place, force=True)
    assert place.read_text().startswith("phi1,theta1,")
    for name, message in (
        ("table.txt", r"a table's file ends in .h, .npz, .csv"),
        ("no folder/table.h", "there is no folder"),
    ):
        with pytest.raises(pj.OutputError, match=message):
            table.save(tmp_path / name)
    with pytest.raises(pj.ArgumentError, match="force is True or False"):
        table.save(place, force="yes")
