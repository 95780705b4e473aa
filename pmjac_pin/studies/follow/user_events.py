"""Where functions of a caller's change their sign on a path."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.studies.follow.course import Course
from pmjac_pin.studies.follow.crossings import located
from pmjac_pin.studies.follow.event import Event
from pmjac_pin.studies.follow.stretch import Stretch
from pmjac_pin.values.checks import as_number, check_callable

_LOOKS_A_STEP = 4  # of a step


@dataclass(frozen=True, slots=True, eq=False)
class UserEvents:
    """Functions of poses along a course, by their names."""

    course: Course
    functions: Mapping[str, Callable[[Configuration], float]]

    @classmethod
    def given(cls, course: Course, functions: object) -> UserEvents:
        """Return those that a caller gives, or say what is wrong with them."""
        if functions is None:
            return cls(course, {})
        if not isinstance(functions, Mapping):
            message = "events are functions of a configuration by their names"
            raise ArgumentError(f"{message}, got {quoted(functions)}")
        for name, function in functions.items():
            check_callable(function, f"event {quoted(name)}")
        return cls(course, {str(name): function for name, function in functions.items()})

    def events(self, stretch: Stretch) -> Iterator[Event]:
        """Yield what happens on a part of a path."""
        times = np.linspace(stretch.start.t, stretch.end.t, _LOOKS_A_STEP + 1).tolist()
        for name in self.functions:
            values = [self._value(name, stretch, t) for t in times]
            for k in range(_LOOKS_A_STEP):
                signs = np.sign(values[k]), np.sign(values[k + 1])  # products may underflow
                if signs[0] and signs[0] != signs[1]:
                    yield self._event(name, stretch, times[k], times[k + 1])

    def _event(self, name: str, stretch: Stretch, start: float, end: float) -> Event:
        t = located(partial(self._value, name, stretch), start, end)
        turn = "rises" if self._value(name, stretch, start) < 0.0 else "falls"
        how = (
            "through" if self._value(name, stretch, end) else "to"
        )  # where it goes on is not known
        pose = self.course.configuration(stretch.at(t).q)
        return Event("user", t, pose, f"{name} {turn} {how} zero", name)

    def _value(self, name: str, stretch: Stretch, t: float) -> float:
        pose = self.course.configuration(stretch.at(t).q)
        return as_number(self.functions[name](pose), f"event {quoted(name)}", np.inf)
