"""Recognition: which of the assembly modes a pose is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.studies.modes.assembly_modes import AssemblyModes
from pmjac_pin.studies.modes.distinct import Signatures
from pmjac_pin.studies.modes.search_problem import search_problem
from pmjac_pin.values.arrays import Array

SAME_MOTORS = 1e-9
"""Motor values nearer than this, in m or rad, are the same."""


class Recognition:
    """Knows poses at the same motor values by the places of their bodies.

    Parameters
    ----------
    modes : sequence of Configuration
        Of AssemblyModes, all of a mode's poses are known as that mode.
    """

    def __init__(self, modes: Sequence[Configuration]) -> None:
        self._numbers: Sequence[int] = range(len(modes))
        if isinstance(modes, AssemblyModes):
            self._numbers = [index for index, ways in enumerate(modes.ways) for _ in range(ways)]
            modes = [pose for poses in modes.poses for pose in poses]
        self._modes = modes
        if len(modes) == 0:
            return
        self._problem = search_problem(modes[0].mechanism, modes[0].q)
        rows = np.array([self._row(mode) for mode in modes])
        self._signatures = Signatures.of(self._problem, rows)
        self._known = self._signatures(rows)

    def index(self, configuration: Configuration) -> int | None:
        """Return which of the modes this is, None where it is none of them."""
        if not len(self._modes):
            return None
        apart = np.abs(configuration.actuated - self._modes[0].actuated).max(initial=0.0)
        if apart > SAME_MOTORS:
            return None
        mine = self._signatures(self._row(configuration)[None])[0]
        same = np.flatnonzero(self._signatures.same(self._known, mine))
        return self._numbers[int(same[0])] if same.size else None

    def _row(self, configuration: Configuration) -> Array:
        return self._problem.without_legs(configuration.q)
