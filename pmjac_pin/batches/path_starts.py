"""Path starts: where the paths of many poses begin."""

from __future__ import annotations

from typing import Any

import numpy as np

from pmjac_pin.batches.sound_rows import rows_of_q
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.values.arrays import Array


class PathStarts:
    """Where paths of one mechanism begin: all at one closed pose, or each at its own q.

    Parameters
    ----------
    mechanism : Mechanism
    """

    __slots__ = ("_last", "_mechanism")

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._last: tuple[Configuration | None, Array] = None, np.empty((0, 0))

    def of(self, guess: Any, count: int) -> tuple[Array, bool]:
        """Return as many rows of q, and whether it is known that the loops are closed there.

        Raises
        ------
        ArgumentError, UnknownNameError
        """
        pose = self._mechanism.pose(guess) if isinstance(guess, str) else guess
        if isinstance(pose, Configuration):
            last, rows = self._last  # of most calls, those of the call before
            if pose is not last or len(rows) != count:
                q = self.closed_q(pose)
                rows = np.broadcast_to(q, (count, q.size))
                self._last = pose, rows  # not read again: threads may ask at the same time
            return rows, True
        rows = rows_of_q(pose, self._mechanism.nq)
        if len(rows) != count:
            raise ArgumentError(f"{count} guesses expected, one for each target; got {len(rows)}")
        return rows, False

    def closed_q(self, pose: Configuration) -> Array:
        """Return its q; of another mechanism, seen to be closed in this one."""
        own = pose.mechanism is self._mechanism
        return pose.q if own else self._mechanism.configuration(pose.q).q
