"""Workspaces: areas in closed form, and that each cell says what a single call says."""

import re
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import transformed
from annuli import shared_area
from mechanisms import Z, loaded, tree

import pmjac_pin as pj
from pmjac_pin.studies.workspaces import find_workspace

UNIT_BAR = dict.fromkeys(("l0", "l1", "l2", "l3", "l4"), 1.0)


def corners(radius):
    """Three points on a circle, the first on x."""
    return radius * np.array([[1.0, 0.0], [-0.5, 0.75**0.5], [-0.5, -(0.75**0.5)]])


def turned(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def planar_annuli(pose, base, platform, inner, outer):
    """Of a planar machine of three legs that keeps its platform turned as at a pose."""
    angle = pose.joint_values["platform"][2]
    centres = corners(base) - corners(platform) @ turned(angle).T
    return [(centre, inner, outer) for centre in centres]


def turned_by(name, angle):
    """A planar machine at home, its platform turned by so much more."""
    mechanism = loaded(name)
    place = mechanism.home.tool_pose()
    place.rotation = pin.utils.rotate("z", angle) @ place.rotation
    found = pj.reach(mechanism, place)
    assert found.status == "reached"
    return found.configuration


def stewart_annuli(plane):
    """Legs of 0.1 to 3.0 from the ground to a platform that is turned as at home, in a plane."""
    mechanism = loaded("stewart_gough")
    model, home = mechanism.model, mechanism.home
    data = model.createData()
    pin.framesForwardKinematics(model, data, home.q)
    across = next(k for k, name in enumerate("xyz") if name not in plane)
    tool, found = home.tool_pose().translation, []
    for k in range(1, 7):
        joint = data.oMf[model.getFrameId(f"P{k}")].translation
        away = data.oMi[model.getJointId(f"alpha{k}")].translation - (joint - tool)
        height = tool[across] - away[across]
        inner = np.sqrt(max(0.1**2 - height**2, 0.0))
        found.append((np.delete(away, across), inner, np.sqrt(3.0**2 - height**2)))
    return found


@pytest.fixture(scope="module")
def bar_in_tool_space():
    return pj.workspace(loaded("five_bar"), ("x", "y"), cells=41, measure="dexterity")


def test_five_bar_of_ones_reaches_what_two_discs_share():
    bar = pj.load("five_bar", UNIT_BAR)
    found = pj.workspace(bar, ("x", "y"), cells=21)
    assert found.area == pytest.approx(8.0 * np.arccos(0.25) - np.sqrt(15.0) / 2.0, rel=1e-7)
    assert found.area == pytest.approx(8.6084369, abs=1e-6)
    assert {piece.reason for piece in found.border} == {"loss"}


def test_five_bar_reaches_what_two_annuli_share(bar_in_tool_space):
    annuli = [((0.0, 0.0), 0.1, 0.7), ((0.3, 0.0), 0.1, 0.7)]
    assert bar_in_tool_space.area == pytest.approx(shared_area(annuli), rel=1e-7)


def test_an_arm_of_two_links_reaches_an_annulus():
    found = pj.workspace(loaded("serial_2r"), ("x", "y"), cells=15)
    assert found.area == pytest.approx(np.pi * (1.8**2 - 0.2**2), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("cells", [25, 33, 52, 90, 121])
def test_areas_do_not_depend_on_the_grid(cells):
    annuli = [((0.0, 0.0), 0.1, 0.7), ((0.3, 0.0), 0.1, 0.7)]
    found = pj.workspace(loaded("five_bar"), ("x", "y"), cells=cells)
    assert found.area == pytest.approx(shared_area(annuli), rel=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "annuli"),
    [
        ("planar_3rpr", (0.5, 0.2, 0.05, 1.0)),
        ("planar_3rrr", (0.5, 0.15, 0.05, 0.55)),
    ],
)
@pytest.mark.parametrize("angle", [0.0, 0.15, -0.4])
def test_slices_of_constant_orientation_are_shared_by_annuli(name, annuli, angle):
    pose = turned_by(name, angle)
    assert pose.joint_values["platform"][2] == pytest.approx(
        loaded(name).home.joint_values["platform"][2] + angle, abs=1e-9
    )
    found = pj.workspace(loaded(name), ("x", "y"), mode=pose, cells=31)
    assert found.area == pytest.approx(shared_area(planar_annuli(pose, *annuli)), rel=1e-6)
    assert found.cell_area == pytest.approx(found.area, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("plane", ["xy", "xz", "yz"])
def test_slices_of_a_platform_on_six_legs_are_shared_by_six_annuli(plane):
    """Home is off the middle by 1e-4: circles of two legs almost lie on each other, and cross."""
    found = pj.workspace(loaded("stewart_gough"), tuple(plane), cells=31)
    assert found.area == pytest.approx(shared_area(stewart_annuli(plane)), rel=1e-6)
    assert found.cell_area == pytest.approx(found.area, rel=0.1)


def test_cells_are_reached_where_both_annuli_are(bar_in_tool_space):
    found = bar_in_tool_space
    places = np.stack(np.meshgrid(found.first, found.second, indexing="ij"), axis=-1)
    inside = np.ones(found.reached.shape, dtype=bool)
    for centre in ((0.0, 0.0), (0.3, 0.0)):
        distance = np.linalg.norm(places - centre, axis=-1)
        inside &= (distance > 0.1) & (distance < 0.7)
    assert (found.reached == inside).all()


def test_each_cell_is_the_pose_that_the_single_call_knows(bar_in_tool_space):
    found, mechanism = bar_in_tool_space, loaded("five_bar")
    rng = np.random.default_rng(5)
    for a, b in rng.permutation(np.argwhere(found.reached))[:20]:
        pose = mechanism.configuration(found.q[a, b])
        place = pose.tool_pose().translation
        assert place[:2] == pytest.approx([found.first[a], found.second[b]], abs=1e-12)
        radii = np.linalg.svd(pose.jacobian().Jv_eq[:2], compute_uv=False)
        assert found.values[a, b] == pytest.approx(radii[1] / radii[0], rel=1e-9)
    assert np.isnan(found.values[~found.reached]).all()


@pytest.mark.parametrize(
    ("measure", "expected"),
    [
        ("smallest singular value", lambda pose: pose.singularity().smallest),
        ("conditioning", lambda pose: 1.0 / pose.singularity().condition),
        ("gear ratio", lambda pose: pose.jacobian().velocity_ellipsoid().radii[1]),
        ("speed", lambda pose: pose.jacobian().velocity_ellipsoid().radii[0]),
        ("force", lambda pose: 1.0 / pose.jacobian().velocity_ellipsoid().radii[0]),
    ],
)
def test_measures_are_those_of_single_calls(measure, expected):
    mechanism = loaded("five_bar")
    found = pj.workspace(mechanism, ("theta1", "theta2"), cells=9, measure=measure, trace=False)
    for a, b in np.argwhere(found.reached)[::7]:
        pose = mechanism.configuration(found.q[a, b])
        assert found.values[a, b] == pytest.approx(expected(pose), rel=1e-8)


def test_motor_space_is_bounded_by_gains():
    """Elbows at most 0.8 apart: for how many motor values they are, by quadrature."""
    found = pj.workspace(loaded("five_bar"), ("theta1", "theta2"), cells=41)
    angles = -np.pi + 2.0 * np.pi * (np.arange(4000) + 0.5) / 4000
    first = 0.3 * np.array([np.cos(angles), np.sin(angles)])
    # For each θ1, by how much the elbow of θ2 stays within 0.8: its circle is about (0.3, 0).
    away = np.hypot(first[0] - 0.3, first[1])
    cosine = (0.8**2 - away**2 - 0.3**2) / (2.0 * 0.3 * away)
    arcs = 2.0 * np.pi - 2.0 * np.arccos(np.clip(cosine, -1.0, 1.0))
    assert found.area == pytest.approx((2.0 * np.pi / 4000) * arcs.sum(), rel=1e-4)


def test_borders_of_limits_are_where_joints_are_at_them():
    found = pj.workspace(loaded("planar_3rpr"), ("l1", "l2"), cells=21)
    assert found.reached.any()
    poses = found.q[found.reached]
    for q in poses[::17]:
        assert not loaded("planar_3rpr").configuration(q).limits_violated


def test_it_says_what_it_rests_on(bar_in_tool_space):
    assert bar_in_tool_space.evidence.kind == "tolerance"
    assert "which closes" in bar_in_tool_space.evidence.statement
    assert "'home'" in bar_in_tool_space.mode
    assert bar_in_tool_space.mode.startswith("working mode")


def opened(piece):
    return replace(piece, places=piece.places[:-1], ways=piece.ways[:-1])


def longest_loop(border):
    """Of a ring, its outer circle: what closes, and is not all."""
    return [max(border, key=lambda piece: np.ptp(piece.places, axis=0).max())]


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        (
            lambda border: [opened(border[0]), *border[1:]],
            r"'loss' (ends|begins) at \(.*, and the nearest that .* off",
        ),
        (lambda border: (), "no piece of it was traced"),
        (lambda border: [*border, *border], "it encloses .* cells, and .* are reached"),
        (longest_loop, "no piece is near the cell at"),
    ],
)
def test_what_does_not_close_is_said(monkeypatch, changed, says):
    whole, arm = find_workspace.border, loaded("serial_2r")
    monkeypatch.setattr(find_workspace, "border", lambda *given: changed(whole(*given)))
    found = pj.workspace(arm, ("x", "y"), cells=41)
    assert np.isnan(found.area)
    assert re.search(f"pieces, which does not close: {says}", found.evidence.statement)


