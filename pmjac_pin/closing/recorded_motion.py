"""What motor rates lead to at one pose, by a recorded program: `Motion`'s numbers, sooner."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np

from pmjac_pin.algebra.lane_programs import ThreadMemory
from pmjac_pin.algebra.programs import objects, zeros
from pmjac_pin.algebra.tangents import tangents
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.terms import Term
from pmjac_pin.closing.recorded_rates import RecordedRates
from pmjac_pin.kinematics.joint_steps import entry_rates
from pmjac_pin.rates.sparse_qr import Triangle
from pmjac_pin.values.arrays import Array


def motion_tape(loops: RecordedRates) -> Tape:
    """Return (q, θ̇) ↦ G (nv, n), Ġ θ̇ (nv,) and J Ġ θ̇ + J̇ G θ̇ (6,), where nothing idles.

    Of rows in the axes of bodies that move: where the loops are closed and stay so, K v = 0, these
    axes' own turning adds nothing to γ = K̇ v. The last in LOCAL_WORLD_ALIGNED.
    """
    recorder, partition, kept = loops.recorder, loops.partition, loops.kept
    motors, scale, count = partition.actuated, partition.column_scale, kept.size

    def make(inputs: Sequence[Term]) -> list[Any]:
        q, rates = objects(inputs[: recorder.nq]), objects(inputs[recorder.nq :])
        kinematics = recorder.at(q.tolist())
        matrix = loops.scaled(kinematics.rates)

        def following(columns: Any) -> Any:
            triangle = Triangle.of(np.hstack([matrix[:, kept], columns]), count)
            solved = triangle.solve(range(count, count + columns.shape[1]))
            return -solved * scale[kept][:, None]

        G = zeros(scale.size, motors.size)
        G[motors] = np.eye(motors.size)
        G[kept] = following(matrix[:, motors]) / scale[motors]
        v = G @ rates
        along = entry_rates(recorder.tree, q, v)
        of = [*kinematics.rates.ravel(), *kinematics.tool.ravel()]
        changes = objects(tangents(of, q.tolist(), along.tolist())).reshape(-1, scale.size) @ v
        opening, tool = changes[:-6] * partition.row_scale, changes[-6:]
        bias = zeros(scale.size)
        bias[kept] = following(opening[:, None])[:, 0]
        return [*G.ravel(), *bias, *(kinematics.tool @ bias + tool)]

    return loops.recordings.tape("motion", recorder.nq + motors.size, make)


class RecordedMotion:
    """Knows what motor rates lead to, at poses where J_eq is certain.

    Parameters
    ----------
    library : ctypes.PyDLL
        The kernel.
    tape : Tape
        `motion_tape`.
    nv, n : int
        Freedoms, and how many of them are motors'.
    """

    __slots__ = ("_run", "_shape", "_thread")

    def __init__(self, library: ctypes.PyDLL, tape: Tape, nv: int, n: int) -> None:
        self._run, self._thread, self._shape = library.pmjac_run_once, ThreadMemory(tape), (nv, n)

    def at(self, q: Array, rates: Array) -> tuple[Array, Array, Array]:
        """Return G (nv, n), Ġ θ̇ (nv,) and J Ġ θ̇ + J̇ G θ̇ (6,)."""
        inputs, outputs, argument = self._thread.numbers
        inputs[: q.size], inputs[q.size :] = q, rates
        self._run(argument)
        told: Array = np.frombuffer(outputs.tobytes())
        nv, n = self._shape
        return told[: nv * n].reshape(nv, n), told[nv * n : -6], told[-6:]
