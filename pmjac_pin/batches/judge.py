"""Judge: whether J_eq of a program holds at a pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.batches.one_by_one import jacobian_of_one
from pmjac_pin.batches.pieces import Piece
from pmjac_pin.batches.results import Status, Statuses
from pmjac_pin.closing.recorded_rates import DOUBTS, SPREAD
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.twist_frame import FrameName
from pmjac_pin.rates.partition import Partition
from pmjac_pin.rates.rank_bounds import RankBounds
from pmjac_pin.values.arrays import Array, Mask

_BY_SINGLE_CALLS = 1e-4  # σ_min of K*, relative: above, rounding is that of 12 digits, unrefined
FELT = 1e-13  # of the tool's motion: what idle motions may do to it by rounding


@dataclass(frozen=True, slots=True, eq=False)
class Judge:
    """Judges poses of one mechanism.

    Attributes
    ----------
    mechanism : Mechanism
    """

    mechanism: Mechanism

    def settle(
        self,
        piece: Piece,
        poses: Array,
        certain: Mask,
        frame: FrameName,
        found: tuple[Array, Statuses],
    ) -> bool:
        """Leave J_eq (N, 6, n) of a program where it is certain; put single calls' elsewhere.

        Returns whether there are any of these.
        """
        J_eq, status = found
        status.fill(Status.CLOSED)
        if np.count_nonzero(certain) == certain.size:  # of masks NumPy's `all` is slower
            return False
        for index in piece.each(~certain):
            J_eq[index], status[index] = jacobian_of_one(self.mechanism, poses[index], frame)
        return True


def rank_bounds(partition: Partition) -> RankBounds:
    """Return what K* is asked to keep to."""
    return RankBounds.of(partition, weakest=_BY_SINGLE_CALLS)


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
    bounds = rank_bounds(partition)
    certain = bounds.regular(inverse, size) & bounds.follows(forbidden, size)
    certain &= (gap <= tolerance) & (felt <= FELT * tool) & (spread > SPREAD)
    return np.asarray(certain & (not partition.isolated))
