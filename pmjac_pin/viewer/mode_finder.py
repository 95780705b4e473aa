"""The assembly modes for the page: found in a thread of their own, while the page stays alive."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import assert_never

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.studies.modes.aim import Aim
from pmjac_pin.studies.modes.assembly_modes import AssemblyModes
from pmjac_pin.studies.modes.find import find_modes
from pmjac_pin.studies.modes.recognition import SAME_MOTORS, Recognition
from pmjac_pin.viewer.messages import FindModes, Modes, ModesCommand, ShowMode, StopSearch
from pmjac_pin.viewer.pursuit import Pursuit
from pmjac_pin.viewer.session import Session
from pmjac_pin.words.modes_report import ModeReport, make_modes_report
from pmjac_pin.words.modes_tables import count, no_more

_UNSEEN, _CONFIDENCE, _MOST_STARTS = 2e-3, 0.99, 200_000
_MOTORS_MOVED = "The motors have moved since the modes were found."
_OTHER_LENGTHS = "The mechanism is another one since the modes were found."


@dataclass(frozen=True, eq=False)
class _SearchOutcome:
    """The outcome of a search; `modes` is None where it failed."""

    text: str
    modes: AssemblyModes | None = None
    reports: tuple[ModeReport, ...] = ()
    told: tuple[dict[str, object], ...] = ()
    recognition: Recognition | None = None

    @classmethod
    def of(cls, start: Configuration, seed: int, wanted: Callable[[], bool]) -> _SearchOutcome:
        """Search at the motor values of a pose, until nobody wants it any more."""
        mechanism, theta = start.mechanism, start.actuated
        aim = Aim(_UNSEEN, _CONFIDENCE, _MOST_STARTS, wanted=wanted)
        modes = find_modes(mechanism, theta, np.random.default_rng(seed), True, aim)
        report = make_modes_report(mechanism, theta, modes)
        text = f"{count(report)} {no_more(modes.evidence)}"
        told = tuple(mode.told() for mode in report.modes)
        return cls(text, modes, report.modes, told, Recognition(modes))


class ModeFinder(Pursuit[_SearchOutcome]):
    """What is known of the assembly modes at the session's motor values.

    All but the search itself runs in the server's thread. A motion of the motors makes the
    answer, or a search that is still going on, void.

    Parameters
    ----------
    session : Session
    tell : callable
        Called, in the server's thread, whenever `message` has changed.
    """

    def __init__(self, session: Session, tell: Callable[[], None]) -> None:
        super().__init__("search")
        self._session = session
        self._tell = tell
        self._theta = session.configuration.actuated
        self._mechanism = session.mechanism
        self._text = ""
        self._current: int | None = None
        self._searches = 0  # each has other random starts

    def message(self) -> Modes:
        """Return what pages have to know."""
        if self.going:
            return Modes(status="searching", text="Searching, from random starts …")
        if self._found is None:
            return Modes(status="unknown", text=self._text)
        text, modes = self._found.text, self._found.told
        if self._found.modes is None:
            return Modes(status="failed", text=text)
        return Modes(status="found", text=text, current=self._current, modes=modes)

    def obey(self, command: ModesCommand) -> None:
        """Carry out a command of a page.

        Raises
        ------
        ArgumentError
            There is no mode of this number at the motor values of now.
        """
        match command:
            case FindModes():
                self._start()
            case StopSearch():
                if self.going:
                    self._forget("")
            case ShowMode():
                self._show(command.number)
            case _:
                assert_never(command)

    def follow(self) -> None:
        """Take notice of where the session is now."""
        theta = self._session.configuration.actuated
        if self._session.mechanism is not self._mechanism:
            self._mechanism, self._theta = self._session.mechanism, theta
            if self.known:
                self._forget(_OTHER_LENGTHS)
        elif not np.allclose(theta, self._theta, rtol=0.0, atol=SAME_MOTORS):
            self._theta = theta
            if self.known:
                self._forget(_MOTORS_MOVED)
        elif (current := self._recognised()) != self._current:
            self._current = current
            self._tell()

    def _start(self) -> None:
        start, seed = self._session.configuration, self._searches
        self._searches += 1
        self._begin(lambda wanted: _SearchOutcome.of(start, seed, wanted))
        self._tell()

    def _finish(self, found: _SearchOutcome) -> None:
        self._found = found
        self._current = self._recognised()
        self._tell()

    def _refused(self, why: str) -> _SearchOutcome:
        return _SearchOutcome(why)

    def _forget(self, why: str) -> None:
        self.stop()
        self._found, self._current, self._text = None, None, why
        self._tell()

    def _show(self, number: int) -> None:
        modes = () if self._found is None else self._found.modes or ()
        if self._found is None or not 1 <= number <= len(modes):
            raise ArgumentError(f"there is no mode {number} at these motor values: find them first")
        names = self._found.reports[number - 1].poses
        mechanism = self._session.mechanism
        self._session.show(mechanism.pose(names[0]) if names else modes[number - 1])

    def _recognised(self) -> int | None:
        if self._found is None or self._found.recognition is None:
            return None
        index = self._found.recognition.index(self._session.configuration)
        return None if index is None else index + 1
