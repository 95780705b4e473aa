"""One path of the motors by recorded programs, for as long as all of it is certain.

As `closure.follow` walks it, step by step, in the kernel (`path_kernel.c`); whether a step is
covered is judged by norms (`recorded_step`). A path that this leaves is for `follow` to go on with.
"""

from __future__ import annotations

import ctypes
import threading
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.closing import closure
from pmjac_pin.closing.closure_problem import ROUNDING, ClosureProblem
from pmjac_pin.closing.one_pose import SURELY
from pmjac_pin.closing.path_kernel import MachineStruct, Memory, PathStruct, address
from pmjac_pin.closing.step_guard import MARGIN
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
    """

    def __init__(
        self,
        library: ctypes.PyDLL,
        tapes: tuple[Tape, Tape, Tape],
        problem: ClosureProblem,
        coordinates: JointCoordinates,
    ) -> None:
        partition = problem.partition
        self._begin, self._walk = library.pmjac_begin, library.pmjac_walk
        self._tapes, self._coordinates = tapes, coordinates
        self._motors = partition.actuated
        circles = coordinates.wraps[self._motors].astype(float)
        self._circles = circles if circles.any() else None
        self._entries = np.array([coordinates.entry(k) for k in self._motors.tolist()], dtype=int)
        self._scale = 1.0 / partition.column_scale[self._motors]
        self._farthest = closure.MOST_STEPS * closure.LARGEST_STEP * partition.length
        self._machine = _Machine(problem, coordinates, tapes[0].outputs)
        self._threads = threading.local()

    def follow(self, q: Array, values: Array) -> Ahead | None:
        """Walk from a closed q to motor values (n,), straight, on the assembly mode of the q.

        None where a path is so long that another has to say where it ends.
        """
        displacement = values - self._values(q)
        if self._circles is not None:
            displacement -= 2.0 * np.pi * np.round(displacement / (2.0 * np.pi)) * self._circles
        scaled = displacement * self._scale
        if not np.dot(scaled, scaled) <= self._farthest**2:
            return None
        try:
            work = self._threads.work
        except AttributeError:
            work = self._threads.work = _Work(self._machine, *self._tapes)
        work.q[:], work.displacement[:], work.target[:] = q, displacement, values
        self._begin(work.argument)
        path, left = work.path, closure.MOST_STEPS
        while self._walk(work.argument, min(_STEPS_AT_ONCE, left)):
            left = closure.MOST_STEPS - path.tries
            if not left:
                return None
        return Ahead(work.q.copy(), float(work.gap[0]), path.share, path.iterations)

    def _values(self, q: Array) -> Array:
        if self._circles is None:
            return q.take(self._entries)
        return self._coordinates.values_of(q, self._motors)


class _Machine:
    """What the kernel knows of a mechanism besides its programs."""

    def __init__(self, problem: ClosureProblem, coordinates: JointCoordinates, nq: int) -> None:
        partition = problem.partition
        length, motors = partition.length, partition.actuated
        entries = [coordinates.entry(column) for column in motors.tolist()]
        self._entries = np.array(entries, dtype=np.int32)
        self._circles = coordinates.wraps[motors].astype(np.int32)
        self.struct = MachineStruct(
            nq=nq,
            nv=partition.column_scale.size,
            motors=motors.size,
            motor_entries=address(self._entries),
            motor_circles=address(self._circles),
            tolerance=SURELY * problem.tolerance,
            enough=ROUNDING * length,
            walking=closure.WALKING * length,
            rank_tolerance=partition.rank_tolerance / SURELY,
            least_size=max(partition.size, partition.least_size),
            largest_step=closure.LARGEST_STEP * length,
            smallest_step=closure.SMALLEST_STEP * length,
            largest_correction=closure.LARGEST_CORRECTION,
            slowest_contraction=closure.SLOWEST_CONTRACTION,
            no_inverse=closure.NO_INVERSE,
            margin=MARGIN,
            most_corrections=closure.MOST_CORRECTIONS,
        )


class _Work:
    """A path with what it works on, of one thread."""

    def __init__(self, machine: _Machine, move: Tape, arrival: Tape, leg: Tape) -> None:
        programs = [Memory(tape) for tape in (move, arrival, leg)]
        self._kept = machine, programs
        self.point = np.zeros(arrival.outputs)
        self.q, self.gap = self.point[: machine.struct.nq], self.point[machine.struct.nq :][:1]
        self.displacement, self.target = np.zeros((2, machine.struct.motors))
        self.path = PathStruct(
            ctypes.addressof(machine.struct),
            *(memory.struct for memory in programs),
            address(self.point),
            address(self.displacement),
            address(self.target),
        )
        self.argument = ctypes.byref(self.path)
