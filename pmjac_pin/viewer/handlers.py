"""What the server answers to: the page and its files, meshcat's viewer, and two WebSockets.

A page of another site may try to reach this port through the user's browser. So every request
must name this server as its host, which DNS rebinding cannot, and must come from its own pages.
"""

from __future__ import annotations

import asyncio
import re
from pathlib import Path
from types import TracebackType

import tornado.web
import tornado.websocket
from tornado.iostream import IOStream

from pmjac_pin.viewer.browser_files import PAGE, TYPES, meshcat_files, page_files
from pmjac_pin.viewer.hub import Hub
from pmjac_pin.viewer.messages import MAXIMAL_MESSAGE

#: Beyond this a message is not even received: the connection ends with code 1009.
ABSURD_SIZE = 16 * MAXIMAL_MESSAGE

_MOST_SOCKETS = 128  # two a page

# meshcat's viewer styles its controls inline.
_POLICY = (
    "default-src 'self' data: blob:; script-src 'self'; "
    "style-src 'self' 'unsafe-inline'; connect-src 'self' data: ws://{host}; "
    "frame-ancestors 'self'; base-uri 'none'; form-action 'none'; object-src 'none'"
)


class Guarded(tornado.web.RequestHandler):
    """Refuses requests that name another host or come from another site's page."""

    def prepare(self) -> None:
        """Check before anything else is done."""
        hosts: frozenset[str] = self.settings["hosts"]
        host = self.request.headers.get_list("Host")
        origins = self.request.headers.get_list("Origin")
        own = len(host) == 1 and host[0].lower() in hosts
        if not own or any(origin != f"http://{host[0].lower()}" for origin in origins):
            raise tornado.web.HTTPError(403)

    def set_default_headers(self) -> None:
        """Let nobody else frame, guess at or keep what is sent."""
        host = self.settings["host"]
        self.set_header("Content-Security-Policy", _POLICY.format(host=host))
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("X-Frame-Options", "SAMEORIGIN")
        self.set_header("Cross-Origin-Resource-Policy", "same-origin")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cache-Control", "no-cache")
        self.clear_header("Server")


class Files(Guarded, tornado.web.StaticFileHandler):
    """The files of the page and of meshcat's viewer."""

    def get_content_type(self) -> str:
        """Return the type by the suffix, whatever the machine's own tables say."""
        kind = TYPES.get(Path(self.absolute_path or "").suffix, "application/octet-stream")
        return f"{kind}; charset=utf-8"


class Missing(Guarded):
    """Everything else."""

    def prepare(self) -> None:
        """Refuse strangers first, then say that there is nothing."""
        super().prepare()
        raise tornado.web.HTTPError(404)


class Browser(Guarded, tornado.websocket.WebSocketHandler):
    """A WebSocket of one of our own pages."""

    _stream: IOStream | None = None

    def initialize(self, hub: Hub) -> None:
        """Take what the application has for it."""
        self.hub = hub

    def check_origin(self, origin: str) -> bool:
        """Accept: `prepare` has already compared it with the host."""
        del origin
        return True

    def prepare(self) -> None:
        """Refuse what names no origin, too: every browser does."""
        super().prepare()
        if "Origin" not in self.request.headers:
            raise tornado.web.HTTPError(403)
        if len(self.settings["sockets"]) >= _MOST_SOCKETS:
            raise tornado.web.HTTPError(503)

    @property
    def stream(self) -> IOStream | None:
        """What it is connected by, once it is open."""
        return self._stream

    async def send(self, message: str | bytes) -> None:
        """Send, and wait until it is on its way."""
        await self.write_message(message, binary=isinstance(message, bytes))

    def open(self, *_: str, **__: str) -> None:
        """Keep the stream, to be able to end it for certain, and join the others."""
        self.set_nodelay(True)
        self._stream = self.ws_connection.stream if self.ws_connection else None
        self.settings["sockets"].add(self)
        self.join()

    def join(self) -> None:
        """Make itself known to the hub."""
        raise NotImplementedError

    def on_close(self) -> None:
        """Leave the others."""
        self.settings["sockets"].discard(self)
        self.hub.remove(self)

    def log_exception(
        self,
        typ: type[BaseException] | None,
        value: BaseException | None,
        tb: TracebackType | None,
    ) -> None:
        """Say nothing of what the end of the server has cut short."""
        if not isinstance(value, asyncio.CancelledError):
            super().log_exception(typ, value, tb)

    def forget(self) -> None:
        """Close the socket in a forked process; the connection lives on in this one."""
        if self._stream is not None and self._stream.socket is not None:
            self._stream.socket.close()

    def abort(self) -> None:
        """End the connection without waiting for the browser's farewell."""
        if self._stream is not None:
            self._stream.close()


class Page(Guarded):
    """``/``: the page itself."""

    def get(self) -> None:
        """Send it."""
        self.set_header("Content-Type", "text/html; charset=utf-8")
        self.finish((PAGE / "index.html").read_bytes())


class SceneSocket(Browser):
    """``/scene``: the drawing commands for meshcat's viewer."""

    def join(self) -> None:
        """Ask for the picture."""
        self.hub.add_scene(self, self.send)

    def on_message(self, message: str | bytes) -> None:
        """Ignore: meshcat's viewer speaks only when asked for an image."""


class ControlSocket(Browser):
    """``/control``: the page's commands, and what it shows."""

    def join(self) -> None:
        """Ask for the state."""
        self.hub.add_page(self, self.send)

    async def on_message(self, message: str | bytes) -> None:
        """Answer; the next message is read when the answer has gone."""
        try:
            await self.send(await self.hub.answer(self, message))
        except tornado.websocket.WebSocketClosedError:
            self.hub.remove(self)


def make_application(hub: Hub, port: int, sockets: set[Browser]) -> tornado.web.Application:
    """Return the application for a server on this port of 127.0.0.1; it keeps `sockets`."""
    names = "|".join(map(re.escape, page_files()))
    return tornado.web.Application(
        [
            (r"/", Page),
            (r"/scene", SceneSocket, {"hub": hub}),
            (r"/control", ControlSocket, {"hub": hub}),
            (f"/page/({names})", Files, {"path": str(PAGE)}),
            (r"/static/(main\.min\.js)", Files, {"path": str(meshcat_files())}),
        ],
        default_handler_class=Missing,
        host=f"127.0.0.1:{port}",
        hosts=frozenset({f"127.0.0.1:{port}", f"localhost:{port}"}),
        sockets=sockets,
        websocket_max_message_size=ABSURD_SIZE,
        log_function=lambda handler: None,
    )
