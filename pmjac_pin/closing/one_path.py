"""One path of the motors by recorded programs, for as long as all of it is certain.

As `straight_path.follow` walks it, step by step, in the kernel (`path_kernel.c`); whether a step is
covered is judged by norms (`recorded_step`). A path that this leaves is for `follow` to go on with.
"""

from __future__ import annotations

import ctypes
import threading
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.closing import straight_path
from pmjac_pin.closing.closure_problem import ClosureProblem
from pmjac_pin.closing.kernel_walk import SPENT, KernelMachine, KernelWalk
from pmjac_pin.closing.motor_values import Motors
from pmjac_pin.closing.one_pose import SURELY
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.values.arrays import Array

_STEPS_AT_ONCE = 256  # steps in one call: a few milliseconds, in which nothing can interrupt


@dataclass(frozen=True, slots=True, eq=False)
class Ahead:
    """How far a path is certain: at a closed pose, at its target where `share` is 1."""

    q: Array
    gap: float
    share: float
    iterations: int


class OnePath:
    """Walks paths of a mechanism.

    Parameters
    ----------
    library : ctypes.PyDLL
        The kernel.
    tapes : (Tape, Tape, Tape)
        Those of a `Walker`: move, arrival and leg.
    problem : ClosureProblem
    coordinates : JointCoordinates
    motors : Motors
    """

    def __init__(
        self,
        library: ctypes.PyDLL,
        tapes: tuple[Tape, Tape, Tape],
        problem: ClosureProblem,
        coordinates: JointCoordinates,
        motors: Motors,
    ) -> None:
        partition = problem.partition
        self._library, self._tapes, self._motors = library, tapes, motors
        self._scale = 1.0 / partition.motor_scale
        self._farthest = straight_path.MOST_STEPS * straight_path.LARGEST_STEP * partition.length
        rank_tolerance = partition.rank_tolerance / SURELY
        self._machine = KernelMachine(
            problem,
            coordinates,
            tapes[0].outputs,
            tolerance=SURELY * problem.tolerance,
            rank_tolerance=rank_tolerance,
            least_size=max(partition.size, partition.least_size),
            arrival_tolerance=rank_tolerance,
        )
        self._threads = threading.local()

    def follow(self, q: Array, values: Array) -> Ahead | None:
        """Walk from a closed q to motor values (n,), straight, on the assembly mode of the q.

        None where a path is so long that another has to say where it ends.
        """
        way = self._motors.way(q, values)
        scaled = way * self._scale
        if not np.dot(scaled, scaled) <= self._farthest**2:
            return None
        try:
            walk, start, displacement, target, ends = self._threads.work
        except AttributeError:
            walk, start, displacement, target, ends = self._threads.work = self._work()
        start[0], displacement[0], target[0] = q, way, values
        more = walk.set_out(_STEPS_AT_ONCE)
        while more > 0:
            more = walk.go_on(_STEPS_AT_ONCE)
        if walk.end[0] == SPENT:
            return None
        (reached, share), gap, iterations = ends, float(walk.gap[0]), int(walk.iterations[0])
        return Ahead(reached[0].copy(), gap, float(share[0]), iterations)

    def _work(self) -> tuple[KernelWalk, Array, Array, Array, tuple[Array, Array]]:
        """Return what walks one path, and the arrays, of one row, that it reads and fills."""
        walk = KernelWalk(self._library, self._machine, self._tapes)
        start, reached = np.zeros((2, 1, self._tapes[0].outputs))
        displacement, target = np.zeros((2, 1, self._scale.size))
        ends = reached, np.zeros(1)
        walk.take(start, displacement, target, ends)  # copies none of them: they are contiguous
        return walk, start, displacement, target, ends
