"""What the adapter uses of TSID, by its names, in NumPy: for machines on which it is not built.

As in its bindings, a matrix of one row comes back as a vector, and arrays that do not fit are
refused; as in its solver, costs are regularised by 1e-8 and redundant equalities end in status 4.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np


class _Constraint:
    def __init__(self, matrix, *vectors):
        self._matrix = np.array(matrix, dtype=float, ndmin=2)
        self.rows, self.cols = self._matrix.shape
        self._vectors = [np.array(vector, dtype=float, ndmin=1) for vector in vectors]
        if any(vector.shape != (self.rows,) for vector in self._vectors):
            raise ValueError("constraint sizes don't match")

    @property
    def matrix(self):
        return self._matrix[0].copy() if self.rows == 1 else self._matrix.copy()


class ConstraintEquality(_Constraint):
    def __init__(self, name, A, b):
        super().__init__(A, b)
        self.isEquality = True

    @property
    def vector(self):
        return self._vectors[0].copy()


class ConstraintInequality(_Constraint):
    def __init__(self, name, A, lb, ub):
        super().__init__(A, lb, ub)
        self.isEquality = False

    @property
    def lowerBound(self):
        return self._vectors[0].copy()

    @property
    def upperBound(self):
        return self._vectors[1].copy()


class ConstraintLevel:
    def __init__(self):
        self.constraints = []

    def append(self, weight, constraint):
        self.constraints.append((weight, constraint))


class HQPData:
    def __init__(self):
        self.levels = []

    def append(self, level):
        self.levels.append(list(level.constraints))


class SolverHQuadProgFast:
    """Of equalities alone: what is inequal is no question of the adapter's."""

    def __init__(self, name):
        self.name = name

    def solve(self, problem):
        hard, soft = problem.levels
        A, b = _stacked([(1.0, constraint) for _, constraint in hard])
        J, c = _stacked(soft, A.shape[1])
        if np.linalg.matrix_rank(A) < len(A):
            return SimpleNamespace(status=4, x=np.full(A.shape[1], np.nan))
        H = J.T @ J + 1e-8 * np.eye(A.shape[1])
        whole = np.block([[H, A.T], [A, np.zeros((len(A), len(A)))]])
        x = np.linalg.solve(whole, np.concatenate([J.T @ c, b]))[: A.shape[1]]
        return SimpleNamespace(status=0, x=x)


def _stacked(level, columns=None):
    assert all(constraint.isEquality for _, constraint in level)
    width = columns or level[0][1].cols
    blocks = [np.zeros((0, width)), *(np.sqrt(w) * one._matrix for w, one in level)]
    return np.vstack(blocks), np.concatenate([[], *(np.sqrt(w) * one.vector for w, one in level)])
