"""A trajectory on the page: at any of its parameters, in words and in a browser."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest
from mechanisms import loaded, rocker_rocker
from test_page import browser, open_page, picture, quiet, wait  # noqa: F401
from viewer_clients import connected

import pmjac_pin as pj
from pmjac_pin.viewer.replay import Replay


@pytest.fixture
def trajectory():
    return pj.follow(rocker_rocker(), [[0.9], [2.0]], samples=9)


def test_between_samples_the_pose_is_that_of_the_path():
    machine = loaded("five_bar")

    def path(t):
        return machine.home.actuated + 0.1 * np.array([np.sin(t), np.cos(2.0 * t) - 1.0])

    replay = Replay(pj.follow(machine, path, times=(0.0, 3.0)))
    for t in np.linspace(0.0, 3.0, 23).tolist():
        assert replay.at(t).actuated == pytest.approx(path(t), abs=1e-5)
    assert replay.slider().upper == 3.0
    with pytest.raises(pj.ArgumentError, match="not from 0 to 3"):
        replay.at(3.1)


def test_near_a_fold_the_last_sample_is_shown(trajectory):
    replay = Replay(trajectory)
    last = replay.at(float(trajectory.t[-1]))
    assert last.singularity().kind == "gain"
    before = replay.at(float(trajectory.t[-1]) - 1e-9)
    assert abs(before.actuated[0] - last.actuated[0]) < 0.3
    assert [one.kind for one in replay.happenings()] == ["fold"]


def test_the_page_is_told_and_asks(trajectory):
    async def talk(viewer):
        async with connected(viewer) as page:
            first = await page.read()
            shown = await page.ask({"command": "moment", "values": [0.2], "id": 1})
            moved = await page.ask({"command": "move", "values": [1.0], "id": 2})
            wrong = await page.ask({"command": "moment", "values": [7.0], "id": 3})
            return first, shown, moved, wrong

    with pj.view(trajectory, open_browser=False, port=0) as viewer:
        first, shown, moved, wrong = asyncio.run(talk(viewer))
    assert (first["about"]["replay"]["lower"], first["moment"]) == (0.0, 0.0)
    [event] = first["about"]["happenings"]
    assert (event["kind"], event["t"]) == ("fold", trajectory.events[0].t)
    assert shown["moment"] == 0.2
    assert shown["values"][0] == pytest.approx(0.9 + 1.1 * 0.2, abs=1e-9)
    assert moved["moment"] is None
    assert wrong["type"] == "error"
    assert "t = 7 is not from 0" in wrong["message"]


def test_without_a_trajectory_there_is_none():
    async def talk(viewer):
        async with connected(viewer) as page:
            return await page.read(), await page.ask({"command": "moment", "values": [0.2]})

    with pj.view(loaded("four_bar").home, open_browser=False, port=0) as viewer:
        first, answer = asyncio.run(talk(viewer))
        with pytest.raises(pj.ArgumentError, match="a Trajectory is wanted"):
            viewer.play(viewer.configuration)
        with pytest.raises(pj.ArgumentError, match="this viewer shows"):
            viewer.play(pj.follow(loaded("serial_2r"), [[0.1, 0.2], [0.2, 0.3]]))
    assert first["about"]["replay"] is None
    assert answer["type"] == "error"


@pytest.mark.slow
def test_a_trajectory_plays_in_a_browser(open_page, trajectory):  # noqa: F811
    with pj.view(trajectory.mechanism.home, open_browser=False, port=0) as viewer:
        page = open_page(viewer)
        assert not page.is_visible("#replay")
        viewer.play(trajectory)
        wait(page, "pmjac.state.moment === 0")
        assert page.is_visible("#replay")
        before = picture(page)
        page.click("#moment-0-play")
        wait(page, "pmjac.state.moment > 0.1")
        page.click("#moment-0-play")
        quiet(page)
        assert picture(page) != before
        page.click("#happenings button")
        wait(page, f"pmjac.state.moment === {trajectory.events[0].t!r}")
        assert "almost" in page.inner_text("body") or "singular" in page.inner_text("body").lower()
        page.fill("#motor-0-value", "1.0")
        page.press("#motor-0-value", "Enter")
        wait(page, "pmjac.state.moment === null")
