"""The map of two motors in a real browser: drawn, clicked, stale, and the same in a second page."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import loaded
from test_page import TELEPHONE, browser, open_page, quiet, wait  # noqa: F401 - fixtures

import pmjac_pin as pj

pytestmark = pytest.mark.slow

DRAWN = "document.getElementById('slice').dataset.status === 'drawn'"
STALE = "document.getElementById('slice').dataset.status === 'stale'"


@pytest.fixture
def viewer():
    with pj.view(loaded("planar_3rpr").home, open_browser=False, port=0) as viewer:
        yield viewer


def draw(page):
    page.click("#slice-title")
    page.click("#draw-slice")
    wait(page, DRAWN)
    page.locator("#slice-map").scroll_into_view_if_needed()


def spot(page, place):
    """Return where motor values are in the window, by the frame's rectangle: limits 0.05 to 1."""
    box = page.locator("#slice-map .frame").bounding_box()
    share = (np.array(place) - 0.05) / 0.95
    return box["x"] + share[0] * box["width"], box["y"] + (1.0 - share[1]) * box["height"]


def here(page):
    box = page.locator("#slice-here").bounding_box()
    return box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]


def test_a_click_goes_there_or_as_far_as_the_mode_does(open_page, viewer):  # noqa: F811
    page = open_page(viewer)
    assert not page.locator("#slice-map").is_visible()
    start = viewer.configuration
    draw(page)
    assert here(page) == pytest.approx(spot(page, [0.34, 0.34]), abs=1.5)
    page.mouse.click(*spot(page, [0.6, 0.55]))
    quiet(page)
    np.testing.assert_allclose(viewer.configuration.actuated, [0.6, 0.55, 0.34], atol=5e-3)
    followed = start.mechanism.close(viewer.configuration.actuated, guess=start)
    np.testing.assert_allclose(viewer.configuration.q, followed.q, atol=1e-8)
    assert here(page) == pytest.approx(spot(page, viewer.configuration.actuated[:2]), abs=1.5)
    page.mouse.click(*spot(page, [0.9, 0.1]))
    quiet(page)
    wait(page, "document.getElementById('notice').textContent.includes('goes no further')")
    assert viewer.configuration.singularity().is_singular
    assert here(page) == pytest.approx(spot(page, viewer.configuration.actuated[:2]), abs=1.5)


def test_it_grows_stale_and_is_drawn_again_by_keyboard(open_page, viewer):  # noqa: F811
    page = open_page(viewer)
    draw(page)
    page.locator("#motor-2").focus()
    page.keyboard.press("ArrowRight")
    quiet(page)
    wait(page, STALE)
    assert "l3 moved" in page.inner_text("#slice-text")
    page.locator("#draw-slice").focus()
    page.keyboard.press("Enter")
    wait(page, DRAWN)
    before = viewer.configuration.actuated
    page.locator("#slice-map").focus()
    page.keyboard.press("ArrowUp")
    quiet(page)
    expected = before + np.array([0.0, 0.95 / 40, 0.0])
    np.testing.assert_allclose(viewer.configuration.actuated, expected, atol=1e-9)


def test_a_second_page_has_it_and_it_fits_a_telephone(open_page, viewer):  # noqa: F811
    page = open_page(viewer)
    draw(page)
    late = open_page(viewer, TELEPHONE)
    wait(late, DRAWN)
    late.click("#slice-title")
    assert late.inner_text("#slice-text") == page.inner_text("#slice-text")
    assert (
        late.locator("#slice-map polyline").count() == page.locator("#slice-map polyline").count()
    )
    fits = "document.documentElement.scrollWidth <= document.documentElement.clientWidth"
    assert late.evaluate(fits)


def test_one_motor_spans_no_plane(open_page):  # noqa: F811
    with pj.view(loaded("four_bar").home, open_browser=False, port=0) as viewer:
        assert open_page(viewer).locator("#slice").is_hidden()
