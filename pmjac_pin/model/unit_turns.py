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

    __slots__ = ("_model", "_turning")

    def __init__(self, model: pin.Model) -> None:
        self._model = model
        self._turning = [joint for joint in list(model.joints)[1:] if joint.nq > joint.nv]

    def of(self, q: Array) -> Array:
        """Return q (N, nq) with turns of unit length, in a new array where a row is changed.

        Raises
        ------
        ArgumentError
        """
        if not self._turning:
            return q
        off = np.logical_or.reduce([_is_off(joint, q) for joint in self._turning])
        if not off.any():
            return q
        q = q.copy()
        for row in np.flatnonzero(off).tolist():
            q[row] = with_unit_turns(self._model, q[row])
        return q


def _is_off(joint: pin.JointModel, q: Array) -> Mask:
    """Tell in which rows a joint's turn is not of unit length, or may not be."""
    if (kind := kind_of(joint)) is None:  # Pinocchio alone knows which entries are a turn
        return np.ones(len(q), dtype=bool)
    turns = q[:, joint.idx_q + kind.slides : joint.idx_q + joint.nq]
    return np.asarray(np.abs(np.linalg.norm(turns, axis=1) - 1.0) > 0.5 * UNIT)
