"""The loops of a mechanism at one pose, as a program.

K* is taken on kept columns, which are independent where the ranks are from: idle motions rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from pmjac_pin.algebra.programs import Recording, Term
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.kinematics.loops import Loops
from pmjac_pin.kinematics.recorded import RecordedKinematics, record
from pmjac_pin.model.spec import Tool
from pmjac_pin.rates.partition import Partition
from pmjac_pin.rates.sparse_qr import Triangle, norm

Array = NDArray[np.float64]
Entries = NDArray[Any]
Index = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class RecordedLoops:
    """What programs are recorded of.

    Attributes
    ----------
    model : pin.Model
    loops : Loops
    tool : Tool
    partition : Partition
    kept : ndarray of int
        Passive columns, as many as K* has rank.
    """

    model: pin.Model
    loops: Loops
    tool: Tool
    partition: Partition
    kept: Index

    def kinematics(self, q: Sequence[Term]) -> RecordedKinematics:
        """Record the kinematics at entries of q."""
        return record(self.model, self.loops, self.tool, q)

    def scaled(self, rates: Entries) -> Entries:
        """Return ∂η/∂v (p, nv) without dimension."""
        scale = np.outer(self.partition.row_scale, self.partition.column_scale)
        scaled: Entries = rates * scale
        return scaled

    def point_tape(self) -> Tape:
        """Return (q, θ̇) ↦ (gap, ‖K*⁻¹‖, ‖[K K*]‖, Newton step, path velocity).

        The gap is in m; both motions are (nv,) in the units of v, the latter −K*⁻¹ K θ̇ beside θ̇.
        """
        nq, motors = self.model.nq, self.partition.actuated
        recording = Recording(nq + motors.size)
        q, rates = recording.inputs[:nq], np.array(recording.inputs[nq:], dtype=object)
        kinematics, scale = self.kinematics(q), self.partition.column_scale
        matrix = self.scaled(kinematics.rates)
        error = kinematics.residual * self.partition.row_scale
        driven = matrix[:, motors] @ (rates / scale[motors])
        count = self.kept.size
        whole = np.column_stack([matrix[:, self.kept], error, driven])
        triangle = Triangle.of(whole, count)
        newton, velocity = zeros(self.model.nv), zeros(self.model.nv)
        steps = triangle.solve([count, count + 1])
        newton[self.kept], velocity[self.kept] = -(steps * scale[self.kept, None]).T
        velocity[motors] = rates
        known = [norm(error), triangle.inverse_norm(), norm(matrix)]
        return Tape.of(recording, [*known, *newton, *velocity])


def zeros(*shape: int) -> Entries:
    """Return an array of the double 0, for numbers of a program."""
    found = np.empty(shape, dtype=object)
    found[...] = 0.0
    return found
