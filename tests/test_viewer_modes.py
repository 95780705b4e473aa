"""The assembly modes in the live page: found beside the loop, gone to, void when motors move."""

from __future__ import annotations

import asyncio
import threading

import mechanisms
import numpy as np
import pytest
from mechanisms import loaded
from viewer_clients import connected

import pmjac_pin as pj
from pmjac_pin.viewer import mode_finder
from pmjac_pin.viewer.messages import FindModes, ShowMode, StopSearch
from pmjac_pin.viewer.mode_finder import ModeFinder
from pmjac_pin.viewer.scene_options import SceneOptions
from pmjac_pin.viewer.session import Session

LECTURE = [2 / 3, 3 / 5, 3 / 4]


class Finder:
    """A finder outside a server: what it told, and its session."""

    def __init__(self, configuration):
        self.session = Session(configuration, SceneOptions())
        self.told = []
        self.changed = asyncio.Event()
        self.finder = ModeFinder(self.session, self._tell)

    def _tell(self):
        self.told.append(self.finder.message())
        self.changed.set()

    def move(self, values):
        self.session.move(values)
        self.finder.follow()

    async def found(self):
        while self.finder.message().status == "searching":
            self.changed.clear()
            await asyncio.wait_for(self.changed.wait(), 60)
        return self.finder.message()


def running(work):
    """Run a test that needs a loop."""

    def test():
        asyncio.run(work())

    test.__doc__, test.__name__ = work.__doc__, work.__name__
    return test


@running
async def test_it_says_searching_then_what_was_found():
    finder = Finder(loaded("three_rps_ss").pose("lecture_a"))
    assert finder.finder.message().status == "unknown"
    finder.finder.obey(FindModes())
    assert finder.finder.message().status == "searching"
    message = await finder.found()
    assert [told.status for told in finder.told] == ["searching", "found"]
    assert [mode["number"] for mode in message.modes] == list(range(1, 9))
    assert message.text.startswith("8 assembly modes within the limits of the joints. That there")
    assert message.modes[message.current - 1]["poses"] == ("lecture_a",)


@running
async def test_showing_a_mode_goes_there_and_dragging_stays_on_it():
    mechanism = loaded("three_rps_ss")
    finder = Finder(mechanism.close(LECTURE, guess="lecture_a"))
    finder.finder.obey(FindModes())
    message = await finder.found()
    other = message.modes[message.current - 1]["mirror_image"]
    finder.finder.obey(ShowMode(number=other))
    finder.finder.follow()
    assert finder.finder.message().current == other
    shown = finder.session.configuration
    np.testing.assert_array_equal(shown.q, message.modes[other - 1]["q"])
    finder.move([0.7, 0.62, 0.74])
    expected = mechanism.close([0.7, 0.62, 0.74], guess=shown)
    np.testing.assert_allclose(finder.session.configuration.q, expected.q, atol=1e-9)


@running
async def test_a_mode_with_a_name_is_that_pose():
    finder = Finder(loaded("four_bar").home)
    finder.finder.obey(FindModes())
    message = await finder.found()
    names = {mode["number"]: mode["poses"] for mode in message.modes}
    assert names == {1: (), 2: ("home",)}
    poses = []
    for number in names:
        finder.finder.obey(ShowMode(number=number))
        finder.finder.follow()
        poses.append(finder.session.pose)
    assert poses == [None, "home"]
    assert finder.finder.message().status == "found"


@running
async def test_moved_motors_make_the_list_void():
    finder = Finder(loaded("four_bar").home)
    finder.finder.obey(FindModes())
    await finder.found()
    finder.move([1.0])
    message = finder.finder.message()
    assert (message.status, message.modes) == ("unknown", ())
    assert message.text == "The motors have moved since the modes were found."
    with pytest.raises(pj.ArgumentError, match="there is no mode 1 at these motor values"):
        finder.finder.obey(ShowMode(number=1))


@pytest.fixture
def held(monkeypatch):
    """Hold every search until it is let go, or until nobody wants it any more."""
    release, wanted, true = threading.Event(), [], mode_finder.find_modes

    def find(mechanism, theta, rng, limits, aim):
        wanted.append(aim.wanted)
        assert release.wait(20)
        return true(mechanism, theta, rng, limits, aim)

    monkeypatch.setattr(mode_finder, "find_modes", find)
    yield release, wanted
    release.set()


