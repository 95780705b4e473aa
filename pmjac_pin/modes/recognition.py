"""Recognition: which of the assembly modes a pose is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.configuration import Configuration
from pmjac_pin.modes.distinct import Signatures
from pmjac_pin.modes.search_problem import search_problem, without_legs

Array = NDArray[np.float64]

SAME_MOTORS = 1e-9
"""Motor values nearer than this, in m or rad, are the same."""


class Recognition:
    """Knows assembly modes at the same motor values by the places of their bodies."""

    def __init__(self, modes: Sequence[Configuration]) -> None:
        self._modes = modes
        if not len(modes):
            return
        self._parts = modes[0].mechanism._parts
        self._problem, _ = search_problem(self._parts, modes[0].q)
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
        return int(same[0]) if same.size else None

    def _row(self, configuration: Configuration) -> Array:
        return without_legs(self._parts, self._problem, configuration.q)
