"""Few poses of one mechanism, as `Batch` has many: by single calls, where recording does not pay.

Programs take as long to record as some tens of closings. A sweep over dimensions has a mechanism,
and so programs, for each of them, and often but a few poses.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from pmjac_pin.batches.at_poses import AtPoses, RatesWork
from pmjac_pin.batches.batch import Batch
from pmjac_pin.batches.closing import Closing
from pmjac_pin.batches.one_by_one import jacobian_of_one, measures_of_one
from pmjac_pin.batches.pieces import Piece
from pmjac_pin.batches.result_shapes import shapes_of
from pmjac_pin.batches.results import ManyMeasures, Status, Statuses
from pmjac_pin.batches.sound_rows import SoundRows
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.twist_frame import FrameName
from pmjac_pin.values.arrays import Array

# Closed while programs are made: so many, and more for each entry of loops' and tool's Jacobians.
_POSES, _POSES_PER_ENTRY = 10.0, 0.07
_MEASURES = tuple(shapes_of(ManyMeasures, 0, 0))  # names of arrays, in their order


class FewPoses(Batch):
    """Few poses of one mechanism: what `Batch` says of them, to rounding."""

    def __init__(self, mechanism: Mechanism) -> None:  # nothing is recorded
        # Bits must not depend on calls before: of one's own, its single calls are the first.
        self.mechanism, self.runs_on = replace(mechanism, _poses={}), "single calls"
        self._closing, self._sound = Closing(self.mechanism, None), SoundRows(self.mechanism)
        self._at_poses = _OneByOne(self.mechanism)


class _OneByOne(AtPoses):
    """Finds by single calls what `AtPoses` finds by programs."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism

    def jacobian(self, frame: FrameName) -> RatesWork:
        self._mechanism.need_tool()

        def work(piece: Piece, q: Array, J_eq: Array, status: Statuses) -> None:
            for k in range(len(q)):
                piece.go_on()
                J_eq[k], status[k] = jacobian_of_one(self._mechanism, q[k], frame)

        return work

    def ellipsoids(self) -> RatesWork:
        return self.measures()

    def measures(self) -> RatesWork:
        """Return what fills a piece of arrays that `ManyMeasures` has, or of the first of them."""
        self._mechanism.need_tool()
        return self._measure

    def _measure(self, piece: Piece, q: Array, *found: Any) -> None:
        arrays = dict(zip(_MEASURES, found, strict=False))
        for array in found:
            array[:] = np.nan if array.dtype == np.float64 else Status.CLOSED
        for k in range(len(q)):
            piece.go_on()
            for name, value in measures_of_one(self._mechanism, q[k]).items():
                if name in arrays:
                    arrays[name][k] = value


def batch_of(mechanism: Mechanism, poses: int) -> Batch:
    """Return what computes so many poses soonest."""
    partition = mechanism.problem.partition
    entries = (partition.row_scale.size + 6) * partition.column_scale.size
    few = poses < _POSES + _POSES_PER_ENTRY * entries
    return FewPoses(mechanism) if few else Batch(mechanism)
