"""A tiny browser for the tests of the viewer's server: requests and WebSockets on loopback."""

from __future__ import annotations

import asyncio
import contextlib
import json

from tornado.httpclient import AsyncHTTPClient, HTTPRequest
from tornado.websocket import websocket_connect


def fetch(url, **headers):
    """Return status, headers and body."""

    async def run():
        client = AsyncHTTPClient(force_instance=True)
        try:
            answer = await client.fetch(HTTPRequest(url, headers=headers), raise_error=False)
            return answer.code, answer.headers, answer.body
        finally:
            client.close()

    return asyncio.run(run())


class Page:
    """A connection to a WebSocket of the server."""

    def __init__(self, socket):
        self.socket = socket

    async def read(self):
        message = await asyncio.wait_for(self.socket.read_message(), 10)
        return json.loads(message) if isinstance(message, str) else message

    async def ask(self, message):
        """Send a message and return its answer."""
        await self.send(message)
        return await self.read()

    async def send(self, message):
        binary = isinstance(message, bytes)
        text = message if isinstance(message, str | bytes) else json.dumps(message)
        await self.socket.write_message(text, binary=binary)


@contextlib.asynccontextmanager
async def connected(viewer, path="control", **headers):
    host = f"127.0.0.1:{viewer.port}"
    headers = {"Origin": f"http://{host}", **headers}
    headers = {name: value for name, value in headers.items() if value is not None}
    socket = await websocket_connect(HTTPRequest(f"ws://{host}/{path}", headers=headers))
    try:
        yield Page(socket)
    finally:
        socket.close()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(_rest(socket), 2)


async def _rest(socket):
    """Read up to the end of the connection: then its socket is closed."""
    while await socket.read_message() is not None:
        pass