def test_as_a_dataset(bar_in_tool_space):
    pytest.importorskip("xarray")
    found = bar_in_tool_space.to_xarray()
    assert found["dexterity"].dims == ("x", "y")
    assert int(found["reached"].sum()) == int(bar_in_tool_space.reached.sum())
    assert found.attrs["area"] == bar_in_tool_space.area


@pytest.mark.parametrize(
    ("name", "given", "says"),
    [
        ("five_bar", {"measure": "beauty"}, "dexterity"),
        ("five_bar", {"plane": ("x", "theta1")}, "motor"),
        ("five_bar", {"mode": 4}, "mode"),
        ("five_bar", {"cells": 0}, "cells"),
        ("ankle", {}, "cannot be led"),
        ("five_bar", {"window": {"x": (5, 6), "y": (5, 6)}}, "no cell"),
    ],
)
def test_what_is_wrong_is_said(name, given, says):
    with pytest.raises(pj.PmjacError, match=says):
        pj.workspace(loaded(name), **{"plane": ("x", "y"), **given})


def limited_arm(lower, upper):
    """Two links of 1 whose second joint has narrow limits: the tip reaches a ring."""
    continuous = ("theta1", "continuous", "ground", "first", (0, 0, 0), Z)
    second = ("theta2", "revolute", "first", "second", (1.0, 0, 0), Z)
    model = pin.buildModelFromXML(
        tree(continuous, second, ("end", "fixed", "second", "tip", (1.0, 0, 0)))
    )
    model.lowerPositionLimit[-1], model.upperPositionLimit[-1] = lower, upper
    home = {"theta1": 0.3, "theta2": 0.5 * (lower + upper)}
    arm = pj.Mechanism.from_pinocchio(model, [], ["theta1", "theta2"], "tip", home=home)
    return arm.with_tool("tip", rows=["vx", "vy"])


