"""Hub: brings the session's pose to every browser, and the browsers' commands to the session.

All of it runs in the server's thread, one thing at a time.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable, Iterable, Sequence
from functools import partial
from typing import Generic, TypeVar

from tornado.websocket import WebSocketClosedError

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import PmjacError
from pmjac_pin.studies.follow.trajectory import Trajectory
from pmjac_pin.viewer.canvas import Canvas
from pmjac_pin.viewer.design import redesigned
from pmjac_pin.viewer.messages import (
    Home,
    ModesCommand,
    NamedPose,
    Reframe,
    Refusal,
    SetParameters,
    ShowMode,
    SliceCommand,
    decode,
)
from pmjac_pin.viewer.mode_finder import ModeFinder
from pmjac_pin.viewer.page_state import page_state
from pmjac_pin.viewer.scene import solids_of
from pmjac_pin.viewer.session import Session
from pmjac_pin.viewer.slice_finder import SliceFinder
from pmjac_pin.viewer.static_scene import StaticScene
from pmjac_pin.words.plain import encoded

_MOST_TRIES = 3  # of other parameters, while other pages move the motors
_logger = logging.getLogger(__name__)

Send = Callable[[str | bytes], Awaitable[object]]
Message = TypeVar("Message", str, bytes)


class Outbox(Generic[Message]):
    """What one browser has still to be told: of every key only the newest.

    So a browser that reads slowly lags behind, but never makes the server's memory grow.
    """

    def __init__(self, send: Send, join: Callable[[list[Message]], list[Message]]) -> None:
        self._send = send
        self._join: Callable[[list[Message]], list[Message]] = join
        self._pending: dict[str, Message] = {}
        self._task: asyncio.Task[None] | None = None

    def put(self, messages: Iterable[tuple[str, Message]]) -> None:
        """Send these soon, in this order, together with whatever else waits."""
        for key, message in messages:
            self._pending.pop(key, None)
            self._pending[key] = message
        if self._pending and (self._task is None or self._task.done()):
            self._task = asyncio.get_running_loop().create_task(self._flush())

    def close(self) -> None:
        """Send nothing more."""
        self._pending.clear()
        if self._task is not None:
            self._task.cancel()

    async def _flush(self) -> None:
        with contextlib.suppress(WebSocketClosedError):  # it has gone away
            while self._pending:
                messages = self._join(list(self._pending.values()))
                self._pending.clear()
                for message in messages:
                    await self._send(message)


def _message_of(commands: list[bytes]) -> list[bytes]:
    """Return one message: the MessagePack array of these MessagePack values."""
    return [b"".join([b"\xdd", len(commands).to_bytes(4, "big"), *commands])]


class Hub:
    """Which browsers there are, and what they have to know.

    Parameters
    ----------
    session : Session
    canvas : Canvas
        Still empty.
    """

    def __init__(self, session: Session, canvas: Canvas) -> None:
        self.session = session
        self.canvas = canvas
        self._pages: dict[object, Outbox[str]] = {}
        self._scenes: dict[object, Outbox[bytes]] = {}
        self._modes = ModeFinder(session, partial(self._tell, "modes"))
        self._slice = SliceFinder(session, partial(self._tell, "slice"))
        self._finders: dict[str, ModeFinder | SliceFinder] = {
            "modes": self._modes,
            "slice": self._slice,
        }
        canvas.update(session.scene().items)

    def still(self) -> StaticScene:
        """Return what is shown now, framed anew."""
        return StaticScene.of(self.session, self.canvas)

    def add_page(self, page: object, send: Send) -> None:
        """Tell a page that has just been opened everything."""
        self._pages[page] = outbox = Outbox(send, list)
        outbox.put([("about", encoded(page_state(self.session, about=True, framing=True)))])
        known = (item for item in self._finders.items() if item[1].known)
        outbox.put((key, encoded(finder.message())) for key, finder in known)

    def add_scene(self, scene: object, send: Send) -> None:
        """Draw the whole picture in a meshcat viewer that has just been opened."""
        self._scenes[scene] = outbox = Outbox(send, _message_of)
        outbox.put(self.canvas.commands())

    def remove(self, browser: object) -> None:
        """Forget a page or a scene."""
        outbox = self._pages.pop(browser, None) or self._scenes.pop(browser, None)
        if outbox is not None:
            outbox.close()

    async def answer(self, page: object, message: str | bytes) -> str:
        """Carry out a page's message and return the answer; all others are told, too.

        Other parameters are tried in a thread of its own, while other pages are answered.
        """
        number = None
        try:
            command = decode(message)
            number = command.id
            if isinstance(command, Reframe):
                return encoded(page_state(self.session, number, framing=True))
            about, jump = False, isinstance(command, Home | NamedPose | ShowMode)
            if isinstance(command, ModesCommand):
                self._modes.obey(command)
            elif isinstance(command, SliceCommand):
                self._slice.obey(command)
            elif isinstance(command, SetParameters):
                await self._redesign(command.values)
                about = jump = True
            else:
                before = set(solids_of(self.session.options))
                self.session.obey(command)
                jump = jump or not set(solids_of(self.session.options)) <= before
            self._publish(page, about=about, jump=jump)
            return encoded(page_state(self.session, number, about=about, jump=jump))
        except PmjacError as error:
            return encoded(Refusal(number, str(error)))
        except Exception:
            _logger.exception("a command of the page failed")
            return encoded(Refusal(number, "the command failed; see the log of the server"))

    def close(self) -> None:
        """Give up what is still being computed."""
        for finder in self._finders.values():
            finder.stop()

    def show(self, configuration: Configuration) -> None:
        """Go to a configuration and tell all browsers."""
        design = self.session.design
        self.session.show(configuration)
        self._publish(None, about=self.session.design is not design, jump=True)

    def play(self, trajectory: Trajectory) -> None:
        """Go to the beginning of a trajectory and tell all browsers that it can be played."""
        self.session.play(trajectory)
        self._publish(None, about=True, jump=True)

    async def _redesign(self, values: Sequence[float | None]) -> None:
        for _ in range(_MOST_TRIES):
            shown = self.session.configuration
            found = await asyncio.to_thread(redesigned, shown, values)
            if self.session.configuration is shown:
                break
        self.session.adopt(*found)

    def _publish(self, asking: object, *, about: bool, jump: bool) -> None:
        changed = self.canvas.update(self.session.scene().items)
        for scene in self._scenes.values():
            scene.put(changed)
        others = [box for page, box in self._pages.items() if page is not asking]
        if others:
            state = encoded(page_state(self.session, about=about, jump=jump))
            for other in others:
                other.put([("about" if about else "state", state)])
        for finder in self._finders.values():
            finder.follow()

    def _tell(self, key: str) -> None:
        message = encoded(self._finders[key].message())
        for page in self._pages.values():
            page.put([(key, message)])
