"""The contact sheet: every mode once, to one scale, with what tells it apart."""

from __future__ import annotations

import sys

import mechanisms
import numpy as np
import pytest

import pmjac_pin as pj
from pmjac_pin.pictures.figures import save_figure
from pmjac_pin.pictures.mode_sheet import plot_modes


@pytest.fixture(scope="module")
def lecture():
    return pj.assembly_modes(pj.load("three_rps_ss"), [2 / 3, 3 / 5, 3 / 4], rng=0)


@pytest.fixture(scope="module")
def four_bar():
    return pj.assembly_modes(pj.load("four_bar"), [0.9], rng=0)


def test_every_mode_has_a_panel_and_its_title(lecture):
    titles = [axes.get_title() for axes in plot_modes(lecture).axes]
    numbers = [title.split(",")[0] for title in titles]
    assert numbers == ["1", "2 (lecture_a)", *"345678"]
    for number, title in enumerate(titles):
        image = lecture.mirror_images[number] + 1
        assert f"mirror image of {image}\n" in title
        positive = lecture[number].split_jacobian().det_K_star > 0
        assert title.endswith("det K* > 0" if positive else "det K* < 0")


def test_forty_still_have_room_for_their_titles():
    mechanism = pj.load("four_bar")
    few = pj.assembly_modes(mechanism, [0.9], rng=0)
    many = pj.AssemblyModes(
        few.configurations * 20, few.shares * 20, few.starts, few.evidence, (None,) * 40
    )
    figure = plot_modes(many)
    figure.draw_without_rendering()
    boxes = [axes.title.get_window_extent() for axes in figure.axes]
    assert len(boxes) == 40
    apart = [not a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k]]
    assert all(apart)


def test_all_panels_have_one_scale_and_nothing_is_cut_off(lecture):
    panels = plot_modes(lecture).axes
    limits = {(axes.get_xlim(), axes.get_ylim()) for axes in panels}
    assert len(limits) == 1
    [((left, right), (low, high))] = limits
    for axes in panels:
        assert axes.get_aspect() == 1.0
        points = np.concatenate([line.get_xydata() for line in axes.lines])
        assert points[:, 0].min() > left
        assert points[:, 0].max() < right
        assert points[:, 1].min() > low
        assert points[:, 1].max() < high


def test_a_planar_mechanism_is_drawn_in_its_plane(four_bar):
    mechanism = four_bar[0].mechanism
    [first, _] = plot_modes(four_bar).axes
    lengths = {
        round(float(np.linalg.norm(np.diff(line.get_xydata(), axis=0)[0])), 9)
        for line in first.lines
        if len(line.get_xydata()) == 2
    }
    assert {mechanism.parameters[name] for name in ("l0", "l1", "l2", "l3")} <= lengths


def test_a_plane_is_looked_at_with_its_upright_axis_upwards():
    """The slider-crank lies in x and y: x points to the right, y upwards."""
    modes = pj.assembly_modes(pj.load("slider_crank"), [0.9], rng=0)
    panels = plot_modes(modes).axes
    for axes, mode in zip(panels, modes, strict=True):
        drawn = np.concatenate([line.get_xydata() for line in axes.lines])
        tool = mode.tool_pose.translation[:2]
        assert np.abs(drawn - tool).max(axis=1).min() <= 1e-9


def test_what_completeness_rests_on_stands_below(four_bar):
    figure = plot_modes(four_bar)
    title = figure.get_suptitle().replace("\u00a0", " ")
    assert title == "Assembly modes of four_bar\ntheta1 = 0.9 rad"
    assert (
        figure.get_supxlabel().replace("\n", " ")
        == f"That there are no more rests on {four_bar.evidence}."
    )


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_it_can_be_saved(four_bar, tmp_path, suffix):
    path = tmp_path / f"modes.{suffix}"
    save_figure(plot_modes(four_bar), path)
    assert path.stat().st_size > 3000
    assert list(tmp_path.iterdir()) == [path]


def test_no_modes_are_refused():
    modes = pj.assembly_modes(mechanisms.rocker_rocker(), [2.5], rng=0)
    with pytest.raises(pj.ArgumentError, match="there are no assembly modes to draw"):
        plot_modes(modes)


def test_without_matplotlib_it_says_what_is_missing(four_bar, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(pj.MissingDependencyError, match="plotting needs matplotlib"):
        plot_modes(four_bar)