@pytest.mark.slow
@pytest.mark.parametrize("turns", [0, -1])
def test_a_ring_narrower_than_a_cell_of_the_first_look_is_within_the_window(turns):
    lower, upper = 1.5 + 2.0 * np.pi * turns, 1.58 + 2.0 * np.pi * turns
    found = pj.workspace(limited_arm(lower, upper), ("x", "y"), cells=121)
    assert found.area == pytest.approx(2.0 * np.pi * (np.cos(lower) - np.cos(upper)), rel=1e-7)
    assert "window" not in {piece.reason for piece in found.border}


def test_far_from_the_origin_it_reaches_the_same(bar_in_tool_space):
    far = pin.SE3(np.eye(3), np.array([1e4, -2e4, 0.0]))
    moved = transformed.moved(loaded("five_bar"), far).with_tool("tip", rows=["vx", "vy"])
    found = pj.workspace(moved, ("x", "y"), cells=21)
    assert found.area == pytest.approx(bar_in_tool_space.area, rel=1e-7)
    places = np.vstack([piece.places for piece in found.border])
    near = np.vstack([piece.places for piece in bar_in_tool_space.border])
    for ends in (np.min, np.max):
        assert ends(places, axis=0) - far.translation[:2] == pytest.approx(
            ends(near, axis=0), abs=1e-3
        )
    for a, b in np.argwhere(found.reached)[::60]:
        place = moved.configuration(found.q[a, b]).tool_pose().translation
        assert place[:2] == pytest.approx([found.first[a], found.second[b]], abs=1e-10)


def delta_reaches(delta, x, y, z):
    """Which places a delta's arms reach: the rod's end is where its elbow's circle may be."""
    values = delta.parameters
    found = np.ones(np.broadcast(x, y).shape, dtype=bool)
    for k in range(3):
        turn = 2.0 * np.pi * k / 3.0
        ahead = np.cos(turn) * x + np.sin(turn) * y + values["plate"] - values["base"]
        aside = -np.sin(turn) * x + np.cos(turn) * y
        reach = np.sqrt(np.maximum(values["rod"] ** 2 - aside**2, 0.0))
        away = np.hypot(ahead, z)
        found &= (np.abs(aside) < values["rod"]) & (away < values["arm"] + reach)
        found &= away > np.abs(values["arm"] - reach)
    return found


@pytest.mark.slow
def test_a_delta_reaches_what_all_its_arms_do():
    """At its corners two arms are in line at once: no curve leads through there that turns."""
    delta = loaded("delta")
    found = pj.workspace(delta, ("x", "y"), cells=31, limits=False)
    z = delta.home.joint_values["platform"][2]
    axes = [np.linspace(axis[0], axis[-1], 2000) for axis in (found.first, found.second)]
    counted = delta_reaches(delta, axes[0][:, None], axes[1], z).sum()
    cell = (axes[0][1] - axes[0][0]) * (axes[1][1] - axes[1][0])
    assert found.area == pytest.approx(counted * cell, rel=1e-3)
    assert {piece.reason for piece in found.border} == {"loss"}
