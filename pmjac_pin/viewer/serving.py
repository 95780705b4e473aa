"""``pmjac view``: a page that is served until somebody interrupts it."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Iterator

from pmjac_pin.configuration import Configuration
from pmjac_pin.viewer.viewer import has_display, view
from pmjac_pin.words.terminal import write

_EVERY = 0.5  # seconds between looks at whether the parent is still there
_STOPPING = (signal.SIGINT, signal.SIGTERM)


def serve_until_interrupted(
    configuration: Configuration, port: int | None = None, *, open_browser: bool
) -> None:
    """Serve the page, print its address, and return on Ctrl-C or SIGTERM.

    And when the process that started it has ended, such as a shell that was killed; unless it was
    started to stay: in the background, with nohup or with setsid.

    Raises
    ------
    PmjacError
        No port is free.
    """
    parent = os.getppid()
    stays = _is_to_stay(parent)
    with _interruption() as interrupted:
        # Without a display a browser would be one for the terminal, and take it over.
        shown = open_browser and has_display()
        with view(configuration, open_browser=shown, port=port) as viewer:
            write(f"{configuration.mechanism.name}: {viewer.url} (Ctrl-C ends it)\n")
            _wait(interrupted, parent, stays)
        write("\n")


def _wait(interrupted: threading.Event, parent: int, stays: bool) -> None:
    if stays:
        interrupted.wait()
    # A signal at the parent's end would come when the *thread* ends that started this process.
    while not interrupted.wait(_EVERY) and os.getppid() == parent:
        pass


def _is_to_stay(parent: int) -> bool:
    """Tell whether whoever started this process may end before it."""
    if not hasattr(os, "getsid") or parent <= 1:  # init's children, and containers
        return True
    hang_up_and_interrupt = (signal.SIGHUP, signal.SIGINT)
    ignored = (signal.getsignal(number) == signal.SIG_IGN for number in hang_up_and_interrupt)
    return any(ignored) or os.getsid(0) == os.getpid() or _is_in_background()


def _is_in_background() -> bool:
    try:
        terminal = os.open(os.ctermid(), os.O_RDONLY | os.O_NOCTTY)
    except OSError:  # there is no terminal
        return False
    try:
        return os.tcgetpgrp(terminal) != os.getpgrp()
    except OSError:
        return False
    finally:
        os.close(terminal)


@contextlib.contextmanager
def _interruption() -> Iterator[threading.Event]:
    """Yield an event that the signals set; afterwards they do again what they did before."""
    interrupted = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield interrupted  # only the main thread may handle signals
        return
    heard = [number for number in _STOPPING if signal.getsignal(number) != signal.SIG_IGN]
    before = {number: signal.signal(number, lambda *_: interrupted.set()) for number in heard}
    try:
        yield interrupted
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
