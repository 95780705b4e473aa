"""In a real browser: a load, motor efforts against their limits, polytopes."""

from __future__ import annotations

import numpy as np
import pytest
from mechanisms import loaded
from test_page import (  # noqa: F401
    OVERLAPS,
    TELEPHONE,
    agree,
    browser,
    open_page,
    picture,
    quiet,
    wait,
)

import pmjac_pin as pj

pytestmark = pytest.mark.slow


@pytest.fixture
def mechanism():
    return loaded("three_rps")


def typed(page, box, value):
    page.fill(f"#{box}-value", value)
    page.press(f"#{box}-value", "Enter")
    quiet(page)


def bars(page):
    """Return name, share of half of the bar, number and colour of each motor's effort."""
    return page.evaluate(
        """() => [...document.querySelectorAll(".effort")].map((row) => {
          const fill = row.querySelector(".fill"), bar = row.children[1].getBoundingClientRect();
          const box = fill.getBoundingClientRect(), middle = (bar.left + bar.right) / 2;
          const right = box.right - middle > middle - box.left ? 1 : -1;
          return [row.title, right * box.width / (bar.width / 2),
                  row.querySelector(".value").textContent, getComputedStyle(fill).backgroundColor];
        })"""
    )


def test_a_weight_is_hung_and_bars_turn_red_beyond_the_limits(viewer, open_page):  # noqa: F811
    page, other = open_page(viewer), open_page(viewer)
    limits = 100.0
    before = picture(page)
    colours = {}
    for mass in (5.0, 20.0, 40.0):
        typed(page, "weight-0", f"{mass:g}")
        efforts = viewer.configuration.statics([0, 0, -9.81 * mass, 0, 0, 0]).efforts
        for (name, share, shown, colour), effort, motor in zip(
            bars(page), efforts, ("l1", "l2", "l3"), strict=True
        ):
            assert name == motor
            agree(shown, [effort])
            assert share == pytest.approx(min(effort / limits, 1.25) / 1.25, abs=0.05)
            colours.setdefault(bool(effort > limits), set()).add(colour)
    assert len(colours[False]) == len(colours[True]) == 1
    assert colours[False] != colours[True]
    assert picture(page) != before
    wait(other, "pmjac.state.load.mass === 40")
    assert other.input_value("#weight-0-value") == "40.0000"
    meter = page.locator(".effort [role=meter]").first
    assert meter.get_attribute("aria-valuetext").endswith("beyond the limit")
    assert float(meter.get_attribute("aria-valuemax")) == limits


def test_a_force_is_pushed_along_a_direction_by_keys(viewer, open_page):  # noqa: F811
    page = open_page(viewer)
    page.select_option("#load-kind", "force")
    quiet(page)
    assert page.is_visible("#force-1")
    assert not page.is_visible("#weight-0")
    typed(page, "force-0", "60")
    page.locator("#force-2").focus()
    for _ in range(6):
        page.keyboard.press("PageUp")
    quiet(page)
    page.check("#degrees")
    typed(page, "force-1", "90")
    force = np.array(page.evaluate("pmjac.state.load.force"))
    assert np.linalg.norm(force) == pytest.approx(60.0)
    assert abs(force[0]) < 1e-9 < force[1]
    efforts = viewer.configuration.statics([*force, 0, 0, 0]).efforts
    for (_, _, shown, _), effort in zip(bars(page), efforts, strict=True):
        agree(shown, [effort])
    page.reload()
    wait(page, "window.pmjac && pmjac.ready")
    assert page.input_value("#load-kind") == "force"
    assert float(page.input_value("#force-0-value")) == 60.0


def test_polytopes_are_switched_on_and_seen(viewer, open_page):  # noqa: F811
    page = open_page(viewer)
    viewer.update(loaded("three_rps").close([0.9, 1.2, 1.0]))
    page.wait_for_timeout(300)
    for box in ("velocity_polytope", "force_polytope"):
        before = picture(page)
        page.check(f"#{box}")
        quiet(page)
        assert picture(page) != before
        assert page.evaluate(f"pmjac.state.drawn.{box}") is True
        assert page.evaluate("pmjac.state.jump !== null")  # all of it is in view
    assert page.text_content("#no-polytopes") == ""


def test_at_a_singular_pose_there_are_words(viewer, open_page):  # noqa: F811
    page = open_page(viewer)
    page.check("#velocity_polytope")
    typed(page, "weight-0", "5")
    page.fill("#motor-1-value", "3")
    page.press("#motor-1-value", "Enter")
    quiet(page)
    assert "singular" in page.text_content("#load-note")
    assert [shown for _, _, shown, _ in bars(page)] == ["—"] * 3
    assert all(abs(share) < 0.02 for _, share, _, _ in bars(page))
    assert "no equivalent Jacobian" in page.text_content("#no-polytopes")


def test_a_mass_that_is_none_is_refused_and_the_old_one_stays(viewer, open_page):  # noqa: F811
    page = open_page(viewer)
    typed(page, "weight-0", "7")
    typed(page, "weight-0", "-3")
    assert "mass is 0 to" in page.text_content("#notice")
    assert page.input_value("#weight-0-value") == "7.0000"


def test_a_motor_without_a_limit_says_so(open_page):  # noqa: F811
    arm = loaded("serial_2r")
    model = arm.model
    model.upperEffortLimit = model.upperVelocityLimit = np.array([0.0, 7.0])
    model.lowerEffortLimit = -model.upperEffortLimit
    free = pj.Mechanism.from_pinocchio(model, [], arm.actuated, arm.spec.tool.names[0])
    with pj.view(free.close([0.3, 0.9]), open_browser=False, port=0) as viewer:
        page = open_page(viewer)
        page.select_option("#load-kind", "force")
        typed(page, "force-0", "5")
        typed(page, "force-2", "0")
        assert page.locator(".of-limit").all_text_contents()[0] == "no limit stated"
        assert "of 7" in page.locator(".of-limit").all_text_contents()[1]
        assert abs(bars(page)[0][1]) == pytest.approx(1 / 1.25, abs=0.05)
        page.check("#force_polytope")
        quiet(page)
        said = page.text_content("#no-polytopes")
        assert said == f"No polytope: the model states no effort limit of {arm.actuated[0]}."


@pytest.mark.parametrize("name", ["tied", "ur5"])
def test_open_and_over_actuated_machines(open_page, name):  # noqa: F811
    mechanism = pj.load("four_bar", actuated=["theta1", "phi1"]) if name == "tied" else loaded(name)
    with pj.view(mechanism.home, open_browser=False, port=0) as viewer:
        page = open_page(viewer, TELEPHONE)
        page.select_option("#load-kind", "force")
        typed(page, "force-0", "5")
        typed(page, "force-2", "0")
        force = page.evaluate("pmjac.state.load.force")
        efforts = mechanism.home.statics([*force, 0, 0, 0]).efforts
        for (_, _, shown, _), effort in zip(bars(page), efforts, strict=True):
            agree(shown, [effort])
        assert ("against each other" in page.text_content("#load-note")) == (name == "tied")
        assert page.evaluate("document.documentElement.scrollWidth") == TELEPHONE["width"]
        assert page.evaluate(OVERLAPS) == []
