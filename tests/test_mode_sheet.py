"""The contact sheets: every mode once, to one scale, with what tells it apart."""

from __future__ import annotations

import sys

import mechanisms
import numpy as np
import pytest
from mechanisms import loaded

import pmjac_pin as pj
from pmjac_pin.pictures.figures import save_pages
from pmjac_pin.pictures.mode_sheet import plot_modes
from pmjac_pin.pictures.page_layout import PageLayout


@pytest.fixture(scope="module")
def lecture():
    return pj.assembly_modes(pj.load("three_rps_ss"), [2 / 3, 3 / 5, 3 / 4], rng=0)


@pytest.fixture(scope="module")
def four_bar():
    return pj.assembly_modes(pj.load("four_bar"), [0.9], rng=0)


def test_every_mode_has_a_panel_and_its_title(lecture):
    [figure] = plot_modes(lecture)
    titles = [axes.get_title() for axes in figure.axes]
    numbers = [title.split(",")[0] for title in titles]
    assert numbers == ["1", "2 (lecture_a)", *"345678"]
    for number, title in enumerate(titles):
        image = lecture.mirror_images[number] + 1
        assert f"mirror image of {image}\n" in title
        positive = lecture[number].split_jacobian().det_K_star > 0
        assert title.endswith("det K* > 0" if positive else "det K* < 0")


