"""Judge: whether J_eq of a program holds at a pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.batches.one_by_one import jacobian_of_one
from pmjac_pin.batches.pieces import Piece
from pmjac_pin.batches.results import Statuses
from pmjac_pin.closing.recorded_rates import DOUBTS, SPREAD
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.twist_frame import FrameName
from pmjac_pin.rates.partition import Partition
from pmjac_pin.rates.rank_bounds import RankBounds
from pmjac_pin.values.arrays import Array, Mask

_BY_SINGLE_CALLS = 1e-4  # σ_min of K*, relative: above, rounding is that of 12 digits, unrefined
_FELT = 1e-13  # of the tool's motion: what idle motions may do to it by rounding


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """Judges poses of one mechanism.

    Attributes
    ----------
    mechanism : Mechanism
    partition : Partition
    """

    mechanism: Mechanism
    partition: Partition

    def judged(
        self, piece: Piece, poses: Array, found: Array, frame: FrameName
    ) -> tuple[Array, Statuses]:
        """Return J_eq (6, n, N) of what a tape found, where that is certain, else of single calls.

        What is found is the single calls' then.
        """
        partition, n = self.partition, len(self.mechanism.actuated)
        certain = certain_jacobians(partition, self.mechanism.problem.tolerance, found)
        J_eq = found[DOUBTS : DOUBTS + 6 * n]
        status = np.zeros(len(poses), dtype=np.int8)
        for index in piece.each(~certain):
            single, status[index] = jacobian_of_one(self.mechanism, poses[index], frame)
            J_eq[:, index] = np.ravel(single)
        return J_eq.reshape(6, n, -1), status


def certain_jacobians(partition: Partition, tolerance: Array | float, told: Array) -> Mask:
    """Tell where J_eq is certain by what a program says of it.

    Parameters
    ----------
    partition : Partition
    tolerance : float or ndarray, shape (N,)
        Of closed poses, m.
    told : ndarray, shape (DOUBTS or more, N)
        As `RecordedRates.jacobian_tape` says it.
    """
    gap, inverse, size, forbidden, felt, tool, spread = told[:DOUBTS]
    bounds = RankBounds.of(partition, weakest=_BY_SINGLE_CALLS)
    certain = bounds.regular(inverse, size) & bounds.follows(forbidden, size)
    certain &= (gap <= tolerance) & (felt <= _FELT * tool) & (spread > SPREAD)
    return np.asarray(certain & (not partition.isolated))
