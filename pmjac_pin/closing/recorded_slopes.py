"""How Jacobians change along motions, by a recorded program: `SlopesAlongMotions`, sooner."""

from __future__ import annotations

import ctypes

import numpy as np

from pmjac_pin.algebra.lane_programs import ThreadMemory
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.kinematics.slopes import Slopes
from pmjac_pin.values.arrays import Array


class RecordedSlopes:
    """The same as `SlopesAlongMotions`.

    Parameters
    ----------
    library : ctypes.PyDLL
        The kernel.
    tape : Tape
        `RecordedRates.slopes_tape`.
    rows, nv : int
        Of the constraint Jacobian.
    """

    __slots__ = ("_nv", "_rows", "_run", "_thread")

    def __init__(self, library: ctypes.PyDLL, tape: Tape, rows: int, nv: int) -> None:
        self._run, self._thread = library.pmjac_run_once, ThreadMemory(tape)
        self._rows, self._nv = rows, nv

    def at(self, q: Array, motions: Array) -> Slopes:
        """Return how Jacobians change at a q (nq,) along the columns of motions (nv, k)."""
        inputs, outputs, argument = self._thread.numbers
        nq, nv, entries = q.size, self._nv, self._rows * self._nv
        constraint, tools = np.empty((motions.shape[1], self._rows, nv)), []
        inputs[:nq] = q
        for k, motion in enumerate(motions.T):
            inputs[nq:] = motion
            self._run(argument)
            told = np.array(outputs)
            constraint[k] = told[:entries].reshape(self._rows, nv)
            tools.append(told[entries:])
        return Slopes.of(constraint, tools)