def many(few, count):
    """Return as many modes, each again and again."""
    again = -(-count // len(few))
    configurations, shares = few.configurations * again, few.shares * again
    return pj.AssemblyModes(
        configurations[:count], few.starts, few.evidence, shares[:count], (None,) * count
    )


@pytest.mark.parametrize("modes", ["four_bar", "lecture"])
def test_forty_go_on_pages_all_alike_with_room_for_each(modes, request):
    pages = plot_modes(many(request.getfixturevalue(modes), 40))
    assert len(pages) > 1
    assert sum(len(page.axes) for page in pages) == 40
    assert len({tuple(page.get_size_inches()) for page in pages}) == 1
    numbers = [axes.get_title().split()[0].strip(",") for page in pages for axes in page.axes]
    assert numbers == [str(number) for number in range(1, 41)]
    first, last = numbers[0], numbers[len(pages[0].axes) - 1]
    assert f": {first} to {last} of 40\n" in pages[0].get_suptitle()
    pages[0].draw_without_rendering()
    boxes = [axes.title.get_window_extent() for axes in pages[0].axes]
    assert all(not a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
    widths = [axes.get_tightbbox().width / pages[0].dpi for axes in pages[0].axes]
    assert min(widths) > 1.5, "inches"


@pytest.mark.parametrize("height", [0.01, 0.3, 0.7, 1.0, 1.3, 2.0, 30.0])
def test_no_page_is_a_ribbon(height):
    for count in range(1, 130):
        layout = PageLayout.of(count, height)
        width, high = layout.size(0.6)
        assert 0.35 < high / width <= 1.4
        assert width <= 10.4
        assert [place for page in layout.pages(count) for place in range(count)[page]] == [
            *range(count)
        ]
        assert layout.most <= layout.columns * layout.rows


def test_links_that_pass_over_each_other_are_not_interrupted(lecture):
    [figure] = plot_modes(lecture)
    colours = {line.get_color() for axes in figure.axes for line in axes.lines}
    assert "white" not in colours


def drawn_points(axes):
    return np.concatenate([line.get_xydata() for line in axes.lines])


def test_all_panels_have_one_scale_and_nothing_is_cut_off(lecture):
    [figure] = plot_modes(lecture)
    sizes = [np.ptp([axes.get_xlim(), axes.get_ylim()], axis=1) for axes in figure.axes]
    np.testing.assert_allclose(sizes, np.broadcast_to(sizes[0], (8, 2)))
    for axes in figure.axes:
        assert axes.get_aspect() == 1.0
        points = drawn_points(axes)
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        assert points[:, 0].min() > left
        assert points[:, 0].max() < right
        assert points[:, 1].min() > low
        assert points[:, 1].max() < high


def test_no_panel_is_larger_than_its_widest_and_its_highest_mode():
    """Pistons on both sides of the crank leave no white bands, as a common frame would."""
    [figure] = plot_modes(pj.assembly_modes(loaded("slider_crank"), [0.9], rng=0))
    own = [np.ptp(drawn_points(axes), axis=0) for axes in figure.axes]
    together = np.ptp(np.concatenate(list(map(drawn_points, figure.axes))), axis=0)
    panel = np.ptp([figure.axes[0].get_xlim(), figure.axes[0].get_ylim()], axis=1)
    largest = np.max(own, axis=0)
    assert (panel <= largest + 0.15 * largest.max()).all()
    assert panel[0] < 0.8 * together[0]
    for axes in figure.axes:
        points = drawn_points(axes)
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        panel_middle = np.mean([axes.get_xlim(), axes.get_ylim()], axis=1)
        assert (np.abs(middle - panel_middle) <= 0.1 * panel).all()


@pytest.mark.parametrize("height", [1.0, 1.3])
@pytest.mark.parametrize("count", [8, 12, 40])
def test_where_rows_can_be_full_they_are(count, height):
    layout = PageLayout.of(count, height)
    assert layout.rows * layout.columns * len(layout.pages(count)) == count


def test_a_planar_mechanism_is_drawn_in_its_plane(four_bar):
    mechanism = four_bar[0].mechanism
    [figure] = plot_modes(four_bar)
    [first, _] = figure.axes
    lengths = {
        round(float(np.linalg.norm(np.diff(line.get_xydata(), axis=0)[0])), 9)
        for line in first.lines
        if len(line.get_xydata()) == 2
    }
    assert {mechanism.parameters[name] for name in ("l0", "l1", "l2", "l3")} <= lengths


def test_a_plane_is_looked_at_with_its_upright_axis_upwards():
    """The slider-crank lies in x and y: x points to the right, y upwards."""
    modes = pj.assembly_modes(pj.load("slider_crank"), [0.9], rng=0)
    [figure] = plot_modes(modes)
    for axes, mode in zip(figure.axes, modes, strict=True):
        drawn = np.concatenate([line.get_xydata() for line in axes.lines])
        tool = mode.tool_pose().translation[:2]
        assert np.abs(drawn - tool).max(axis=1).min() <= 1e-9


def test_what_completeness_rests_on_stands_below(four_bar):
    [figure] = plot_modes(four_bar)
    title = figure.get_suptitle().replace("\u00a0", " ")
    assert title == "Assembly modes of four_bar\ntheta1 = 0.9 rad"
    assert (
        figure.get_supxlabel().replace("\n", " ")
        == f"That there are no more rests on {four_bar.evidence}."
    )


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_it_can_be_saved(four_bar, tmp_path, suffix):
    path = tmp_path / f"modes.{suffix}"
    assert save_pages(plot_modes(four_bar), path) == [path]
    assert path.stat().st_size > 3000
    assert list(tmp_path.iterdir()) == [path]


def test_pages_are_one_pdf_or_a_file_each(four_bar, tmp_path):
    pages = plot_modes(many(four_bar, 17))
    assert len(pages) == 2
    files = [tmp_path / "modes.png", tmp_path / "modes-2.png"]
    assert save_pages(pages, tmp_path / "modes.png", dpi=20) == files
    assert save_pages(pages, tmp_path / "modes.pdf") == [tmp_path / "modes.pdf"]
    assert b"/Count 2" in (tmp_path / "modes.pdf").read_bytes()
    assert len(list(tmp_path.iterdir())) == 3


def test_where_one_page_has_no_place_none_is_written(four_bar, tmp_path):
    (tmp_path / "modes-2.png").mkdir()
    with pytest.raises(pj.OutputError, match=r"modes-2\.png: is a folder"):
        save_pages(plot_modes(many(four_bar, 17)), tmp_path / "modes.png", dpi=20)
    assert [path.name for path in tmp_path.iterdir()] == ["modes-2.png"]


def test_no_modes_are_refused():
    modes = pj.assembly_modes(mechanisms.rocker_rocker(), [2.5], rng=0)
    with pytest.raises(pj.ArgumentError, match="there are no assembly modes to draw"):
        plot_modes(modes)


def test_without_matplotlib_it_says_what_is_missing(four_bar, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(pj.MissingDependencyError, match="plotting needs matplotlib"):
        plot_modes(four_bar)
