"""Door: lets connections in, as many as there is room for."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Collection

import tornado.httpserver
from tornado.iostream import IOStream

from pmjac_pin.viewer.handlers import Browser

_logger = logging.getLogger(__name__)

_MOST_CONNECTIONS = 256  # half of them WebSockets, of which `Browser` counts for itself
_LET_IN_AT_ONCE = 32  # let in before anything else gets its turn
_PAUSE = 1.0  # seconds, when the process has no file descriptors left


def most_connections() -> int:
    """Return how many to have open: few enough to leave half of all file descriptors free."""
    try:
        import resource  # noqa: PLC0415
    except ImportError:  # not on Windows
        return _MOST_CONNECTIONS
    allowed = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return _MOST_CONNECTIONS if allowed < 0 else min(_MOST_CONNECTIONS, max(8, allowed // 2))


class Door:
    """Accepts the connections to a socket and hands them to a server.

    Where there are too many, the one that has been open longest goes, unless it is a WebSocket:
    so whoever holds many open and says nothing keeps nobody out.

    Parameters
    ----------
    bound : socket
        Listening, non-blocking.
    server : tornado.httpserver.HTTPServer
    browsers : collection of Browser
        The WebSockets.
    """

    def __init__(
        self,
        bound: socket.socket,
        server: tornado.httpserver.HTTPServer,
        browsers: Collection[Browser],
    ) -> None:
        self._socket, self._server, self._browsers = bound, server, browsers
        self._loop = asyncio.get_running_loop()
        self._streams: list[IOStream] = []
        self._pause: asyncio.TimerHandle | None = None
        self._told = False  # that there is no room: once is enough
        self._most = most_connections()

    def open(self) -> None:
        """Let connections in."""
        self._pause = None
        self._loop.add_reader(self._socket, self._accept)

    def close(self) -> None:
        """Let nobody in any more."""
        if self._pause is not None:
            self._pause.cancel()
        self._loop.remove_reader(self._socket)

    def _accept(self) -> None:
        for _ in range(_LET_IN_AT_ONCE):
            try:
                connection, address = self._socket.accept()
            except (BlockingIOError, ConnectionAbortedError, InterruptedError):
                return
            except OSError as error:
                if not self._told:
                    _logger.warning("cannot let a browser in: %s", error.strerror)
                self._told = True
                self._close_oldest()
                # It would be called again at once, and as long as this lasts.
                self._loop.remove_reader(self._socket)
                self._pause = self._loop.call_later(_PAUSE, self.open)
                return
            self._make_room()
            stream = IOStream(connection)
            self._streams.append(stream)
            self._server.handle_stream(stream, address)

    def _make_room(self) -> None:
        self._streams = [stream for stream in self._streams if not stream.closed()]
        if len(self._streams) >= self._most:
            self._close_oldest()

    def _close_oldest(self) -> None:
        speaking = [browser.stream for browser in self._browsers]
        open_ones = (stream for stream in self._streams if not stream.closed())
        silent = (stream for stream in open_ones if stream not in speaking)
        if (oldest := next(silent, None)) is not None:
            oldest.close()
