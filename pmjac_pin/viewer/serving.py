"""``pmjac view``: a page that is served until somebody interrupts it."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator

from pmjac_pin.configuration import Configuration
from pmjac_pin.terminal import write
from pmjac_pin.viewer.viewer import has_display, view

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


def serve_until_interrupted(
    configuration: Configuration, port: int | None = None, *, open_browser: bool
) -> None:
    """Serve the page, print its address, and return on Ctrl-C or SIGTERM.

    Raises
    ------
    PmjacError
        No port is free.
    """
    with _interruption() as interrupted:
        # Without a display a browser would be one for the terminal, and take it over.
        shown = open_browser and has_display()
        with view(configuration, open_browser=shown, port=port) as viewer:
            write(f"{configuration.mechanism.name}: {viewer.url} (Ctrl-C ends it)\n")
            interrupted.wait()
        write("\n")


@contextlib.contextmanager
def _interruption() -> Iterator[threading.Event]:
    """Yield an event that the signals set; afterwards they do again what they did before."""
    interrupted = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield interrupted  # only the main thread may handle signals
        return
    before = {number: signal.signal(number, lambda *_: interrupted.set()) for number in _SIGNALS}
    try:
        yield interrupted
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
