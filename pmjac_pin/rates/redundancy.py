"""Redundancy: how many of the loop equations are independent, and where the others come from.

The p rows of [K K*] have rank r, and p − r of them follow from the others. That number splits in
two, whatever the order of the loops: with rᵢ the rank of loop i's own pᵢ rows,

    p − r = Σ (pᵢ − rᵢ)  +  (Σ rᵢ − r)

The first part is inside loops (a planar loop closed in space), the second between loops that ask
for the same thing twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pmjac_pin.rates.partition import Partition, independent_rows
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True)
class LoopRank:
    """What the rows of one loop contribute.

    Attributes
    ----------
    rows, rank : int
        Its rows, and the rank of these alone.
    needed : int
        How much the rank of all rows drops without this loop.
    """

    rows: int
    rank: int
    needed: int

    @property
    def redundant_inside(self) -> int:
        """Rows that follow from the other rows of this loop."""
        return self.rows - self.rank


def loop_ranks(scaled: Array, loops: Sequence[slice], partition: Partition) -> tuple[LoopRank, ...]:
    """Return what each loop contributes to the rank of [K K*].

    Parameters
    ----------
    scaled : ndarray, shape (p, nv)
        The dimensionless [K K*].
    loops : sequence of slice
        The rows of each loop.
    partition : Partition

    Examples
    --------
    Two equal loops of two rows, one of which is zero: one row inside each, one between the two.

    >>> import numpy as np
    >>> rows = np.array([[1.0, 2.0, 1.0], [0.0, 0.0, 0.0]])
    >>> partition = Partition.from_matrices(np.vstack([rows, rows]), np.eye(6, 3), [0], [1, 2])
    >>> scaled = partition.scaled(np.vstack([rows, rows]))
    >>> loop_ranks(scaled, [slice(0, 2), slice(2, 4)], partition)[0]
    LoopRank(rows=2, rank=1, needed=0)
    """
    size = partition.size_of(scaled)

    def rank(matrix: Array) -> int:
        return partition.factorise(matrix, size).rank

    whole = rank(scaled)
    return tuple(
        LoopRank(
            rows.stop - rows.start,
            rank(scaled[rows]),
            whole - rank(np.delete(scaled, rows, axis=0)),
        )
        for rows in loops
    )


def dependent_rows(scaled: Array, partition: Partition) -> dict[int, tuple[int, ...]]:
    """Return rows that follow from the others, each with the rows that it follows from.

    Which rows of a dependency are called dependent is a choice (QR with pivoting, as for the rows
    that K and K* show); how many there are is not. A row that is zero follows from none.

    Parameters
    ----------
    scaled : ndarray, shape (p, nv)
        The dimensionless [K K*].
    partition : Partition
    """
    size = partition.size_of(scaled)
    kept = independent_rows(scaled, partition.factorise(scaled, size).rank)
    dropped = np.setdiff1d(np.arange(scaled.shape[0]), kept)
    shares = partition.factorise(scaled[kept].T, size).solve(scaled[dropped].T, kept.size)
    parts = np.abs(shares) * np.linalg.norm(scaled[kept], axis=1)[:, None]
    return {
        int(row): tuple(map(int, kept[part > partition.rank_tolerance * size]))
        for row, part in zip(dropped, parts.T, strict=True)
    }
