"""Viewer: a mechanism in the browser, moved from Python and from the page."""

from __future__ import annotations

import logging
import os
import sys
import webbrowser
from types import TracebackType
from typing import TYPE_CHECKING

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, PmjacError
from pmjac_pin.studies.follow.trajectory import Trajectory
from pmjac_pin.values.checks import as_flag, check_kind
from pmjac_pin.viewer.canvas import Canvas
from pmjac_pin.viewer.hub import Hub
from pmjac_pin.viewer.scene_options import SceneOptions
from pmjac_pin.viewer.server import Server
from pmjac_pin.viewer.session import Session
from pmjac_pin.viewer.static_scene import StaticScene

if TYPE_CHECKING:
    from typing import Self

_logger = logging.getLogger(__name__)


class Viewer:
    """A live page that shows a mechanism: made by `view`.

    Usable from any thread. Ends with `close`, with its ``with`` block, or with Python itself.

    Attributes
    ----------
    url : str
        Where the page is. It can be opened any number of times, on this machine only.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> mechanism = pj.load("four_bar")
    >>> with pj.view(mechanism.home, open_browser=False, port=0) as viewer:
    ...     viewer.update(mechanism.close([1.0]))
    ...     viewer
    Viewer(four_bar, 'http://127.0.0.1:...')
    >>> viewer
    Viewer(four_bar, closed)
    """

    def __init__(
        self, configuration: Configuration, options: SceneOptions, port: int | None = None
    ) -> None:
        session = Session(configuration, options)
        self._name = session.mechanism.name
        self._hub = Hub(session, Canvas())
        self._server = Server(self._hub, port)
        self.url = self._server.url

    @property
    def port(self) -> int:
        """The port of 127.0.0.1 on which the page is served."""
        return self._server.port

    @property
    def configuration(self) -> Configuration:
        """What is shown now: it changes when somebody moves a slider."""
        return self._hub.session.configuration

    def update(self, configuration: Configuration) -> None:
        """Show another configuration of the same mechanism, in all open pages.

        Raises
        ------
        ArgumentError
            It is of another mechanism, or no configuration.
        PmjacError
            The viewer has been closed.
        """
        if not isinstance(configuration, Configuration):
            kind = type(configuration).__name__
            raise ArgumentError(f"a viewer shows a Configuration, got a {kind}")
        self._server.call(lambda hub: hub.show(configuration))

    def play(self, trajectory: Trajectory) -> None:
        """Show a trajectory of the same mechanism: a slider of its parameter that plays.

        Raises
        ------
        ArgumentError
            It is of another mechanism, or no trajectory.
        PmjacError
            The viewer has been closed.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> bar = pj.load("four_bar")
        >>> with pj.view(bar.home, open_browser=False, port=0) as viewer:
        ...     viewer.play(pj.follow(bar, [[0.9], [2.0]]))
        ...     viewer.configuration.actuated.tolist()
        [0.9]
        """
        check_kind(trajectory, Trajectory)
        self._server.call(lambda hub: hub.play(trajectory))

    def save_html(self, path: str | os.PathLike[str]) -> None:
        """Write what is shown now as one self-contained file that needs no server.

        Parameters
        ----------
        path : str or path-like
            Replaced at once when the file is complete; left alone if it cannot be written.

        Raises
        ------
        OutputError
            The file cannot be written, or it is none but a folder, a device or a pipe.
        """
        self._still().save(path)

    def close(self) -> None:
        """End the server; return when it has ended. May be repeated."""
        self._server.stop()

    def wait(self) -> None:
        """Return when the viewer has been closed: for the end of a script, until Ctrl-C."""
        self._server.wait()

    @property
    def closed(self) -> bool:
        """Whether the server has ended."""
        return not self._server.running

    def _still(self) -> StaticScene:
        try:
            return self._server.call(lambda hub: hub.still())
        except PmjacError:
            if not self.closed:
                raise
            return self._hub.still()  # nothing changes any more

    def _repr_html_(self) -> str:
        """Return a still picture for a notebook: it is kept with the notebook."""
        live = f'<a href="{self.url}" target="_blank">live page</a>'
        return self._still().notebook_frame("a still picture" if self.closed else live)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"Viewer({self._name}, {'closed' if self.closed else repr(self.url)})"


def view(
    configuration: Configuration | Trajectory,
    *,
    open_browser: bool | None = None,
    port: int | None = None,
    linear: bool = True,
    angular: bool = False,
    force: bool = False,
    names: bool = True,
    velocity_polytope: bool = False,
    force_polytope: bool = False,
) -> Viewer:
    """Show a mechanism and its ellipsoids in the browser; return at once.

    Parameters
    ----------
    configuration : Configuration or Trajectory
        Of a trajectory its beginning is shown, with a slider of its parameter that plays it.
    open_browser : bool, optional
        When None: in an interactive session with a display; elsewhere the address is logged,
        which shows it on stderr.
    port : int, optional
        The first port to try, 7000 when None; 0 for any that is free.
    linear, angular, force : bool
        Which ellipsoids to draw at the tool.
    names : bool
        Whether to write the motors' names beside them.
    velocity_polytope, force_polytope : bool
        Whether to draw what the tool does within the rate, or effort, limits of each motor.

    Returns
    -------
    Viewer
        Its `url` is the page's. A script that ends takes the page with it: `wait` keeps both.

    Raises
    ------
    ArgumentError
    PmjacError
        No port is free.
    """
    if open_browser is not None:
        open_browser = as_flag(open_browser, "open_browser")
    options = SceneOptions(linear, angular, force, names, 1.0, velocity_polytope, force_polytope)
    shown = configuration[0] if isinstance(configuration, Trajectory) else configuration
    viewer = Viewer(shown, options, port)
    if isinstance(configuration, Trajectory):
        viewer.play(configuration)
    if _is_interactive() if open_browser is None else open_browser:
        _open_browser(viewer.url)
    elif open_browser is None:
        _logger.warning("%s: %s", shown.mechanism.name, viewer.url)
    return viewer


def has_display() -> bool:
    """Tell whether a browser's window could be seen."""
    return sys.platform in ("win32", "darwin") or any(
        os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY")
    )


def _is_interactive() -> bool:
    asked = hasattr(sys, "ps1") or bool(sys.flags.interactive)
    notebook = "ipykernel" in sys.modules  # shows the picture inline
    return asked and has_display() and not notebook


def _open_browser(url: str) -> None:
    try:
        opened = webbrowser.open(url)
    except (webbrowser.Error, OSError):
        opened = False
    if not opened:
        _logger.warning("no browser could be opened; the page is at %s", url)
