"""Many paths where something idles, in pieces, as `IdlePath` walks one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.idle_way import (
    LARGEST_RETURN,
    MOST_RETURNS,
    SETTLED,
    TURNED,
    UNRESOLVED,
    parts_of,
)
from pmjac_pin.closing.many_paths import Paths, covered
from pmjac_pin.closing.straight_path import LARGEST_STEP, MOST_STEPS
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.rates.rank_bounds import RankBounds
from pmjac_pin.values.arrays import Array, Index, Mask

_EXACT = 1e-10  # of N₀, beside its largest entries

#: (q, displacement, target, ends) of some paths ↦ where they end.
Walk = Callable[[Array, Array, Array, tuple[Array, Array]], Paths]


@dataclass(frozen=True, slots=True, eq=False)
class ManyIdlePaths:
    """Walks paths of one mechanism.

    Attributes
    ----------
    problem : ClosureProblem
    coordinates : JointCoordinates
    idle, back, cover : Tape
        `idle_tape`, `return_tape` and `cover_tape`.
    """

    problem: ClosureProblem
    coordinates: JointCoordinates
    idle: Tape
    back: Tape
    cover: Tape

    def walk(
        self,
        walk: Walk,
        q: Array,
        displacement: Array,
        target: Array,
        ends: tuple[Array, Array],
    ) -> Mask:
        """Walk from closed poses, piece by piece; find q and share, and tell which are settled.

        Parameters
        ----------
        walk : callable
            Walks a piece of some paths.
        q : ndarray, shape (b, nq)
        displacement, target : ndarray, shape (b, n)
            Of the motors: over the whole path, and at its end.
        ends : (ndarray, ndarray), shapes (b, nq) and (b,)
            Where q and share go.
        """
        count = self._pieces(displacement)
        if (count == 1).all():
            return self._walk_one(walk, (q, displacement, target), ends)
        here, share = ends
        first = self.coordinates.values_of(q, self.problem.partition.actuated)
        settled, number = np.ones(len(q), dtype=bool), 0
        going, start = np.arange(len(q)), q
        while going.size:
            number += 1
            way, pieces = displacement[going] / count[going, None], count[going]
            aim = np.where((pieces == number)[:, None], target[going], first[going] + number * way)
            end, reached = np.empty(start.shape), np.empty(going.size)
            settled[going] = self._walk_one(walk, (start, way, aim), (end, reached))
            here[going], share[going] = end, (number - 1 + reached) / pieces
            going = going[settled[going] & (reached == 1.0) & (pieces > number)]
            start = here[going]
        share[~settled] = 0.0
        return settled

    def _walk_one(
        self, walk: Walk, paths: tuple[Array, Array, Array], ends: tuple[Array, Array]
    ) -> Mask:
        """Walk one piece of each path; tell which are settled."""
        settled: Mask = walk(*paths, ends).settled
        arrived = ends[1] == 1.0
        found = self._return(paths[0], ends[0], arrived)
        lost = arrived & ~found
        ends[1][lost] = 0.0
        return np.asarray(settled & ~lost)

    def _pieces(self, displacement: Array) -> Index:
        """Return into how many pieces each path is cut: none that is too long for any steps."""
        partition = self.problem.partition
        distance = np.linalg.norm(displacement / partition.motor_scale, axis=1) / partition.length
        distance[distance > MOST_STEPS * LARGEST_STEP] = 0.0
        return parts_of(distance)

    def _return(self, start: Array, end: Array, arrived: Mask) -> Mask:
        """Bring back closed poses (b, nq) that are at the ends of paths, as `IdleWay.settled` does.

        And tell of which they are found.
        """
        told = run(self.idle, (start if start.strides[0] else start[:1]).T)
        exact, nq = told[0] * told[1] <= _EXACT, end.shape[1]
        inputs = np.empty((2 * nq + len(told) - 2, len(end)))
        inputs[:nq], inputs[nq : 2 * nq], inputs[2 * nq :] = end.T, start.T, told[2:]
        before = np.full(len(end), 2.0 * LARGEST_RETURN)
        found = self._steps(inputs, exact & arrived, before, MOST_RETURNS)
        ways = np.vstack([end.T, inputs])[:, found]
        found[found] = covered(run(self.cover, ways))
        end[:] = inputs[:nq].T
        return found

    def _steps(self, inputs: Array, on: Mask, before: Array, most: int) -> Mask:
        """Take steps back of some columns, in their first rows; tell which come to an end."""
        at, found = inputs[: self.idle.inputs], np.zeros(len(on), dtype=bool)
        while on.any() and most:
            told = run(self.back, inputs)
            size, good, done = self._judged(told, before)
            on = on & good
            np.copyto(at, told[6:], where=on)
            found |= on & done
            on, before, most = on & ~done, size, most - 1
            if 2 * np.count_nonzero(on) < len(on):
                left = np.flatnonzero(on)
                fewer = inputs[:, left]
                found[left] = self._steps(fewer, on[left], before[left], most)
                at[:, left] = fewer[: len(at)]
                return found
        return found

    def _judged(self, told: Array, before: Array) -> tuple[Array, Mask, Mask]:
        """Return sizes of steps, which of them are good, and which are the last."""
        partition = self.problem.partition
        inverse, norm, size, turned, gap, moved = told[:6]
        size = size / partition.length
        smaller = size <= 0.5 * before
        left = moved + inverse * gap * (1.0 + 2.0 * np.sqrt(turned))  # with L of 2 at most
        done = ((left <= SETTLED * partition.length) | ~smaller) & (gap <= self.problem.tolerance)
        good = (smaller | (size <= UNRESOLVED)) & RankBounds.of(partition).regular(inverse, norm)
        good &= ~done | (turned <= partition.passive.size - partition.passive_rank + TURNED)
        return size, good, done
