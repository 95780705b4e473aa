"""The map beside the picture: drawn beside the loop, of the pose of now or said to be stale."""

from __future__ import annotations

import asyncio
import threading

import numpy as np
import pytest
from mechanisms import loaded
from viewer_clients import connected

import pmjac_pin as pj
from pmjac_pin.viewer import slice_finder, slice_map
from pmjac_pin.viewer.design import redesigned
from pmjac_pin.viewer.messages import DrawSlice, MoveMotors, StopSlice
from pmjac_pin.viewer.scene_options import SceneOptions
from pmjac_pin.viewer.session import Session
from pmjac_pin.viewer.slice_finder import SliceFinder
from pmjac_pin.viewer.slice_map import CELLS


class Drawing:
    """A finder outside a server: its session, and what it told."""

    def __init__(self, name):
        self.session = Session(loaded(name).home, SceneOptions())
        self.told = []
        self.changed = asyncio.Event()
        self.finder = SliceFinder(self.session, self._tell)

    def _tell(self):
        self.told.append(self.finder.message().status)
        self.changed.set()

    async def drawn(self, first, second):
        self.finder.obey(DrawSlice(first=first, second=second))
        while self.finder.message().status == "drawing":
            self.changed.clear()
            await asyncio.wait_for(self.changed.wait(), 60)
        return self.finder.message()

    def now(self):
        self.finder.follow()
        message = self.finder.message()
        return message.status, message.text


@pytest.fixture(autouse=True)
def _quickly(monkeypatch):
    """Coarse grids, but for the five-bar's, which is drawn before."""
    monkeypatch.setattr(slice_map, "CELLS", 15)


@pytest.fixture(scope="module")
def five_bar():
    async def work():
        return await Drawing("five_bar").drawn("theta1", "theta2")

    return asyncio.run(work())


def elbows_apart(theta):
    """Of the catalogue's five-bar: pivots 0.3 apart, proximal links of 0.3."""
    first = 0.3 * np.array([np.cos(theta[..., 0]), np.sin(theta[..., 0])])
    second = 0.3 * np.array([np.cos(theta[..., 1]), np.sin(theta[..., 1])])
    second[0] += 0.3
    return np.linalg.norm(first - second, axis=0)


def test_reached_is_where_the_distal_links_meet(five_bar):
    """These are 0.4 long."""
    axes = [np.linspace(*ends, CELLS) for ends in zip(five_bar.lower, five_bar.upper, strict=True)]
    apart = elbows_apart(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1))
    told = np.array([[cell != "0" for cell in row] for row in five_bar.cells])
    sure = np.abs(apart - 0.8) > 1e-3
    assert sure.sum() > 1500
    np.testing.assert_array_equal(told[sure], (apart < 0.8)[sure])


def test_gain_is_where_they_are_stretched(five_bar):
    gained = [np.array(curve.places) for curve in five_bar.curves if curve.kind == "gain"]
    assert len(gained) == 2
    for places in gained:
        np.testing.assert_allclose(elbows_apart(places), 0.8, atol=1e-9)
    assert {curve.kind for curve in five_bar.curves} == {"gain", "loss"}


def test_it_says_when_it_is_no_map_of_this_pose():
    async def work():
        drawing = Drawing("planar_3rpr")
        session = drawing.session
        message = await drawing.drawn("l1", "l2")
        assert (message.status, message.plane) == ("drawn", ("l1", "l2"))
        assert "l3 = 0.34" in message.text
        session.obey(MoveMotors(values=[0.4, 0.45, None]))
        assert drawing.now()[0] == "drawn"
        session.obey(MoveMotors(values=[None, None, 0.36]))
        assert drawing.now() == ("stale", "Stale: Since this was drawn l3 moved. Draw it again.")
        session.obey(MoveMotors(values=[None, None, 0.34]))
        assert drawing.now()[0] == "drawn"
        session.show(session.mechanism.pose("mirrored"))
        assert "another mode" in drawing.now()[1]
        session.show(session.mechanism.home)
        assert drawing.now()[0] == "drawn"
        first, *others = session.mechanism.parameters.values()
        session.adopt(*redesigned(session.configuration, [1.01 * first, *map(float, others)]))
        assert "The mechanism is another one" in drawing.now()[1]
        assert drawing.told == ["drawing", *["drawn", "stale"] * 3][: len(drawing.told)]
        assert drawing.told[-1] == "stale"

    asyncio.run(work())


def test_a_click_follows_to_the_locus_and_no_further():
    """What a click beyond the map's border reaches is where the drawn curve is on the way."""

    async def work():
        drawing = Drawing("planar_3rpr")
        session = drawing.session
        message = await drawing.drawn("l1", "l2")
        start = session.configuration
        inside, beyond = [0.6, 0.6, None], [0.6, 0.1, None]
        session.obey(MoveMotors(values=inside))
        expected = start.mechanism.close([0.6, 0.6, 0.34], guess=start)
        np.testing.assert_allclose(session.configuration.q, expected.q, atol=1e-9)
        session.obey(MoveMotors(values=beyond))
        assert session.notice.kind == "stop"
        assert "This assembly mode goes no further" in session.notice.text
        stopped = session.configuration.actuated
        np.testing.assert_allclose(stopped[[0, 2]], [0.6, 0.34], atol=1e-9)
        assert _distance(stopped[:2], message.curves) < 1e-3
        assert drawing.now()[0] == "drawn"

    asyncio.run(work())


