"""Actuation: which motor rates the loops allow, and what moves though no motor moves it.

With N a basis of null [K K*], the rates that the loops allow, mobility = dim N splits into the
motor rates that are possible (the rank of N's motor rows) and the passive motions that are free
with all motors locked (dim null K*).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, Index, ReadOnlyArrays, norm
from pmjac_pin.values.ties import first_largest, pivots


@dataclass(frozen=True, eq=False)
class Actuation(ReadOnlyArrays):
    """How the motors command the mechanism at one pose.

    Attributes
    ----------
    allowed : ndarray, shape (n, a)
        Columns span the motor rates that the loops allow; each has one motor of `sufficient` at 1
        and the others of these at 0.
    sufficient : ndarray of int, shape (a,)
        Motors whose rates determine those of the others.
    free : ndarray, shape (m_p, d)
        Columns span null K*: passive rates that are possible with all motors locked, largest
        entry 1, with as few joints in each as elimination gives.
    felt : ndarray of bool, shape (d,)
        Whether the tool is moved by each of them.
    felt_rank : int
        Dimension of the tool twists that they make.
    """

    allowed: Array
    sufficient: Index
    free: Array
    felt: NDArray[np.bool_]
    felt_rank: int


def analyse_actuation(
    constraint_jacobian: Array, tool_jacobian: Array, partition: Partition
) -> Actuation:
    """Read off the constraint Jacobian (p, nv) and the tool Jacobian (6, nv) of a closed pose.

    Examples
    --------
    One loop equation θ̇ = φ̇₁; φ̇₂ is idle, and the tool feels it.

    >>> import numpy as np
    >>> C, J = np.array([[1.0, -1.0, 0.0]]), np.eye(6, 3)
    >>> partition = Partition.from_matrices(C, J, [0], [1, 2])
    >>> actuation = analyse_actuation(C, J, partition)
    >>> actuation.allowed.tolist(), actuation.free.tolist(), actuation.felt.tolist()
    ([[1.0]], [[0.0], [1.0]], [True])
    """
    scaled, scaled_tool = (
        partition.scaled(constraint_jacobian),
        partition.scaled_tool(tool_jacobian),
    )
    size, tool_size = norm(scaled), norm(scaled_tool)
    actuated, passive = partition.actuated, partition.passive
    whole = partition.factorise(scaled, size)
    motors = partition.factorise(whole.null_space[actuated], 1.0)
    allowed, sufficient = sparse_basis(motors.left[:, : motors.rank])
    free = sparse_basis(partition.factorise(scaled[:, passive], size).null_space)[0]
    twists = scaled_tool[:, passive] @ free
    lengths, threshold = np.linalg.norm(twists, axis=0), partition.rank_tolerance * tool_size
    motor_scale, passive_scale = partition.column_scale[actuated], partition.column_scale[passive]
    return Actuation(
        allowed=motor_scale[:, None] * allowed / motor_scale[sufficient],
        sufficient=sufficient,
        free=_largest_one(passive_scale[:, None] * free),
        felt=lengths > threshold,
        felt_rank=partition.factorise(twists, tool_size).rank,
    )


def sparse_basis(columns: Array) -> tuple[Array, Index]:
    """Return another basis of the same space, and a row for each of its columns.

    That row is 1 in its column and 0 in the others: Gauss-Jordan elimination on the rows that QR
    with pivoting chooses. Motions that have no joint in common come apart.

    Examples
    --------
    >>> basis, pivots = sparse_basis(np.array([[1.0, 1.0], [1.0, -1.0], [2.0, 2.0]]))
    >>> basis.round(3).tolist(), pivots.tolist()
    ([[0.0, 0.5], [1.0, 0.0], [0.0, 1.0]], [1, 2])
    """
    count = columns.shape[1]
    if not count:
        return columns, np.zeros(0, dtype=np.intp)
    rows = pivots(columns.T, count)
    basis = np.asarray(np.linalg.solve(columns[rows].T, columns.T).T, dtype=np.float64)
    basis[np.abs(basis) < 1e-9 * np.abs(basis).max(axis=0)] = 0.0
    return basis, rows


def _largest_one(columns: Array) -> Array:
    largest = first_largest(columns) if columns.size else np.zeros(0, dtype=np.intp)
    scaled: Array = columns / columns[largest, np.arange(columns.shape[1])]
    return scaled
