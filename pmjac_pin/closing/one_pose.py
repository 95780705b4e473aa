"""One pose by a recorded program: J_eq, where that is certain.

What is not certain is for others to say, by singular values.
"""

from __future__ import annotations

import ctypes
import struct
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from pmjac_pin.algebra.lane_programs import ThreadMemory
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.recorded_rates import DOUBTS, SPREAD
from pmjac_pin.model.twist_frame import FrameName, change_frame
from pmjac_pin.model.unit_turns import UNIT
from pmjac_pin.rates.factorisation import REFINED
from pmjac_pin.rates.rank_bounds import RankBounds
from pmjac_pin.values.arrays import Array, read_only

SURELY = 1.0 - 1e-3  # of a bound: what is nearer, singular values decide
_DOUBTS = struct.Struct(f"{DOUBTS}d")


@dataclass(frozen=True, slots=True, eq=False)
class KnownPose:
    """A closed pose where J_eq exists.

    Attributes
    ----------
    gap : float
        How far the loops are open, m.
    """

    gap: float
    _told: bytes
    _motors: int

    def J_eq(self, frame: FrameName) -> Array:
        """Return J_eq in a frame, shape (6, n), read-only."""
        count = 6 * self._motors
        numbers = np.frombuffer(self._told, offset=_DOUBTS.size)
        J_eq = numbers[:count].reshape(6, -1)
        if frame == "LOCAL_WORLD_ALIGNED":
            return J_eq
        position, rotation = (
            numbers[count : count + 3],
            numbers[count + 3 : count + 12].reshape(3, 3),
        )
        return read_only(change_frame(J_eq, frame, rotation, position))


class OnePose:
    """Knows closed poses of a mechanism.

    Parameters
    ----------
    library : ctypes.PyDLL
        The kernel.
    tape : Tape
        `RecordedRates.pose_tape`.
    problem : ClosureProblem
    model : pin.Model
    """

    __slots__ = ("_bounds", "_closed", "_model", "_motors", "_run", "_thread", "_whole")

    def __init__(
        self, library: ctypes.PyDLL, tape: Tape, problem: ClosureProblem, model: pin.Model
    ) -> None:
        partition = problem.partition
        self._run, self._thread = library.pmjac_run_once, ThreadMemory(tape)
        self._whole = ThreadMemory(replace(tape, stages=()))
        self._model = model if model.nq > model.nv else None  # else nothing has unit length
        self._motors, self._closed = partition.actuated.size, SURELY * problem.tolerance
        # Nearer to singular, rates are refined, which the program does not do.
        self._bounds = RankBounds.of(partition, SURELY, REFINED)

    def at(self, q: Array) -> KnownPose | None:
        """Return what is known at a q, None where that is not certain."""
        if self._model is not None and not pin.isNormalized(self._model, q, UNIT):
            return None
        inputs, outputs, argument = self._thread.numbers
        inputs[:] = q
        self._run(argument)
        told = outputs.tobytes()
        gap, inverse, size, forbidden, _, _, spread = _DOUBTS.unpack_from(told)
        certain = gap <= self._closed and self._bounds.regular(inverse, size)
        certain = certain and spread > SPREAD and self._bounds.follows(forbidden, size)
        return KnownPose(gap, told, self._motors) if certain else None

    def sizes(self, q: Array, frame: FrameName) -> Array | None:
        """Return `TwistMap.sizes` at a q that is known, shape (2,), read-only.

        None of twists of another point than the tool's; turned axes change no norm.
        """
        if frame == "WORLD":
            return None
        inputs, outputs, argument = self._whole.numbers
        inputs[:] = q
        self._run(argument)
        return read_only(outputs[-2:])
