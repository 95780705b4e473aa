"""The page under load: too many connections, searches and commands, and a parent that is gone."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from viewer_clients import connected, fetch

import pmjac_pin as pj
from pmjac_pin.viewer import serving
from pmjac_pin.viewer.door import most_connections
from pmjac_pin.viewer.worker import Worker

ROOT = Path(__file__).resolve().parent.parent
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
LINUX = pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs /proc")


@pytest.fixture
def viewer():
    with pj.view(pj.load("four_bar").home, open_browser=False, port=0) as viewer:
        yield viewer


def idle(port, stack):
    connection = stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=20))
    connection.settimeout(5)
    return connection


@LINUX
def test_idle_connections_keep_nobody_out(viewer, caplog):
    many = most_connections() + 20
    with contextlib.ExitStack() as stack:
        opened = [idle(viewer.port, stack) for _ in range(many)]
        assert fetch(viewer.url)[0] == 200
        assert len(list(Path("/proc/self/fd").iterdir())) < many + most_connections() + 100
        before = time.process_time()
        time.sleep(0.5)
        assert time.process_time() - before < 0.25
        assert opened[0].recv(1) == b""  # the oldest had to go
    assert not caplog.records


@LINUX
def test_few_file_descriptors():
    """Half of them stay free."""
    code = (
        "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64));"
        "from pmjac_pin.viewer.door import most_connections; print(most_connections())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, env=ENVIRONMENT, check=True
    )
    assert done.stdout == b"32\n"


def test_one_thread_does_only_the_newest():
    worker, begun, done, go = Worker("test worker"), [], threading.Event(), threading.Event()

    def first():
        begun.append(0)
        go.wait(10)

    worker.do(first)
    for number in range(1, 60):
        worker.do(lambda number=number: (begun.append(number), done.set()))
    names = [thread.name for thread in threading.enumerate()]
    assert names.count("test worker") == 1
    go.set()
    assert done.wait(10)
    assert begun == [0, 59]
    done.clear()
    worker.do(done.set)
    assert done.wait(10)


def test_many_searches_are_one_thread():
    import asyncio

    async def ask(viewer):
        async with connected(viewer) as page:
            for number in range(60):
                await page.send({"command": "find modes", "id": number})
            names = [thread.name for thread in threading.enumerate()]
            assert names.count("pmjac search") <= 1
            while True:
                message = await page.read()
                if message.get("type") == "modes" and message["status"] == "found":
                    return len(message["modes"])

    with pj.view(pj.load("four_bar").home, open_browser=False, port=0) as viewer:
        assert asyncio.run(ask(viewer)) == 2


def started(*argv, **options):
    """Run ``pmjac view`` by a shell or alone; returns the process and the page's address."""
    child = subprocess.Popen(
        argv, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=ENVIRONMENT, **options
    )
    line = child.stdout.readline()
    return child, re.search(rb"http://[\d.:]+/", line)[0].decode(), line


VIEW = f"{sys.executable} -m pmjac_pin view four_bar --no-browser --port 0"


def ended(pid, seconds):
    """Wait for a process that is not our child."""
    for _ in range(int(10 * seconds)):
        stat = Path(f"/proc/{pid}/stat")
        if not stat.exists() or stat.read_text().rsplit(")", 1)[1].split()[0] == "Z":
            return True
        time.sleep(0.1)
    return False


@pytest.fixture
def no_nohup():
    """The signals as a terminal's shell leaves them, though the tests run by `nohup` or by `&`."""
    before = {number: signal.getsignal(number) for number in (signal.SIGHUP, signal.SIGINT)}
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@LINUX
@pytest.mark.usefixtures("no_nohup")
@pytest.mark.parametrize(
    ("prefix", "stays"),
    [
        ("", False),
        ("& ", True),
        pytest.param("nohup ", True, marks=pytest.mark.slow),
        pytest.param("setsid ", True, marks=pytest.mark.slow),
    ],
)
def test_a_killed_parent(prefix, stays):
    """It ends, too, unless it was started to stay."""
    after = "" if prefix != "& " else "& wait"
    command = f"{'' if prefix == '& ' else prefix}{VIEW} {after}; true"
    # A session of its own has no terminal, in whose background these tests may run.
    shell, url, _ = started("sh", "-c", command, start_new_session=True)
    [pid] = map(int, Path(f"/proc/{shell.pid}/task/{shell.pid}/children").read_text().split())
    with shell.stdout, shell.stderr:
        try:
            shell.kill()
            shell.wait()
            assert ended(pid, 2.0 if stays else 10.0) is not stays
            if stays:
                assert fetch(url)[0] == 200
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)


@LINUX
@pytest.mark.usefixtures("no_nohup")
def test_in_the_background_of_a_terminal(monkeypatch):
    """A job of an interactive shell, as with `&` and perhaps `disown`, stays."""
    monkeypatch.setattr(serving.os, "getsid", lambda _: 0)
    monkeypatch.setattr(serving, "_is_in_background", lambda: True)
    assert serving._is_to_stay(1234)
    monkeypatch.setattr(serving, "_is_in_background", lambda: False)
    assert not serving._is_to_stay(1234)
    assert serving._is_to_stay(1)


def test_ctrl_c_under_load():
    """What the end cuts short is not reported as an error."""
    import asyncio

    child, url, _ = started(*VIEW.split())

    class Address:
        port = int(url.split(":")[2][:-1])

    async def flood():
        async with connected(Address) as page:
            with contextlib.suppress(Exception):
                for number in range(100_000):
                    values = [0.9 + 0.01 * (number % 10)]
                    text = json.dumps({"command": "move", "id": number, "values": values})
                    await page.socket.write_message(text)
                    if await page.socket.read_message() is None:
                        return

    async def run():
        floods = [asyncio.create_task(flood()) for _ in range(10)]
        await asyncio.sleep(1.0)
        child.send_signal(signal.SIGINT)
        await asyncio.wait(floods, timeout=10)

    with child.stdout, child.stderr:
        asyncio.run(run())
        assert child.wait(20) == 0
        assert child.stderr.read() == b""
