"""Masses that can be simulated: programs want some of each body that moves, about each axis."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from pmjac_pin.files.joint_dialects import listed
from pmjac_pin.studies.export.plain_machine import PlainBody, PlainMachine

_SHARE_OF_MASS = 1e-4  # of the machine's mass, for a body without
_GYRATION = 0.1  # of the machine's length, for a body without
_NO_MOMENT = 1e-14  # kg m²: MuJoCo wants more than 1e-15
_SMALL_GYRATION = 1e-3  # of the machine's length: radius of gyration where a moment is 0


class Masses:
    """Makes up what bodies lack, and remembers of which.

    Parameters
    ----------
    machine : PlainMachine
    """

    def __init__(self, machine: PlainMachine) -> None:
        total = sum(body.inertia.mass for body in machine.bodies)
        self._mass = _SHARE_OF_MASS * (total or 1.0)
        self._length = machine.length
        self._without: list[str] = []
        self._thin: list[str] = []
        self._odd: list[str] = []

    def of(self, body: PlainBody) -> pin.Inertia:
        """Return the inertia of a body that moves, about its frame: its own where that will do."""
        inertia = body.inertia
        mass, lever = float(inertia.mass), inertia.lever.copy()
        moments, axes = np.linalg.eigh(inertia.inertia)
        if mass <= 0.0:
            self._without.append(body.name)
            mass, moments = self._mass, np.maximum(moments, self._of(self._mass, _GYRATION))
        elif moments[0] <= _NO_MOMENT:
            self._thin.append(body.name)
            moments = np.maximum(moments, self._of(mass, _SMALL_GYRATION))
        elif moments[0] + moments[1] >= moments[2]:
            return inertia
        if moments[0] + moments[1] < moments[2]:
            self._odd.append(body.name)
            moments[:2] += moments[2] - moments[0] - moments[1]
        return pin.Inertia(mass, lever, axes @ np.diag(moments) @ axes.T)

    def _of(self, mass: float, share: float) -> float:
        return mass * (share * self._length) ** 2

    def notes(self) -> Iterator[str]:
        """Yield what was made up."""
        if self._without:
            what = "bodies without mass, which cannot be simulated,"
            yield f"{what} have {self._mass:g} kg in the file: {listed(self._without)}"
        if self._thin:
            yield f"a moment of inertia is 0, and small in the file: {listed(self._thin)}"
        if self._odd:
            what = "moments of inertia are no body's (one exceeds the sum of the others)"
            yield f"{what}, and raised to be one's: {listed(self._odd)}"
