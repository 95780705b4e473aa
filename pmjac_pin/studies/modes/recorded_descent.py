"""What damped least squares of many starts takes, as two programs of a search problem.

The first is of a pose, of the scaled rows J = ∂η/∂v of the passive joints, the squares of their
sizes sⱼ = |J_j| on the diagonal of JᵀJ, the second of a step from there, with sizes
remembered and the damping λ:

    q ↦ |η|, JᵀJ, Jᵀη
    q, JᵀJ, Jᵀη, s', λ ↦ q ⊕ x, s, |x|,
    x = −E (E JᵀJ E + λ)⁻¹ E Jᵀη,  no longer than a stride,  E = 1/s,  s = max(s, a share of s').
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.programs import PROGRAMS, largest, objects, root, zeros
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.terms import Term
from pmjac_pin.closing.levenberg_marquardt import TINY_SQUARE
from pmjac_pin.kinematics.joint_steps import moved_by
from pmjac_pin.kinematics.recorded import recorded_rows
from pmjac_pin.rates.sparse_cholesky import Elimination, UpperPlace
from pmjac_pin.rates.sparse_qr import dot, norm
from pmjac_pin.studies.modes.passive_joints import FORGOTTEN, IDLE_COLUMN
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.values.arrays import Array, Mask

_MOST_PRODUCTS = 5_000  # of an elimination: programs of more take longer to write than they save
_NO_SIZE = 1e-150  # of a column: the joint moves nothing, and yet its size is divided by


class RecordedDescent(NamedTuple):
    """Two programs.

    Attributes
    ----------
    pose : Tape
        q ↦ |η|, then the entries of JᵀJ that are not zero by structure, then Jᵀη.
    step : Tape
        q, all of these but the first, sizes and damping ↦ q, sizes, and how long the step is.
    nq, unknowns : int
    """

    pose: Tape
    step: Tape
    nq: int
    unknowns: int


def recorded_descent(problem: SearchProblem, strides: Array) -> RecordedDescent | None:
    """Return the programs of a problem, None where they would be too long, or nothing is unknown.

    Parameters
    ----------
    problem : SearchProblem
    strides : ndarray, shape (m_p,)
        What one step may move each passive degree of freedom alone, m.
    """
    if not strides.size or _products(_tied(_felt(problem))) > _MOST_PRODUCTS:
        return None
    places: list[UpperPlace] = []

    def pose(q: Sequence[Term]) -> list[Any]:
        error, rows = _scaled_rows(problem, q)
        places.extend(_tied(np.not_equal(rows, 0.0).astype(bool)))
        normal = [dot(rows[:, one], rows[:, other]) for one, other in places]
        return [norm(error), *normal, *(dot(column, error) for column in rows.T)]

    nq = problem.model.nq
    tape = Tape.recorded(nq, pose)
    return RecordedDescent(tape, _step_tape(problem, strides, places), nq, strides.size)


def _felt(problem: SearchProblem) -> Mask:
    """Tell which rows feel which passive motions, those that move one of a loop's bodies alone."""
    loops, moved_by = problem.loops.loops, problem.tree.moved_by
    felt = np.zeros((loops.count, problem.model.nv), dtype=bool)
    for pair in loops.pairs:
        for rows, _ in pair.blocks:
            felt[rows] = moved_by[pair.first.joint] ^ moved_by[pair.second.joint]
    for row, coupling in loops.couplings.items():
        felt[row] = coupling.gradient != 0.0
    return felt[:, problem.partition.passive]


def _tied(felt: Mask) -> list[UpperPlace]:
    """Return which motions are felt by a row together."""
    together = np.triu(felt.T.astype(int) @ felt)
    return [(one, other) for one, other in np.argwhere(together).tolist()]


def _products(places: Sequence[UpperPlace]) -> int:
    return len(places) + Elimination.of(places).products


def _scaled_rows(problem: SearchProblem, q: Sequence[Term]) -> tuple[Numbers, Numbers]:
    """Record η in m, and its derivatives by the scaled passive motions."""
    partition = problem.partition
    residual, rates = recorded_rows(problem.loops.loops, q, problem.model.nv)
    scale = partition.row_scale[:, None] * partition.column_scale[partition.passive]
    return residual * partition.row_scale, rates[:, partition.passive] * scale


def _step_tape(problem: SearchProblem, strides: Array, places: Sequence[UpperPlace]) -> Tape:
    nq, unknowns = problem.model.nq, strides.size
    ends = np.cumsum([nq, len(places), unknowns, unknowns]).tolist()

    def step(inputs: Sequence[Term]) -> list[Any]:
        q, entries, downhill, before, [damping] = np.split(objects(inputs), ends)
        normal: dict[UpperPlace, Any] = dict(zip(places, entries.tolist(), strict=True))
        sizes = _column_sizes([normal.get((k, k), 0.0) for k in range(unknowns)], before)
        ease = [1.0 / size for size in sizes]
        eased = {(i, j): entry * ease[i] * ease[j] for (i, j), entry in normal.items()}
        for k in range(unknowns):
            eased[k, k] = eased.get((k, k), 0.0) + damping + TINY_SQUARE
        right = [entry * each for entry, each in zip(downhill, ease, strict=True)]
        found = Elimination.of(list(eased)).solve(eased, right)
        x = objects(-(each * one) for each, one in zip(ease, found, strict=True))
        length = norm(x / strides)
        return [*_after_step(problem, q, x / largest(length, 1.0)), *sizes, length]

    return Tape.recorded(ends[-1] + 1, step)


def _column_sizes(squares: Sequence[Any], before: Numbers) -> list[Any]:
    """Return the sizes of the columns: they shrink slowly, and none is tiny beside the others."""
    sizes = [
        largest(FORGOTTEN * old, root(square)) for old, square in zip(before, squares, strict=True)
    ]
    most = sizes[0]
    for size in sizes[1:]:
        most = largest(most, size)
    least = largest(IDLE_COLUMN * most, _NO_SIZE)
    return [largest(size, least) for size in sizes]


def _after_step(problem: SearchProblem, q: Numbers, x: Numbers) -> Numbers:
    """Record q ⊕ v of a step of the scaled passive motions."""
    partition = problem.partition
    v = zeros(problem.model.nv)
    v[partition.passive] = x * partition.column_scale[partition.passive]
    return moved_by(PROGRAMS, problem.tree.tree, q, v)
