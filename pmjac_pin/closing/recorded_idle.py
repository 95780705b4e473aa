"""What idles at a pose, and motions that let it idle as little as they can, as programs.

Each passive column that K* has beyond its rank gives one idle motion, in which it moves by 1 and of
the kept columns those that are needed: of a rod that spins between two balls, those of its own
joints. Which these are is seen at closed poses; what all of them leave of the loops is told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.programs import zeros
from pmjac_pin.closing.closed import closed_point
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.nearby_poses import nearby
from pmjac_pin.rates.sparse_qr import Triangle, norm
from pmjac_pin.values.arrays import Array, Index

_TAKES_PART = 1e-9  # of the largest rate of an idle motion, without dimension


@dataclass(frozen=True, slots=True, eq=False)
class IdleColumn:
    """A passive column that K* does not need for its rank, and the kept ones that idle with it.

    Attributes
    ----------
    column : int
    others : ndarray of int
    """

    column: int
    others: Index


def idle_columns(problem: ClosureProblem, q: Array, kept: Index) -> tuple[IdleColumn, ...]:
    """Return the columns that are not kept, with those that idle with them at or near a pose."""
    partition = problem.partition
    passive = np.sort(partition.passive)
    rest = np.setdiff1d(passive, kept)
    takes_part = np.zeros((kept.size, rest.size), dtype=bool)
    for pose in (q, *nearby(problem, q)):
        scaled = closed_point(problem, pose).scaled
        K_kept = partition.factorise(scaled[:, kept], partition.size_of(scaled))
        rates = np.abs(K_kept.solve(scaled[:, rest]))
        takes_part |= rates > _TAKES_PART * np.maximum(1.0, rates.max(axis=0, initial=0.0))
    return tuple(
        IdleColumn(column, kept[part])
        for column, part in zip(rest.tolist(), takes_part.T, strict=True)
    )


def idle_motions(matrix: Numbers, idle: Sequence[IdleColumn]) -> tuple[Numbers, Any]:
    """Return a basis N (nv, d) of null K* and ‖K* N‖, of [K K*] (p, nv) without dimension."""
    motions, open_by = zeros(matrix.shape[1], len(idle)), list[Any]()
    for number, one in enumerate(idle):
        columns = matrix[:, [*one.others, one.column]]
        rows = [row for row in columns if not np.equal(row, 0.0).all()]
        count = one.others.size
        motions[one.column, number] = 1.0
        if not rows:
            continue
        triangle = Triangle.of(np.array(rows, dtype=object), count)
        motions[one.others, number] = -triangle.solve([count])[:, 0]
        open_by += triangle.matrix[triangle.left_over, count].tolist()
    return motions, norm(np.array(open_by, dtype=object))


def smallest(motions: Numbers, idle: Numbers) -> Numbers:
    """Return of motions (nv, b) what is at right angles to idle ones, (nv, d)."""
    count = idle.shape[1]
    triangle = Triangle.of(np.hstack([idle, motions]), count)
    shorter: Numbers = motions - idle @ triangle.solve(range(count, count + motions.shape[1]))
    return shorter
