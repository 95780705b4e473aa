"""Many paths at once by the kernel, as `Walker` walks them without one."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.closing import straight_path
from pmjac_pin.closing.closed import closed_point
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.kernel_walk import (
    DOUBTFUL,
    SPENT,
    CommonStart,
    Following,
    KernelMachine,
    KernelWalk,
)
from pmjac_pin.closing.many_paths import FEW, LONG, GoOn, Paths, judged
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.values.arrays import Array, Mask
from pmjac_pin.values.spares import Spares

if TYPE_CHECKING:
    from pmjac_pin.algebra.compiled_programs import CompiledProgram

#: Steps of each lane in one call: some milliseconds, in which nothing can interrupt.
_LANE_STEPS_AT_ONCE = 64


class Outcome(Enum):
    """What became of paths from one pose that need no telling apart."""

    ALL_ARRIVED = 0
    NONE_SET_OUT = 1  # and nothing is done: a target is no number that all motors can reach


class PathsInLanes:
    """Walks paths of a mechanism.

    Parameters
    ----------
    library : ctypes.CDLL
        The kernel.
    tapes : (Tape, Tape, Tape)
        Those of a `Walker`: move, arrival and leg.
    problem : ClosureProblem
    coordinates : JointCoordinates
    compiled : sequence of CompiledProgram or None
        What computes the same as the tapes.
    limits : (float, float)
        Between which all motors can be.
    """

    def __init__(
        self,
        library: ctypes.CDLL,
        tapes: tuple[Tape, Tape, Tape],
        problem: ClosureProblem,
        coordinates: JointCoordinates,
        compiled: Sequence[CompiledProgram | None] = (None, None, None),
        *,
        limits: tuple[float, float] = (-np.inf, np.inf),
    ) -> None:
        partition = problem.partition
        self._compiled = compiled
        self._library, self._tapes, self._problem = library, tapes, problem
        self._machine = KernelMachine(
            problem,
            coordinates,
            tapes[0].outputs,
            tolerance=problem.tolerance,
            rank_tolerance=partition.rank_tolerance,
            least_size=partition.least_size,
            limits=limits,
        )
        self._walks = Spares(self._another_walk)
        self._common = CommonStart(b"", 0.0)

    def walk(
        self,
        q: Array,
        displacement: Array | None,
        target: Array,
        go_on: GoOn,
        most_steps: int = straight_path.MOST_STEPS,
        *,
        design: Array | None = None,
        ends: tuple[Array, Array] | None = None,
        following: Following | None = None,
    ) -> Paths:
        """Walk from closed poses.

        Parameters
        ----------
        q : ndarray, shape (b, nq)
        displacement, target : ndarray, shape (b, n)
            Of the motors: over the whole path, and at its end. No displacement: all of them are
            entries of q, and go from these to the targets.
        go_on : callable
            Called now and then; raises where nobody waits any longer.
        most_steps : int
            Tried in each path.
        design : ndarray, shape (b, k), optional
            What the programs take of each path's own machine. What is doubtful at the end of a path
            is not settled then.
        ends : (ndarray, ndarray), shapes (b, nq) and (b,), optional
            Where q and share go, row by row.
        following : Following, optional
            What is done as soon as all have arrived, and not where some end elsewhere.
        """
        if not len(q):
            return Paths(q.copy(), np.zeros(0), np.zeros(0, dtype=bool))
        if ends is None:
            ends = np.empty(q.shape), np.empty(len(q))
        walk = self._walks.take()
        start: Array | CommonStart = q
        if not q.strides[0]:
            start = self.common_start(q[0]) if design is None else CommonStart(q[0].tobytes(), 0.0)
        _kept = walk.take(  # until this returns: C reads and writes there
            start,
            displacement,
            target,
            ends,
            most_tries=most_steps,
            design=design,
            following=following,
        )
        walk.set_out(_LANE_STEPS_AT_ONCE)
        if self._walk_on(walk, go_on):
            return Paths(*ends, np.ones(len(q), dtype=bool))
        ways = walk.ways[: len(q)].copy() if displacement is None else displacement
        paths, doubtful = self._told(walk, ends)
        if design is not None:
            return paths.less(doubtful)
        return judged(self._problem, paths, ways, doubtful)

    def walk_from(
        self,
        start: CommonStart,
        target: Array,
        go_on: GoOn,
        ends: tuple[Array, Array],
        following: Following | None = None,
    ) -> Paths | Outcome:
        """Walk from one closed pose, with motors that are entries of q, within their limits.

        Parameters
        ----------
        start : CommonStart
        target, go_on, ends, following
            As for `walk`.
        """
        walk = self._walks.take()
        _kept = walk.take(start, None, target, ends, following=following, only_inside=True)
        if walk.set_out(_LANE_STEPS_AT_ONCE) < 0:
            self._walks.put_back(walk)
            return Outcome.NONE_SET_OUT
        if self._walk_on(walk, go_on):
            return Outcome.ALL_ARRIVED
        ways = walk.ways[: len(target)].copy()
        paths, doubtful = self._told(walk, ends)
        return judged(self._problem, paths, ways, doubtful)

    def _walk_on(self, walk: KernelWalk, go_on: GoOn) -> bool:
        """Walk to the ends; tell whether all have arrived, and let go of the walk then."""
        go_on()
        while not walk.is_over:
            walk.go_on(_LANE_STEPS_AT_ONCE)
            go_on()
        if walk.all_arrived:
            self._walks.put_back(walk)
            return True
        return False

    def _told(self, walk: KernelWalk, ends: tuple[Array, Array]) -> tuple[Paths, Mask]:
        """Return where paths ended, and which of them at doubtful poses; let go of the walk."""
        end = walk.end[: len(ends[1])].copy()
        self._walks.put_back(walk)
        return Paths(*ends, end != SPENT), end == DOUBTFUL

    def common_start(self, q: Array) -> CommonStart:
        """Return what is known of one start (nq,): the same value as long as it is the same."""
        known, numbers = self._common, q.tobytes()
        if known.q != numbers:  # threads may each find it
            known = self._common = CommonStart(numbers, self._inverse_at(q))
        return known

    def _another_walk(self) -> KernelWalk:
        return KernelWalk(
            self._library, self._machine, self._tapes, self._compiled, few=FEW, patience=LONG
        )

    def _inverse_at(self, q: Array) -> float:
        """Return how large the inverse of K* is, 0 where the programs have it on some columns."""
        partition = self._problem.partition
        if not 0 < partition.passive_rank == partition.passive.size:
            return 0.0
        factors = closed_point(self._problem, q.copy()).factors
        smallest = float(factors.singular_values[partition.passive_rank - 1])
        return 1.0 / smallest if smallest > 0.0 else 0.0
