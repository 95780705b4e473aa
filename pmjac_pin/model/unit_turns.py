"""Unit turns: the quaternions and (cos, sin) in a q, which are of unit length."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from pmjac_pin.errors import ArgumentError
from pmjac_pin.model.joint_kinds import kind_of
from pmjac_pin.values.arrays import Array, Mask

UNIT = 1e-14  # how far they may be from unit length: rounding
NEARLY_UNIT = 1e-6  # what is nearer was of unit length before it was written in few digits


def with_unit_turns(model: pin.Model, q: Array) -> Array:
    """Return q (nq,) with turns of unit length; what is off by rounding stays as it is.

    Raises
    ------
    ArgumentError
        A quaternion or (cos, sin) is not nearly of unit length.
    """
    if pin.isNormalized(model, q, UNIT):
        return q
    if not pin.isNormalized(model, q, NEARLY_UNIT):
        raise ArgumentError("a quaternion or (cos, sin) in q is not of unit length")
    normalised: Array = pin.normalize(model, q)
    return normalised


class UnitRows:
    """The same of many q of one model.

    Parameters
    ----------
    model : pin.Model
    """

    __slots__ = ("_entries", "_model", "_unknown")

    def __init__(self, model: pin.Model) -> None:
        self._model = model
        turning = [joint for joint in list(model.joints)[1:] if joint.nq > joint.nv]
        kinds = [(joint, kind_of(joint)) for joint in turning]
        # Of joints of no known kind Pinocchio alone knows which entries are a turn.
        self._unknown = any(kind is None for _, kind in kinds)
        turns = [range(j.idx_q + k.slides, j.idx_q + j.nq) for j, k in kinds if k is not None]
        alike = [[turn for turn in turns if len(turn) == size] for size in (2, 4)]
        self._entries = [np.array(some, dtype=np.intp) for some in alike if some]

    def of(self, q: Array) -> Array:
        """Return q (N, nq) with turns of unit length, in a new array where a row is changed.

        Raises
        ------
        ArgumentError
        """
        rows, bad = self.sound(q)
        if bad is not None:
            with_unit_turns(self._model, q[bad.argmax()])  # raises
        return rows

    def sound(self, q: Array) -> tuple[Array, Mask | None]:
        """Return the same, and for which rows there is none; None where there is for all."""
        if not (self._unknown or self._entries):
            return q, None
        off = np.full(len(q), self._unknown)
        for entries in self._entries:
            off |= _is_off(q.take(entries, axis=1))
        if not off.any():
            return q, None
        q, bad = q.copy(), np.zeros(len(q), dtype=bool)
        for row in np.flatnonzero(off).tolist():
            try:
                q[row] = with_unit_turns(self._model, q[row])
            except ArgumentError:
                bad[row] = True
        return q, bad if bad.any() else None


def _is_off(turns: Array) -> Mask:
    """Tell in which rows one of the turns (N, t, k) is not of unit length, or may not be."""
    squares = np.einsum("ntk,ntk->nt", turns, turns)
    return np.asarray((np.abs(squares - 1.0) > UNIT).any(axis=1))
