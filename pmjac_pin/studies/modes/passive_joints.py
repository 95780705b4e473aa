"""PassiveJoints: what damped least squares close in a search, by NumPy over many poses at once."""

from __future__ import annotations

import numpy as np

from pmjac_pin.closing.levenberg_marquardt import by_normal_equations, norms
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.values.arrays import Array

FORGOTTEN = 0.3  #: of how a joint moved the loops, in one step
IDLE_COLUMN = 1e-6  #: of the largest column of K*: one that is smaller moves the loops by nothing


class PassiveJoints:
    """The passive joints of many poses: what is to be closed.

    Each unknown is eased by what it moves the loops by (Marquardt's scaling), so that damping
    holds back no joint for moving the loops little: a platform's turn moves them by its own size
    only, however long its legs are.

    Attributes
    ----------
    stride : float
        The longest that one step may be, m.
    """

    __slots__ = ("_problem", "_scale", "_strides", "stride")

    solution = staticmethod(by_normal_equations)

    def __init__(self, problem: SearchProblem, strides: Array) -> None:
        self._problem, self._strides = problem, strides
        self._scale = problem.partition.column_scale[problem.partition.passive]
        self.stride = float(strides.max(initial=problem.length))

    def evaluate(self, q: Array) -> tuple[Array, Array]:
        """Return η in m and K* on the scaled columns."""
        partition = self._problem.partition
        residual, jacobian = self._problem.loops.evaluate(q)
        K_star = jacobian.take(partition.passive, axis=2)
        K_star *= partition.row_scale[:, None] * self._scale
        return residual * partition.row_scale, K_star

    def ease(self, q: Array, error: Array, rows: Array, before: Array | None) -> Array:
        """Return one by the sizes of K*'s columns.

        They shrink slowly on the way: a column that vanishes where the loops close would have its
        joint thrown about there.
        """
        sizes = np.sqrt(np.einsum("bij,bij->bj", rows, rows))
        if before is not None:
            sizes = np.maximum(FORGOTTEN / before, sizes)
        sizes = np.maximum(sizes, IDLE_COLUMN * sizes.max(axis=1, initial=0.0, keepdims=True))
        return np.asarray(1.0 / np.where(sizes > 0.0, sizes, 1.0))  # no joint may move the loops

    def fading(self, gap: Array) -> Array:
        """Return the gap, in strides."""
        return gap / self.stride

    def bounded(self, q: Array, step: Array) -> Array:
        """Return steps of the scaled columns, each no longer than a stride."""
        return np.asarray(step / np.maximum(norms(step / self._strides), 1.0)[:, None])

    def moved(self, q: Array, step: Array) -> Array:
        """Return q ⊕ v."""
        partition = self._problem.partition
        velocity = np.zeros((len(q), partition.column_scale.size))
        velocity[:, partition.passive] = step * self._scale
        return self._problem.tree.moved(q, velocity)
