"""Idling: what moves at every pose with all motors locked, and what that leaves at rest.

A motion idles if it is in the null space of K* at every pose, not at one: a rod that spins about
itself moves no point of its line, which is plain where the rod stands along an axis and where it
does not. So what idles is looked at in several regular poses, each of them also after it has
idled for a while, where nothing is in line by chance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pmjac_pin.kinematics.many import WorldPoses
from pmjac_pin.studies.modes.search import ManyClosures
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.values.arrays import Array, Mask

_TRIED = 24  # closed poses that are looked at
_TURNS = 2  # how often each of them idles for a while
_REGULAR = 1e-2  # of the size of [K K*]: the worse, the less is known of what idles
_STEP = 1e-4  # of an idle motion, rad or lengths
_AT_REST = 1e-5  # what an idle motion of one changes, and does not count as moved
_SAME = 1e-5  # two roots that meet are known to √1e-12
_ROUND = 4.0  # rates by which what idles once around may be off
_LOOSE = 10.0  # gaps that stay, by which bodies that idle together may be off


@dataclass(frozen=True, slots=True, eq=False)
class Idling:
    """What the idle motions of a problem move.

    Attributes
    ----------
    problem : SearchProblem
    steps : tuple of (WorldPoses, WorldPoses)
        Regular poses, moved a little forth and back along each idle motion.
    looseness : float
        By how much, without dimension, what idles together may be off while it does: loops with
        redundant rows, of a model with rounded numbers, stay open by something.
    """

    problem: SearchProblem
    steps: tuple[tuple[WorldPoses, WorldPoses], ...]
    looseness: float

    @classmethod
    def of(cls, problem: SearchProblem, rows: Array) -> Idling:
        """Return what idles in a problem, by some of its closed poses (b, nq)."""
        if not problem.idle or not len(rows):
            return cls(problem, (), 0.0)
        some = rows[np.unique(np.linspace(0, len(rows) - 1, _TRIED).astype(int))]
        rows = _regular(problem, _wandered(problem, some))
        gaps = problem.loops.evaluate(rows)[0] * problem.row_scale / problem.length
        looseness = _LOOSE * float(np.linalg.norm(gaps, axis=1).max())
        return cls(problem, tuple(_steps(problem, rows)), looseness)

    @property
    def sameness(self) -> float:
        """Within what difference, without dimension, two poses are the same one."""
        return max(_SAME, _ROUND * self.looseness)

    def at_rest(
        self, blocks: Sequence[Array], seen: Callable[[WorldPoses], Sequence[Array]]
    ) -> list[Mask]:
        """Tell which things no idle motion changes.

        Parameters
        ----------
        blocks : sequence of ndarray, shape (b, things, ...)
            What is seen of some poses.
        seen : callable
            Sees poses so.
        """
        limit = 2.0 * _STEP * max(_AT_REST, self.looseness)
        rest = [np.ones(block.shape[1], dtype=bool) for block in blocks]
        for forth, back in self.steps:
            for still, one, other in zip(rest, seen(forth), seen(back), strict=True):
                apart = np.abs(one - other).max(axis=(0, *range(2, one.ndim)), initial=0.0)
                np.logical_and(still, apart <= limit, out=still)
        return rest

    def groups(self) -> list[list[int]]:
        """Return the bodies in groups within which no idle motion moves one relative to another.

        First comes the group of those that stay where they are, the world (0) among them.
        """
        left, groups = np.ones(self.problem.model.njoints, dtype=bool), []
        while left.any():
            first = int(np.argmax(left))

            def seen(poses: WorldPoses, body: int = first) -> list[Array]:
                return [_bodies(poses.seen_from(body), self.problem.length)]

            [together] = self.at_rest([left[None]], seen)
            groups.append(np.flatnonzero(together & left).tolist())
            left &= ~together
        return groups


def isolated(problem: SearchProblem, rows: Array) -> Mask:
    """Tell at which closed poses (b, nq) nothing moves but what idles at every pose."""
    K_star, sizes = scaled_passive(problem, rows)
    values = np.asarray(np.linalg.svd(K_star, compute_uv=False), float)
    ranks = (values > problem.rank_tolerance * sizes[:, None]).sum(axis=1)
    return np.asarray(ranks >= problem.columns.size - problem.idle)


def scaled_passive(problem: SearchProblem, rows: Array) -> tuple[Array, Array]:
    """Return K* (b, p, m_p), dimensionless, at rows of q, and the sizes (b,) of [K K*] there."""
    _, jacobian = problem.loops.evaluate(rows)
    scaled = jacobian * problem.row_scale[:, None] * problem.column_scale
    return scaled[:, :, problem.columns], np.linalg.norm(scaled, axis=(1, 2))


def _steps(problem: SearchProblem, rows: Array) -> list[tuple[WorldPoses, WorldPoses]]:
    """Return closed poses a little forth and back along each idle motion."""
    tree, motions = problem.tree, _motions(problem, rows)
    return [
        (tree.poses(tree.moved(rows, step)), tree.poses(tree.moved(rows, -step)))
        for step in _STEP * problem.length * motions.transpose(1, 0, 2)
    ]


def _wandered(problem: SearchProblem, rows: Array) -> Array:
    """Return closed poses, and where they are after having idled for a while."""
    strides = np.full(problem.columns.size, problem.length)
    rng, closures = np.random.default_rng(0), ManyClosures(problem, strides)
    there = [rows]
    for _ in range(_TURNS):
        motions = _motions(problem, rows)
        way = np.einsum("bk,bkv->bv", rng.normal(size=motions.shape[:2]), motions)
        there.append(closures.closed(problem.tree.moved(rows, problem.length * way)))
    return np.concatenate(there)


def _regular(problem: SearchProblem, rows: Array) -> Array:
    """Return the regular ones of closed poses, at least the most regular one."""
    K_star, sizes = scaled_passive(problem, rows)
    values = np.linalg.svd(K_star, compute_uv=False)
    rank = problem.columns.size - problem.idle
    smallest = values[:, rank - 1] / sizes if rank else np.ones(len(rows))
    return np.asarray(rows[smallest >= min(_REGULAR, float(smallest.max()))])


def _motions(problem: SearchProblem, rows: Array) -> Array:
    """Return a basis of the idle motions at closed poses, v (b, idle, nv)."""
    _, _, right = np.linalg.svd(scaled_passive(problem, rows)[0])
    motions = np.zeros((len(rows), problem.idle, problem.column_scale.size))
    rank = problem.columns.size - problem.idle
    motions[:, :, problem.columns] = right[:, rank:] * problem.column_scale[problem.columns]
    return motions


def _bodies(poses: WorldPoses, length: float) -> Array:
    """Return the places and axes of bodies, without dimension, shape (b, bodies, 12)."""
    places = poses.positions.swapaxes(0, 1) / length
    axes = poses.rotations.swapaxes(0, 1)
    return np.concatenate([places, axes.reshape(*places.shape[:2], 9)], axis=2)
