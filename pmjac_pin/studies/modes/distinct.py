"""Distinct: which closed poses are the same machine in the same place.

Two rows of q are one pose where all bodies are: a turn of 2π and the sign of a quaternion do not
show there. Nor does what spins idly: what the loops let move with all motors locked, at every
pose, is left out of the comparison.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.kinematics.many import ManyPoses
from pmjac_pin.studies.modes.search_problem import SearchProblem

Array = NDArray[np.float64]

_SAME = 1e-5  # of the characteristic length, and rad: two roots that meet are known to √1e-12
_AT_REST = 1e-6  # rate of a body, beside that of an idle motion, that does not count as moving
_TRIED = 50  # closed poses among which the most regular is looked for


@dataclass(frozen=True, slots=True, eq=False)
class Signatures:
    """What tells poses apart: the bodies' positions and axes, without dimension."""

    tree: ManyPoses
    length: float
    at_rest: NDArray[np.bool_]

    @classmethod
    def of(cls, problem: SearchProblem, rows: Array) -> Signatures:
        """Return the signatures of a problem; its idle motions are those of a regular pose.

        Parameters
        ----------
        problem : SearchProblem
        rows : ndarray, shape (b, nq)
            Closed poses, of which the most regular is taken.
        """
        if not len(rows):
            rows = problem.base[None]
        idle, row = idle_motions(problem, rows)
        poses = problem.tree.poses(rows[row][None])
        mask = problem.tree.moved_by[:, None, :]
        angular = (poses.angular[0] * mask) @ idle
        linear = (poses.linear[0] * mask) @ idle
        linear -= np.cross(poses.positions[:, 0, :, None], angular, axis=1)
        still = np.abs(linear).max(axis=2, initial=0.0) <= _AT_REST
        turns = np.abs(angular).max(axis=(1, 2), initial=0.0) <= _AT_REST / problem.length
        axes = np.repeat(turns[:, None], 9, axis=1)
        return cls(problem.tree, problem.length, np.hstack([still, axes]).ravel())

    def __call__(self, q: Array) -> Array:
        """Return the signature of each row of q, shape (b, entries)."""
        poses = self.tree.poses(q)
        bodies, count = poses.positions.shape[:2]
        places = poses.positions.transpose(1, 0, 2) / self.length
        axes = poses.rotations.transpose(1, 0, 2, 3).reshape(count, bodies, 9)
        whole = np.concatenate([places, axes], axis=2).reshape(count, 12 * bodies)
        return whole[:, self.at_rest]

    @staticmethod
    def same(signatures: Array, known: Array) -> NDArray[np.bool_]:
        """Tell which of these signatures (b, entries) are that of one known pose."""
        return np.asarray(np.abs(signatures - known).max(axis=1, initial=0.0) <= _SAME)


def idle_motions(problem: SearchProblem, rows: Array) -> tuple[Array, int]:
    """Return the null space of K* (nv, k) at the row where it is smallest, and that row.

    Not more of it than idles at every pose: all rows may be beside a singularity.
    """
    K_star, sizes = scaled_passive(problem, rows[:_TRIED])
    _, values, right = np.linalg.svd(K_star)
    ranks = _ranks(problem, values, sizes)
    row = int(np.argmax(ranks))
    rank = max(int(ranks[row]), problem.columns.size - problem.idle)
    idle = np.zeros((problem.column_scale.size, problem.columns.size - rank))
    scale = problem.column_scale[problem.columns]
    idle[problem.columns] = scale[:, None] * right[row, rank:].T
    return idle, row


def isolated(problem: SearchProblem, rows: Array) -> NDArray[np.bool_]:
    """Tell at which closed poses (b, nq) nothing moves but what idles at every pose."""
    K_star, sizes = scaled_passive(problem, rows)
    values = np.asarray(np.linalg.svd(K_star, compute_uv=False), float)
    return np.asarray(_ranks(problem, values, sizes) >= problem.columns.size - problem.idle)


def scaled_passive(problem: SearchProblem, rows: Array) -> tuple[Array, Array]:
    """Return K* (b, p, m_p), dimensionless, at rows of q, and the sizes (b,) of [K K*] there."""
    _, jacobian = problem.loops.evaluate(rows)
    scaled = jacobian * problem.row_scale[:, None] * problem.column_scale
    return scaled[:, :, problem.columns], np.linalg.norm(scaled, axis=(1, 2))


def _ranks(problem: SearchProblem, values: Array, sizes: Array) -> Array:
    """Return the ranks that the mechanism's own tolerance gives."""
    return np.asarray((values > problem.rank_tolerance * sizes[:, None]).sum(axis=1))


class Distinct:
    """The poses met so far, each once, and how often each was met.

    Attributes
    ----------
    q : list of ndarray, shape (nq,)
    hits : list of int
    """

    def __init__(self, signatures: Signatures) -> None:
        self._signatures = signatures
        self._known: list[Array] = []
        self.q: list[Array] = []
        self.hits: list[int] = []

    def add(self, rows: Array) -> bool:
        """Count closed poses (b, nq); tell whether any of them is new."""
        signatures, before = self._signatures(rows), len(self.q)
        for index, known in enumerate(self._known):
            same = self._signatures.same(signatures, known)
            self.hits[index] += int(same.sum())
            rows, signatures = rows[~same], signatures[~same]
        while len(rows):
            same = self._signatures.same(signatures, signatures[0])
            self.q.append(rows[0])
            self._known.append(signatures[0])
            self.hits.append(int(same.sum()))
            rows, signatures = rows[~same], signatures[~same]
        return len(self.q) > before
