"""In a real browser: lengths, motors that play, views that follow, and the picture to keep."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from test_page import browser, drag, open_page, picture, pixels, quiet, wait  # noqa: F401

import pmjac_pin as pj

pytestmark = pytest.mark.slow


@pytest.fixture
def mechanism():
    return pj.load("four_bar")


def test_a_length_is_dragged_typed_and_refused(viewer, open_page):  # noqa: F811
    page, other = open_page(viewer), open_page(viewer)
    before = picture(page)
    page.click("#design summary")
    page.locator("#parameter-1").focus()
    for _ in range(4):
        page.keyboard.press("ArrowRight")
    quiet(page)
    value = viewer.configuration.mechanism.parameters["l1"]
    assert value > 1.0
    assert page.evaluate("document.activeElement.id") == "parameter-1"
    assert picture(page) != before
    wait(other, f"Math.abs(pmjac.state.parameters[1] - {value}) < 1e-12")
    page.fill("#parameter-0-value", "40")
    page.press("#parameter-0-value", "Enter")
    wait(page, "document.getElementById('notice').textContent.includes('does not assemble')")
    assert viewer.configuration.mechanism.parameters["l1"] == value
    assert page.input_value("#parameter-0-value") == "4.0000"
    page.fill("#motor-0-value", "1.0")
    page.press("#motor-0-value", "Enter")
    quiet(page)
    assert viewer.configuration.actuated == pytest.approx([1.0])


def test_without_parameters_there_are_no_sliders(open_page):  # noqa: F811
    with pj.view(pj.load("ur5").home, open_browser=False, port=0) as viewer:
        assert not open_page(viewer).is_visible("#design")


def values(page, seconds):
    """Return what a motor's box shows, again and again."""
    seen = []
    for _ in range(int(10 * seconds)):
        page.wait_for_timeout(100)
        seen.append(page.evaluate("pmjac.state.values[0]"))
    return np.array(seen)


@pytest.mark.parametrize("name", ["four_bar", "three_rps_ss"])
def test_a_motor_plays_to_and_fro_until_it_is_stopped(open_page, name):  # noqa: F811
    """Of the 3-RPS one leg comes to the end of its mode; it turns there."""
    with pj.view(pj.load(name).home, open_browser=False, port=0) as viewer:
        page = open_page(viewer)
        play = page.locator("#motors .play").first
        play.click()
        assert play.get_attribute("aria-pressed") == "true"
        seen = values(page, 12)
        ways = np.sign(np.diff(seen))
        assert {1.0, -1.0} <= set(ways)
        assert np.count_nonzero(ways) > 40
        slider = page.locator("#motor-0")
        low, high = (float(slider.get_attribute(end)) for end in ("min", "max"))
        assert low - 1e-9 <= seen.min() < seen.max() <= high + 1e-9
        play.click()
        quiet(page)
        assert np.ptp(values(page, 0.5)) == 0.0
        play.click()
        page.click("#home")
        quiet(page)
        assert play.get_attribute("aria-pressed") == "false"
        assert viewer.configuration is viewer.configuration.mechanism.home


SHARE = "(({ viewer, stage, shareInView }) => shareInView(viewer, stage.framing))"
SCENE = "document.getElementById('scene').contentWindow"
CAMERA = f"JSON.stringify({SCENE}.viewer.camera.position)"


def test_a_mode_that_lies_below_is_in_view(open_page):  # noqa: F811
    """And where it is already, nothing turns."""
    mechanism = pj.load("three_rps_ss")
    modes = pj.assembly_modes(mechanism, [2.0, 2.0, 2.0], rng=0)
    with pj.view(modes[0], open_browser=False, port=0) as viewer:
        page = open_page(viewer)
        first = page.evaluate(CAMERA)
        page.click("#find-modes")
        wait(page, "document.getElementById('modes').dataset.status === 'found'")
        page.locator("#modes button").last.click()
        quiet(page)
        assert viewer.configuration.tool_pose().translation[2] < 0.0
        assert page.evaluate(CAMERA) != first
        assert page.evaluate(f"{SHARE}({SCENE})") == 1
        edge = pixels(page)
        drawn = np.abs(edge - edge[:, :1]).max(axis=2) > 25
        assert not drawn[-1].any()
        below = json.loads(page.evaluate(CAMERA))
        page.locator("#modes button").nth(len(modes) - 2).click()
        page.locator("#modes button").last.click()
        quiet(page)
        assert json.loads(page.evaluate(CAMERA)) == pytest.approx(below, abs=1e-9)


def test_the_picture_to_keep_is_large_and_has_its_legend(viewer, open_page, tmp_path):  # noqa: F811
    page = open_page(viewer)
    before = picture(page)
    with page.expect_download() as download:
        page.click("#snapshot")
    download.value.save_as(tmp_path / "x.png")
    width, height = struct.unpack(">II", (tmp_path / "x.png").read_bytes()[16:24])
    scene = page.locator("#scene").bounding_box()
    assert width == 2400
    assert height > 2400 * scene["height"] / scene["width"] + 200  # title, numbers, legend
    assert picture(page) == before


def test_of_too_many_motors_one_slider_is_answered_and_the_page_lives_on(open_page):  # noqa: F811
    """The loops tie them: one alone does not move, and a second page sees and moves the same."""
    mechanism = pj.load("five_bar", actuated=["theta1", "theta2", "phi1"])
    with pj.view(mechanism.home, open_browser=False, port=0) as viewer:
        page = open_page(viewer)
        drag(page, 0, mechanism.home.actuated[0], mechanism.home.actuated[0] + 0.5)
        assert "the loops tie motors to each other" in page.inner_text("#notice")
        np.testing.assert_array_equal(viewer.configuration.actuated, mechanism.home.actuated)
        second = open_page(viewer)
        for name, value in zip(range(3), mechanism.home.actuated, strict=True):
            assert float(second.input_value(f"#motor-{name}-value")) == pytest.approx(value, 1e-3)
        second.locator("#motors .play").first.click()
        wait(second, "document.querySelector('#motors .play').ariaPressed === 'false'")
        second.click("#home")
        quiet(second)
        wait(page, "pmjac.state.pose === 'home' && pmjac.idle()")
