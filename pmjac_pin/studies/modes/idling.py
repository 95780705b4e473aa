"""Idling: what moves at every pose with all motors locked, and what that leaves at rest.

A motion idles if it is in the null space of K* at every pose, not at one: a rod that spins about
itself moves no point of its line, which is plain where the rod stands along an axis and where it
does not. So what idles is looked at in several regular poses, each of them also after it has
idled for a while, where nothing is in line by chance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pmjac_pin.kinematics.many import WorldPoses
from pmjac_pin.rates.factorisation import Factorisation
from pmjac_pin.studies.modes.search import FewClosures
from pmjac_pin.studies.modes.search_problem import SearchProblem
from pmjac_pin.values.arrays import Array, Mask

_POSES_TRIED = 24  # closed poses that are looked at
_TURNS = 2  # how often each of them idles for a while
_REGULAR_ENOUGH = 1e-2  # of the size of [K K*]: the worse, the less is known of what idles
_IDLE_STEP = 1e-4  # of an idle motion, rad or lengths
_AT_REST = 1e-5  # what an idle motion of one changes, and does not count as moved
_SAME_ROOT = 1e-5  # two roots that meet are known to √1e-12
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
        problem = raised(problem, rows)
        if not problem.idle or not len(rows):
            return cls(problem, (), 0.0)
        some = rows[np.unique(np.linspace(0, len(rows) - 1, _POSES_TRIED).astype(int))]
        rows = _regular_rows(problem, _wandered(problem, some))
        gaps = problem.loops.evaluate(rows)[0] * problem.partition.row_scale / problem.length
        looseness = _LOOSE * float(np.linalg.norm(gaps, axis=1).max())
        return cls(problem, tuple(_steps(problem, rows)), looseness)

    @property
    def sameness(self) -> float:
        """Within what difference, without dimension, two poses are the same one."""
        return max(_SAME_ROOT, _ROUND * self.looseness)

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
        limit = 2.0 * _IDLE_STEP * max(_AT_REST, self.looseness)
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
                return [_body_coordinates(poses.seen_from(body), self.problem.length)]

            [together] = self.at_rest([left[None]], seen)
            groups.append(np.flatnonzero(together & left).tolist())
            left &= ~together
        return groups


def isolated(problem: SearchProblem, rows: Array) -> Mask:
    """Tell at which closed poses (b, nq) nothing moves but what idles at every pose."""
    ranks = np.array([factors.rank for factors in _factorised_rows(problem, rows)])
    return np.asarray(ranks >= max(problem.partition.passive_rank, *ranks))


def raised(problem: SearchProblem, rows: Array) -> SearchProblem:
    """Return the problem with the rank of K* at closed poses (b, nq), where that is more.

    Home may be on a branch of less rank: what idles there need not idle at these motor values.
    """
    partition = problem.partition
    if partition.full or not len(rows):
        return problem
    rank = max(factors.rank for factors in _factorised_rows(problem, rows))
    if rank <= partition.passive_rank:
        return problem
    return replace(problem, partition=replace(partition, passive_rank=rank))


def _factorised_rows(problem: SearchProblem, rows: Array) -> list[Factorisation]:
    """Return K*, without dimension, factorised at rows of q."""
    jacobians = problem.loops.evaluate(rows)[1]
    return [problem.partition.loop_rates(jacobian).passive for jacobian in jacobians]


def _steps(problem: SearchProblem, rows: Array) -> list[tuple[WorldPoses, WorldPoses]]:
    """Return closed poses a little forth and back along each idle motion."""
    tree, motions = problem.tree, _idle_motions(problem, rows)
    return [
        (tree.poses(tree.moved(rows, step)), tree.poses(tree.moved(rows, -step)))
        for step in _IDLE_STEP * problem.length * motions.transpose(1, 0, 2)
    ]


def _wandered(problem: SearchProblem, rows: Array) -> Array:
    """Return closed poses, and where they are after having idled for a while."""
    strides = np.full(problem.partition.passive.size, problem.length)
    rng, closures = np.random.default_rng(0), FewClosures(problem, strides)
    there = [rows]
    for _ in range(_TURNS):
        motions = _idle_motions(problem, rows)
        way = np.einsum("bk,bkv->bv", rng.normal(size=motions.shape[:2]), motions)
        there.append(closures.closed(problem.tree.moved(rows, problem.length * way)))
    return np.concatenate(there)


def _regular_rows(problem: SearchProblem, rows: Array) -> Array:
    """Return the regular ones of closed poses, at least the most regular one."""
    rank, found = problem.partition.passive_rank, _factorised_rows(problem, rows)
    if not rank:
        return rows
    smallest = np.array([one.singular_values[rank - 1] / one.size for one in found])
    return np.asarray(rows[smallest >= min(_REGULAR_ENOUGH, float(smallest.max()))])


def _idle_motions(problem: SearchProblem, rows: Array) -> Array:
    """Return a basis of the idle motions at closed poses, v (b, idle, nv)."""
    partition = problem.partition
    passive, scale = partition.passive, partition.column_scale
    motions = np.zeros((len(rows), problem.idle, scale.size))
    for motion, factors in zip(motions, _factorised_rows(problem, rows), strict=True):
        motion[:, passive] = factors.right[partition.passive_rank :] * scale[passive]
    return motions


def _body_coordinates(poses: WorldPoses, length: float) -> Array:
    """Return the places and axes of bodies, without dimension, shape (b, bodies, 12)."""
    places = poses.positions.swapaxes(0, 1) / length
    axes = poses.rotations.swapaxes(0, 1)
    return np.concatenate([places, axes.reshape(*places.shape[:2], 9)], axis=2)
