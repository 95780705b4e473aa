"""Many paths where something idles: in pieces, at whose ends that is brought back, as `IdlePath`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.closing.closure import LARGEST_STEP, MOST_STEPS
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.idle_way import (
    LARGEST_RETURN,
    MOST_RETURNS,
    SETTLED,
    TURNED,
    UNRESOLVED,
    pieces_of,
)
from pmjac_pin.closing.many_paths import Paths
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.rates.rank_bounds import RankBounds
from pmjac_pin.values.arrays import Array, Index, Mask

_EXACT = 1e-10  # of N₀, beside its largest entries

#: (q, displacement, target) of some paths ↦ where they end.
Walk = Callable[[Array, Array, Array], Paths]


@dataclass(frozen=True, slots=True, eq=False)
class ManyIdlePaths:
    """Walks paths of one mechanism.

    Attributes
    ----------
    problem : ClosureProblem
    coordinates : JointCoordinates
    idle, back : Tape
        `idle_tape` and `return_tape`.
    """

    problem: ClosureProblem
    coordinates: JointCoordinates
    idle: Tape
    back: Tape

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
        here, share = ends
        motors = self.problem.partition.actuated
        count = self._pieces(displacement)
        first = self.coordinates.values_of(q if q.strides[0] else q[:1], motors)
        settled, going, start = np.ones(len(q), dtype=bool), np.arange(len(q)), q
        number = 0
        while going.size:
            number += 1
            part, way = (number / count[going])[:, None], displacement[going]
            there = (first if len(first) == 1 else first[going]) + part * way
            aim = np.where(part == 1.0, target[going], there)
            paths = walk(start, way / count[going][:, None], aim)
            arrived = np.flatnonzero(paths.share == 1.0)
            here[going], share[going] = paths.q, (number - 1 + paths.share) / count[going]
            settled[going] = paths.settled
            here[going[arrived]], found = self._returned(
                start[:1] if not start.strides[0] else start[arrived], paths.q[arrived]
            )
            lost = going[arrived[~found]]
            settled[lost], share[lost] = False, 0.0
            going = going[arrived[found]]
            going = going[count[going] > number]
            start = here[going]
        return settled

    def _pieces(self, displacement: Array) -> Index:
        """Return into how many pieces each path is cut: none that is too long for any steps."""
        partition = self.problem.partition
        distance = np.linalg.norm(displacement / partition.motor_scale, axis=1) / partition.length
        distance[distance > MOST_STEPS * LARGEST_STEP] = 0.0
        return pieces_of(distance)

    def _returned(self, start: Array, q: Array) -> tuple[Array, Mask]:
        """Return the closed poses beside some that start from others, as `IdleWay.settled`.

        And of which they are found.
        """
        open_by, inverse, *idle = run(self.idle, start.T)
        given = np.vstack([start.T, *idle])
        given = np.broadcast_to(given, (len(given), len(q)))
        found = np.array(np.broadcast_to(open_by * inverse <= _EXACT, len(q)))
        length, end = self.problem.partition.length, q.copy()
        going = np.flatnonzero(found)
        before = np.full(len(q), 2.0 * LARGEST_RETURN * length)
        for _ in range(MOST_RETURNS):
            if not going.size:
                return end, found
            told = run(self.back, np.vstack([end[going].T, given[:, going]]))
            size, good, done = self._judged(told, before[going])
            found[going] = good
            end[going[good]], before[going] = told[5:, good].T, size
            going = going[good & ~done]
        found[going] = False
        return end, found

    def _judged(self, told: Array, before: Array) -> tuple[Array, Mask, Mask]:
        """Return sizes of steps, which of them are good, and which are the last."""
        partition = self.problem.partition
        gap, inverse, norm, size, turned = told[:5]
        smaller = size <= 0.5 * before
        done = size <= np.where(smaller, SETTLED, UNRESOLVED) * partition.length
        done &= gap <= self.problem.tolerance
        good = (smaller | done) & RankBounds.of(partition).regular(inverse, norm)
        good &= ~done | (turned <= partition.passive.size - partition.passive_rank + TURNED)
        return size, good, done
