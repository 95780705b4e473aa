"""Server: a thread of this process with a loop of its own, on 127.0.0.1 only.

No process is started, so nothing can outlive this one.
"""

from __future__ import annotations

import asyncio
import atexit
import concurrent.futures
import contextlib
import errno
import logging
import os
import socket
import threading
import weakref
from collections.abc import Callable
from numbers import Integral
from typing import TypeVar

import tornado.httpserver
import tornado.ioloop

from pmjac_pin.errors import ArgumentError, PmjacError, quoted
from pmjac_pin.viewer.door import Door
from pmjac_pin.viewer.handlers import ABSURD_SIZE, Browser, make_application
from pmjac_pin.viewer.hub import Hub

_logger = logging.getLogger(__name__)

Result = TypeVar("Result")

ADDRESS = "127.0.0.1"
DEFAULT_PORT = 7000
_ATTEMPTS = 100
_PATIENCE_SECONDS = 5.0  # seconds
_DESCRIPTORS = 8  # of files, that a loop and its first connection need
_LARGEST_BODY = 1024  # bytes: no request of ours has any
_IDLE_SECONDS = 30.0  # seconds


class Server:
    """Serves the page from construction to `stop`.

    Parameters
    ----------
    hub : Hub
        Touched only by the server's thread from now on; see `call`.
    port : int, optional
        Where to start looking for a free port, 7000 when None; 0 for any.

    Attributes
    ----------
    port : int
    url : str

    Raises
    ------
    ArgumentError
        No such port.
    PmjacError
        None of the ports is free.
    """

    def __init__(self, hub: Hub, port: int | None = None) -> None:
        wanted = DEFAULT_PORT if port is None else port
        self._socket = _bind(wanted)
        self.hub = hub
        self.port: int = self._socket.getsockname()[1]
        self.url = f"http://{ADDRESS}:{self.port}/"
        if wanted not in (0, self.port):
            _logger.warning("port %d is in use: serving on %d", wanted, self.port)
        self._ready = threading.Event()
        self._failure: BaseException | None = None
        try:
            self._loop = _new_loop()
        except OSError as error:
            self._socket.close()
            raise PmjacError(f"the viewer cannot start: {error.strerror}") from None
        self._finish: asyncio.Event | None = None
        self._browsers: set[Browser] = set()
        name = f"pmjac viewer {self.port}"
        self._thread = threading.Thread(target=self._serve, name=name, daemon=True)
        self._thread.start()
        self._ready.wait()
        if self._failure is not None:
            raise self._failure
        atexit.register(self.stop)
        _servers.add(self)

    @property
    def running(self) -> bool:
        """Whether it still serves."""
        return self._thread.is_alive() and not self._loop.is_closed()

    def call(self, function: Callable[[Hub], Result]) -> Result:
        """Run a function in the server's thread and return what it returns.

        Raises
        ------
        PmjacError
            The server has been stopped.
        """
        future: concurrent.futures.Future[Result] = concurrent.futures.Future()

        def run() -> None:
            try:
                future.set_result(function(self.hub))
            except BaseException as error:
                future.set_exception(error)

        closed = PmjacError("the viewer has been closed")
        if not self.running:
            raise closed
        try:
            self._loop.call_soon_threadsafe(run)
        except RuntimeError:  # closed meanwhile
            raise closed from None
        while not future.done() and self.running:
            concurrent.futures.wait([future], timeout=0.1)
        if not future.done():
            raise closed
        return future.result()

    def stop(self) -> None:
        """End thread, connections and loop; return when they have ended. May be repeated."""
        atexit.unregister(self.stop)
        # Without a lock: a signal handler may close what its own thread is just closing.
        if self.running and self._finish is not None:
            with contextlib.suppress(RuntimeError):  # it has ended meanwhile
                self._loop.call_soon_threadsafe(self._finish.set)
            self._thread.join(_PATIENCE_SECONDS)

    def wait(self) -> None:
        """Return when the server has ended."""
        self._thread.join()

    def forget(self) -> None:
        """Close, in a process forked from this one, what belongs to this one."""
        self._socket.close()
        for browser in self._browsers:
            browser.forget()

    def _serve(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_until_complete(self._main())
        except BaseException as error:
            self._failure = error
            _logger.exception("the viewer's server failed")
        finally:
            self._socket.close()
            # Tornado keeps a table of loops; closing through it leaves no entry behind.
            tornado.ioloop.IOLoop.current().close()
            asyncio.set_event_loop(None)
            self._ready.set()

    async def _main(self) -> None:
        self._finish = asyncio.Event()
        application = make_application(self.hub, self.port, self._browsers)
        server = tornado.httpserver.HTTPServer(
            application,
            max_body_size=_LARGEST_BODY,
            max_buffer_size=2 * ABSURD_SIZE,
            body_timeout=_PATIENCE_SECONDS,
            idle_connection_timeout=_IDLE_SECONDS,
        )
        door = Door(self._socket, server, self._browsers)
        door.open()
        self._ready.set()
        await self._finish.wait()
        self.hub.close()
        door.close()
        for browser in list(self._browsers):
            browser.close(1001, "the viewer has been closed")
        await asyncio.sleep(0.02)  # for the closing frames to go out
        for browser in list(self._browsers):
            browser.abort()
        await server.close_all_connections()
        await _cancel_others()


async def _cancel_others() -> None:
    tasks = asyncio.all_tasks() - {asyncio.current_task()}
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


def _new_loop() -> asyncio.AbstractEventLoop:
    """Return a loop, once there are file descriptors for it: half made, it cannot be closed."""
    spare: list[int] = []
    try:
        while len(spare) < _DESCRIPTORS:
            spare.append(os.open(os.devnull, os.O_RDONLY))
    finally:
        for descriptor in spare:
            os.close(descriptor)
    return asyncio.new_event_loop()


_servers: weakref.WeakSet[Server] = weakref.WeakSet()


def _forget_all() -> None:
    for server in list(_servers):
        server.forget()


if hasattr(os, "register_at_fork"):
    # Or the port would stay in use for as long as the child lives.
    os.register_at_fork(after_in_child=_forget_all)


def _bind(first: int) -> socket.socket:
    """Bind the first free port from this one on, 0 for any."""
    if isinstance(first, bool) or not isinstance(first, Integral) or not 0 <= first <= 65535:
        raise ArgumentError(f"a port is a whole number from 0 to 65535, got {quoted(first)}")
    first = int(first)
    last = min(first + _ATTEMPTS, 65536) if first else 1
    for port in range(first, last):
        try:
            return _listen(port)
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise PmjacError(f"cannot listen on port {port}: {error.strerror}") from None
    raise PmjacError(f"none of the ports {first} to {last - 1} is free")


def _listen(port: int) -> socket.socket:
    bound = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        if os.name == "posix":  # elsewhere it would let two programs share the port
            bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        bound.bind((ADDRESS, port))
        bound.listen(128)
        bound.setblocking(False)
    except BaseException:
        bound.close()
        raise
    return bound
