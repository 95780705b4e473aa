"""The list of assembly modes in a real browser: by mouse, by keyboard and by its labels."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import loaded
from test_page import TELEPHONE, browser, open_page, quiet, wait  # noqa: F401 - fixtures

import pmjac_pin as pj

pytestmark = pytest.mark.slow

FOUND = "document.getElementById('modes').dataset.status === 'found'"


@pytest.fixture
def viewer():
    with pj.view(loaded("three_rps_ss").pose("lecture_a"), open_browser=False, port=0) as viewer:
        yield viewer


def lines(page):
    return page.locator("#modes button")


def current(page):
    return [
        int(v)
        for v in page.locator("#modes [aria-current]").evaluate_all(
            "(found) => found.map((button) => button.value)"
        )
    ]


def test_find_click_and_drag(open_page, viewer):  # noqa: F811
    page = open_page(viewer)
    assert lines(page).count() == 0
    page.click("#find-modes")
    wait(page, FOUND)
    assert lines(page).count() == 8
    assert "8 assembly modes within the limits of the joints." in page.inner_text("#modes-text")
    [here] = current(page)
    assert "lecture_a" in lines(page).nth(here - 1).inner_text()
    image = 9 - here
    lines(page).nth(image - 1).click()
    quiet(page)
    wait(page, f"document.querySelector('#modes [aria-current]').value === '{image}'")
    assert viewer.configuration.tool_pose().translation[2] < 0
    below = viewer.configuration
    page.locator("#motor-0").focus()
    page.keyboard.press("ArrowLeft")
    quiet(page)
    wait(page, "document.getElementById('modes').dataset.status === 'unknown'")
    assert lines(page).count() == 0
    assert "The motors have moved" in page.inner_text("#modes-text")
    expected = below.mechanism.close(viewer.configuration.actuated, guess=below)
    np.testing.assert_allclose(viewer.configuration.q, expected.q, atol=1e-9)


def test_all_of_it_by_keyboard(open_page, viewer):  # noqa: F811
    page = open_page(viewer, TELEPHONE)
    page.locator("#find-modes").focus()
    page.keyboard.press("Enter")
    wait(page, FOUND)
    page.keyboard.press("Tab")
    if page.evaluate("document.activeElement.id") == "modes":  # a list that scrolls is a stop
        page.keyboard.press("Tab")
    for key, focused in (("ArrowDown", "2"), ("End", "8"), ("ArrowUp", "7"), ("Home", "1")):
        page.keyboard.press(key)
        assert page.evaluate("document.activeElement.value") == focused
    page.keyboard.press("Enter")
    quiet(page)
    wait(page, "document.querySelector('#modes [aria-current]').value === '1'")
    assert page.evaluate("document.activeElement.value") == "1"


def test_a_screen_reader_hears_what_is_seen(open_page, viewer):  # noqa: F811
    page = open_page(viewer)
    page.click("#find-modes")
    wait(page, FOUND)
    label = lines(page).nth(0).get_attribute("aria-label")
    for part in (
        "Mode 1, smallest singular value of K* 0.05",
        "determinant of K* positive",
        "loop residual ",
        "mirror image of mode 8",
    ):
        assert part in label
    assert page.get_attribute("#modes-text", "role") == "status"
    assert page.get_attribute("#modes", "aria-labelledby") == "modes-title"


def test_a_second_page_sees_the_list(open_page, viewer):  # noqa: F811
    page = open_page(viewer)
    page.click("#find-modes")
    wait(page, FOUND)
    late = open_page(viewer, TELEPHONE)
    wait(late, FOUND)
    assert current(late) == current(page)
    fits = "document.documentElement.scrollWidth <= document.documentElement.clientWidth"
    assert late.evaluate(fits)
