"""Stick figures: bars as long as the links, plates with the platforms' corners."""

from __future__ import annotations

import mechanisms
import numpy as np
import pytest
from mechanisms import loaded

from pmjac_pin.pictures.stick_figure import TOOL_LENGTH, StickFigures


def figure_of(configuration):
    return StickFigures(configuration.mechanism)(configuration)


def lengths(figure, kind):
    return sorted(
        np.linalg.norm(np.ptp(s.points, axis=0)) for s in figure.strokes if s.kind == kind
    )


def test_the_bars_of_a_four_bar_have_the_links_lengths():
    mechanism = loaded("four_bar")
    values = mechanism.parameters
    figure = figure_of(mechanism.close([0.7]))
    np.testing.assert_allclose(lengths(figure, "ground"), values["l0"])
    np.testing.assert_allclose(
        lengths(figure, "link"), sorted(values[name] for name in ("l1", "l2", "l3"))
    )


def test_a_ternary_link_is_a_plate_and_the_tool_within_it_no_corner():
    mechanism = loaded("three_rps")
    [plate] = [s for s in figure_of(mechanism.home).strokes if s.kind == "link" and s.is_plate]
    sides = np.linalg.norm(plate.points - np.roll(plate.points, 1, axis=0), axis=1)
    np.testing.assert_allclose(sides, 3**0.5 * mechanism.parameters["a"])
    edges = plate.points - plate.points.mean(axis=0)
    np.testing.assert_allclose(edges @ plate.normal, 0.0, atol=1e-12)


def test_motors_that_slide_are_as_long_as_their_values():
    configuration = loaded("three_rps").close([1.1, 0.9, 1.0])
    np.testing.assert_allclose(lengths(figure_of(configuration), "motor rail"), [0.9, 1.0, 1.1])


def test_distance_loops_are_rods():
    figure = figure_of(loaded("three_rps_ss").home)
    np.testing.assert_allclose(lengths(figure, "rod"), 0.75**0.5)


@pytest.mark.parametrize("name", mechanisms.CATALOGUE)
def test_every_mechanism_has_a_figure_with_its_tool(name):
    home = loaded(name).home
    figure = figure_of(home)
    pose = home.tool_pose()
    np.testing.assert_allclose(figure.tool[0], pose.translation)
    ends = (figure.tool[1:] - figure.tool[0]).T
    np.testing.assert_allclose(ends / np.linalg.norm(ends, axis=0), pose.rotation, atol=1e-12)
    assert np.isfinite(figure.points).all()
    assert sum(s.kind in ("motor", "motor rail") for s in figure.strokes) == len(home.actuated)
    assert TOOL_LENGTH < 1


def test_points_that_span_space_hang_on_their_mean():
    """A platform with corners out of its plane: bars, since it has no outline."""
    from pmjac_pin.pictures.stick_figure import _outlines

    corners = np.vstack([np.zeros(3), np.eye(3)])
    bars = list(_outlines(corners, 1e-9))
    assert len(bars) == 4
    for bar, corner in zip(bars, corners, strict=True):
        np.testing.assert_array_equal(bar, [corners.mean(axis=0), corner])