def _distance(place, curves):
    """From a place to the nearest chord of curves."""
    apart = []
    for curve in curves:
        points = np.array(curve.places)
        begin, way = points[:-1], np.diff(points, axis=0)
        share = np.einsum("ij,ij->i", place - begin, way) / np.einsum("ij,ij->i", way, way)
        nearest = begin + np.clip(share, 0.0, 1.0)[:, None] * way
        apart.append(np.linalg.norm(nearest - place, axis=1).min())
    return min(apart)


# --- through the server ----------------------------------------------------------------------


@pytest.fixture
def held(monkeypatch):
    """Hold every drawing until it is let go."""
    release, wanted, true = threading.Event(), [], slice_finder.draw_slice

    def draw(pose, start, motors, still_wanted):
        wanted.append(still_wanted)
        assert release.wait(20)
        return true(pose, start, motors, still_wanted)

    monkeypatch.setattr(slice_finder, "draw_slice", draw)
    yield release, wanted
    release.set()


async def told(page, kind, status=None):
    """Read up to a message of this kind, and of this status."""
    while True:
        message = await page.read()
        if message["type"] == kind and status in (None, message.get("status")):
            return message


DRAW = {"command": "draw slice", "first": "l2", "second": "l1", "id": 1}


def test_all_pages_get_the_map_and_are_answered_meanwhile(held):
    release, _ = held

    async def work(viewer):
        async with connected(viewer) as one, connected(viewer) as other:
            await one.send(DRAW)
            await told(other, "slice", "drawing")
            await other.send({"command": "move", "values": [0.4, None, None], "id": 2})
            assert (await told(one, "state"))["type"] == "state"
            release.set()
            found = await told(other, "slice", "drawn")
            assert found["plane"] == ["l2", "l1"]
            assert found["curves"]
            async with connected(viewer) as late:
                assert await told(late, "slice") == found

    with pj.view(loaded("planar_3rpr").home, open_browser=False, port=0) as viewer:
        asyncio.run(work(viewer))


def test_it_can_be_stopped_and_ends_with_the_viewer(held):
    _, wanted = held

    async def work(viewer):
        async with connected(viewer) as page:
            await page.send(DRAW)
            await told(page, "slice", "drawing")
            while not wanted:
                await asyncio.sleep(0.01)
            await page.send({"command": "stop slice", "id": 2})
            await told(page, "slice", "unknown")
            assert not wanted[0]()
            await page.send(DRAW)
            await told(page, "slice", "drawing")

    with pj.view(loaded("planar_3rpr").home, open_browser=False, port=0) as viewer:
        asyncio.run(work(viewer))


def test_what_is_wanted_no_more_is_not_drawn_to_the_end():
    async def work():
        drawing = Drawing("planar_3rpr")
        drawing.finder.obey(StopSlice())
        assert drawing.told == []
        motors, home = drawing.session.design.motors[:2], drawing.session.configuration
        found = slice_finder.draw_slice(home, home, motors, lambda: False)
        assert found.curves == ()

    asyncio.run(work())


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        ("theta", "theta2", "theta1"),
        ("theta1", "theta1", "two motors"),
        (1, "theta2", "not understood"),
        (None, "theta2", "not understood"),
        ("phi1", "theta2", "phi1"),
    ],
)
def test_what_are_no_two_motors_is_refused(first, second, words):
    async def work(viewer):
        async with connected(viewer) as page:
            await page.send({"command": "draw slice", "first": first, "second": second, "id": 5})
            assert words in (await told(page, "error"))["message"]

    with pj.view(loaded("five_bar").home, open_browser=False, port=0) as viewer:
        asyncio.run(work(viewer))


@pytest.mark.parametrize("beyond", [[0.6, 0.1, None], [None, None, 1.0]])
def test_where_a_motion_has_ended_its_mode_is_drawn(beyond):
    """Along the plane or across it; two modes meet there, and the map is of the one we are on."""

    async def work():
        drawing = Drawing("planar_3rpr")
        session = drawing.session
        session.obey(MoveMotors(values=beyond))
        assert session.configuration.singularity().is_singular
        message = await drawing.drawn("l1", "l2")
        assert message.status == "drawn"
        assert f"l3 = {session.configuration.actuated[2]:.4g}" in message.text
        assert _distance(session.configuration.actuated[:2], message.curves) < 1e-3
        session.obey(MoveMotors(values=session.mechanism.home.actuated.tolist()))
        np.testing.assert_allclose(session.configuration.q, session.mechanism.home.q, atol=1e-8)
        if beyond[2] is None:
            assert drawing.now()[0] == "drawn"

    asyncio.run(work())


def test_where_nothing_says_which_mode_it_is_words_say_so():
    async def work():
        drawing = Drawing("planar_3rpr")
        drawing.session.obey(MoveMotors(values=[0.6, 0.1, None]))
        drawing.session.show(drawing.session.configuration)
        message = await drawing.drawn("l1", "l2")
        assert message.status == "failed"
        assert "assembly modes meet at this pose" in message.text

    asyncio.run(work())
