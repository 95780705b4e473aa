"""The page's parameters: other lengths beside the pose that is shown, or all stays as it was."""

from __future__ import annotations

import asyncio
import threading

import numpy as np
import pytest
from viewer_clients import connected

import pmjac_pin as pj
from pmjac_pin.viewer import hub as hubs
from pmjac_pin.viewer.design import Design, is_sibling, redesigned

WITH_PARAMETERS = [name for name in pj.list_mechanisms() if pj.load(name).parameters]
NOT_ALONE = {"bennett"}  # it closes at proportions of its lengths only


@pytest.fixture
def mechanism():
    return pj.load("four_bar")


@pytest.mark.parametrize("name", WITH_PARAMETERS)
def test_the_motors_stay_and_the_pose_is_that_of_the_other_mechanism(name):
    mechanism = pj.load(name)
    first, value = next(iter(mechanism.parameters.items()))
    wanted = [value * 1.01, *[None] * (len(mechanism.parameters) - 1)]
    if name in NOT_ALONE:
        with pytest.raises(pj.ArgumentError, match=r"does not assemble.*stays as it was"):
            redesigned(mechanism.home, wanted)
        return
    design, pose = redesigned(mechanism.home, wanted)
    assert pose.mechanism == mechanism.with_parameters({first: value * 1.01})
    assert design.mechanism is pose.mechanism
    np.testing.assert_allclose(pose.actuated, mechanism.home.actuated, atol=1e-12)
    assert pose.residual_norm <= pose.mechanism.tolerance
    change = pose.tool_pose().translation - mechanism.home.tool_pose().translation
    assert np.linalg.norm(change) < 0.3 * mechanism.characteristic_length


@pytest.mark.parametrize("name", pj.list_mechanisms())
def test_every_declared_parameter_has_a_slider_about_its_default(name):
    mechanism = pj.load(name)
    sliders = Design.of(mechanism).parameters
    assert [slider.name for slider in sliders] == list(mechanism.parameters)
    for slider, value in zip(sliders, mechanism.parameters.values(), strict=True):
        assert slider.lower <= value <= slider.upper
        assert slider.lower < slider.upper
        assert slider.meaning == mechanism.spec.parameters[slider.name].meaning


def test_where_no_parameters_are_declared_there_are_no_sliders():
    assert Design.of(pj.load("ur5")).parameters == ()


def asking(viewer, *commands):
    """Return the answers of the server to a page, one by one."""

    async def run():
        async with connected(viewer) as page:
            await page.read()
            return [await page.ask(command) for command in commands]

    return asyncio.run(run())


def test_the_page_sets_a_parameter_and_is_told_what_has_changed(viewer, mechanism):
    [answer] = asking(viewer, {"command": "set", "values": [None, 1.2, None, None], "id": 3})
    assert (answer["type"], answer["id"]) == ("state", 3)
    other = mechanism.with_parameters(l1=1.2)
    assert answer["parameters"] == list(other.parameters.values())
    assert answer["about"]["mechanism"] == "four_bar"
    assert answer["jump"]
    assert viewer.configuration.mechanism == other
    J_eq = viewer.configuration.jacobian().J_eq
    np.testing.assert_allclose(answer["readout"]["J_eq"]["LOCAL_WORLD_ALIGNED"], J_eq)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ([40.0, None, None, None], "With l0 = 40 m it does not assemble: its loops stay open by"),
        ([None, -1.0, None, None], "not within"),
        ([1.0], "4 parameters expected, got 1"),
        ([None, "x", None, None], ""),
    ],
)
def test_what_cannot_be_is_refused_and_the_old_one_kept(viewer, mechanism, values, words):
    before = viewer.configuration
    [answer] = asking(viewer, {"command": "set", "values": values, "id": 3})
    assert answer["type"] == "error"
    assert words in answer["message"]
    assert viewer.configuration is before


def test_while_one_page_waits_for_it_another_is_answered(viewer, monkeypatch):
    started, go_on = threading.Event(), threading.Event()

    def slow(shown, values):
        started.set()
        assert go_on.wait(20)
        return redesigned(shown, values)

    monkeypatch.setattr(hubs, "redesigned", slow)

    async def run():
        async with connected(viewer) as first, connected(viewer) as second:
            await first.read()
            await second.read()
            await first.send({"command": "set", "values": [None, 1.1, None, None], "id": 1})
            await asyncio.to_thread(started.wait, 20)
            moved = await second.ask({"command": "move", "values": [1.0], "id": 2})
            go_on.set()
            while (answer := await first.read())["id"] != 1:
                pass
            return moved, answer

    moved, answer = asyncio.run(run())
    assert moved["values"] == pytest.approx([1.0])
    # It is of the pose that the other page has gone to meanwhile.
    assert (answer["values"], answer["parameters"][1]) == (pytest.approx([1.0]), 1.1)


def test_modes_of_other_lengths_are_forgotten(viewer):
    async def run():
        async with connected(viewer) as page:
            await page.read()
            await page.send({"command": "find modes"})
            while (told := await page.read()).get("status") != "found":
                pass
            await page.send({"command": "set", "values": [None, 1.1, None, None]})
            while (told := await page.read())["type"] != "modes":
                pass
            return told

    told = asyncio.run(run())
    assert told["status"] == "unknown"
    assert "another one" in told["text"]


def test_python_shows_the_mechanism_with_other_parameters_too(viewer, mechanism):
    other = mechanism.with_parameters(l2=3.2).close([1.0])
    viewer.update(other)
    assert viewer.configuration is other
    with pytest.raises(pj.ArgumentError, match="this viewer shows"):
        viewer.update(pj.load("five_bar").home)


def test_siblings_differ_in_their_parameters_only(mechanism):
    assert is_sibling(mechanism, pj.load("four_bar", {"l1": 1.1}))
    assert not is_sibling(mechanism, pj.load("five_bar"))
    assert not is_sibling(mechanism, mechanism.with_tool("coupler_tip"))
