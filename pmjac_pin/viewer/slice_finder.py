"""The map of two motors for the page: drawn in a thread of its own, while the page stays alive."""

from __future__ import annotations

from collections.abc import Callable
from typing import assert_never

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, unknown_name
from pmjac_pin.viewer.messages import DrawSlice, SliceCommand, Slider, StopSlice
from pmjac_pin.viewer.pursuit import Pursuit
from pmjac_pin.viewer.session import Session
from pmjac_pin.viewer.slice_map import SliceMap, draw_slice
from pmjac_pin.viewer.slice_message import SliceMessage


class SliceFinder(Pursuit[SliceMap | str]):
    """The map that pages show beside the picture, or why there is none; and if it is of now's pose.

    All but the drawing itself runs in the server's thread.

    Parameters
    ----------
    session : Session
    tell : callable
        Called, in the server's thread, whenever `message` has changed.
    """

    def __init__(self, session: Session, tell: Callable[[], None]) -> None:
        super().__init__("drawing")
        self._session = session
        self._tell = tell
        self._stale = ""
        self._seen: Configuration | None = None

    def message(self) -> SliceMessage:
        """Return what pages have to know."""
        if self.going:
            return SliceMessage(status="drawing", text="Drawing …")
        if self._found is None:
            return SliceMessage(status="unknown", text="")
        if isinstance(self._found, str):
            return SliceMessage(status="failed", text=self._found)
        area = self._found.drawn.area
        return SliceMessage(
            status="stale" if self._stale else "drawn",
            text=f"Stale: {self._stale} Draw it again." if self._stale else _in_words(self._found),
            plane=area.names,
            lower=tuple(area.lower.tolist()),
            upper=tuple(area.upper.tolist()),
            cells=self._found.cells,
            curves=self._found.curves,
        )

    def obey(self, command: SliceCommand) -> None:
        """Carry out a command of a page.

        Raises
        ------
        ArgumentError
            These are not two motors with a slider.
        """
        match command:
            case DrawSlice():
                motors = self._motor(command.first), self._motor(command.second)
                if command.first == command.second:
                    raise ArgumentError(f"a plane is two motors, got {command.first!r} twice")
                self._start(motors)
            case StopSlice():
                if self.going:
                    self.stop()
                    self._tell()
            case _:
                assert_never(command)

    def follow(self) -> None:
        """Take notice of where the session is now."""
        pose = self._session.configuration
        if not isinstance(self._found, SliceMap) or pose is self._seen:
            return
        before, self._seen = self._stale, pose
        self._stale = self._found.why_stale(pose)
        if self._stale != before:
            self._tell()

    def _motor(self, name: str) -> Slider:
        motors = {motor.name: motor for motor in self._session.design.motors}
        if name not in motors:
            raise unknown_name("motor", name, tuple(motors))
        return motors[name]

    def _start(self, motors: tuple[Slider, Slider]) -> None:
        self._stale = ""
        pose, start = self._session.configuration, self._session.start
        self._begin(lambda wanted: draw_slice(pose, start, motors, wanted))
        self._tell()

    def _refused(self, why: str) -> str:
        return why

    def _finish(self, found: SliceMap | str) -> None:
        self._found, self._seen = found, None
        self.follow()
        if not self._stale:
            self._tell()


def _in_words(found: SliceMap) -> str:
    """Say what a map shows, and what it rests on."""
    reached = sum(len(row) - row.count("0") for row in found.cells)
    cells = len(found.cells) ** 2
    cut = sum(not curve.complete for curve in found.curves)
    unfinished = f"; {cut} could not be followed to their ends" if cut else ""
    counts = {kind: sum(curve.kind == kind for curve in found.curves) for kind in ("gain", "loss")}
    held = ", ".join(f"{name} = {value:.4g}" for name, value in found.drawn.held.items())
    where = f", {held}" if held else ""
    return (
        f"This assembly mode{where}: {reached} of {cells} cells are reached; "
        f"curves of gain: {counts['gain']}, of loss: {counts['loss']}{unfinished}. "
        "What is smaller than a cell may be missed."
    )