def test_a_move_cancels_a_search_and_its_answer_comes_to_nothing(held):
    release, wanted = held

    async def work():
        finder = Finder(loaded("four_bar").home)
        finder.finder.obey(FindModes())
        while not wanted:
            await asyncio.sleep(0.01)
        assert wanted[0]()
        finder.move([1.0])
        assert finder.finder.message().status == "unknown"
        assert not wanted[0]()
        release.set()
        await asyncio.sleep(0.2)
        assert [told.status for told in finder.told] == ["searching", "unknown"]

    asyncio.run(work())


def test_it_can_be_stopped_and_begun_anew(held):
    release, wanted = held

    async def work():
        finder = Finder(loaded("four_bar").home)
        finder.finder.obey(StopSearch())
        assert finder.told == []
        finder.finder.obey(FindModes())
        finder.finder.obey(StopSearch())
        assert finder.finder.message().status == "unknown"
        finder.finder.obey(FindModes())
        release.set()
        message = await finder.found()
        assert len(message.modes) == 2
        assert [asked() for asked in wanted] == [False, True]

    asyncio.run(work())


@running
async def test_a_machine_without_separate_modes_says_so():
    machine = loaded("planar_3rrr")
    loose = mechanisms.with_motors(machine, machine.actuated[:1])
    finder = Finder(loose.home)
    finder.finder.obey(FindModes())
    message = await finder.found()
    assert (message.status, message.modes) == ("failed", ())
    assert "the tool is moved by a passive motion" in message.text


@running
async def test_a_rod_that_spins_does_not_hide_the_mode():
    finder = Finder(mechanisms.rssr().home)
    finder.finder.obey(FindModes())
    message = await finder.found()
    assert message.current is not None


# --- through the server ----------------------------------------------------------------------


async def told(page, kind, status=None):
    """Read up to a message of this kind, and of this status."""
    while True:
        message = await page.read()
        if message["type"] == kind and status in (None, message.get("status")):
            return message


def test_the_page_is_answered_while_a_search_goes_on_and_all_pages_are_told(held):
    release, _ = held

    async def work(viewer):
        async with connected(viewer) as one, connected(viewer) as other:
            for page in (one, other):
                await told(page, "state")
            await one.send({"command": "find modes", "id": 1})
            assert (await told(other, "modes"))["status"] == "searching"
            await other.send({"command": "frame", "id": 2})
            assert (await told(other, "state"))["id"] in (None, 2)
            release.set()
            found = await told(other, "modes", "found")
            assert [mode["number"] for mode in found["modes"]] == [1, 2]
            await other.send({"command": "mode", "number": 1, "id": 3})
            assert (await told(one, "modes", "found"))["current"] in (1, 2)
            async with connected(viewer) as late:
                assert (await told(late, "modes"))["modes"] == found["modes"]

    with pj.view(loaded("four_bar").home, open_browser=False, port=0) as viewer:
        asyncio.run(work(viewer))
        assert viewer.configuration.actuated == pytest.approx([0.9])
        assert viewer.configuration.passive[0] < 0


@pytest.mark.parametrize("number", [0, 3, -1, "one", None])
def test_what_is_no_mode_is_refused(number):
    async def work(viewer):
        async with connected(viewer) as page:
            await told(page, "state")
            await page.send({"command": "mode", "number": number, "id": 5})
            assert (await told(page, "error"))["message"]

    with pj.view(loaded("four_bar").home, open_browser=False, port=0) as viewer:
        asyncio.run(work(viewer))


def test_closing_the_viewer_ends_the_search(held):
    _, wanted = held
    viewer = pj.view(loaded("four_bar").home, open_browser=False, port=0)

    async def work():
        async with connected(viewer) as page:
            await page.send({"command": "find modes", "id": 1})
            await told(page, "modes", "searching")
            while not wanted:
                await asyncio.sleep(0.01)

    with viewer:
        asyncio.run(work())
        assert wanted[0]()
    assert not wanted[0]()
