"""What a kernel needs to walk paths of one mechanism: its numbers, and memory of one thread."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pmjac_pin.algebra.c_kernels import address
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.closing import closure
from pmjac_pin.closing.closure_problem import ROUNDING, ClosureProblem
from pmjac_pin.closing.path_kernel import (
    LaneStruct,
    MachineStruct,
    Memory,
    WalkStruct,
)
from pmjac_pin.closing.step_guard import MARGIN
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.values.arrays import Array, Index, aligned

if TYPE_CHECKING:
    from pmjac_pin.algebra.compiled_programs import CompiledProgram

#: Where paths end, as `walk.h` numbers it.
SPENT, ARRIVED, DOUBTFUL, STUCK = range(4)


class KernelMachine:
    """What the kernels know of a mechanism besides its programs.

    Parameters
    ----------
    problem : ClosureProblem
    coordinates : JointCoordinates
    nq : int
    tolerance : float
        Of a closed pose, m.
    rank_tolerance, least_size : float
        K* is regular where its smallest singular value is above the one, beside [K K*] or the
        other.
    arrival_tolerance : float
        The rank tolerance of where steps may end; elsewhere paths end.

    Attributes
    ----------
    struct : MachineStruct
    """

    def __init__(
        self,
        problem: ClosureProblem,
        coordinates: JointCoordinates,
        nq: int,
        *,
        tolerance: float,
        rank_tolerance: float,
        least_size: float,
        arrival_tolerance: float = 0.0,
    ) -> None:
        partition = problem.partition
        length, motors = partition.length, partition.actuated
        entries = [coordinates.entry(column) for column in motors.tolist()]
        self._entries = np.array(entries, dtype=np.int32)
        self._scale = np.ascontiguousarray(partition.column_scale)
        self._circles = coordinates.wraps[motors].astype(np.int32)
        self.struct = MachineStruct(
            nq=nq,
            nv=partition.column_scale.size,
            motors=motors.size,
            motor_entries=address(self._entries),
            motor_circles=address(self._circles),
            scale=address(self._scale),
            tolerance=tolerance,
            enough=ROUNDING * length,
            walking=closure.WALKING * length,
            rank_tolerance=rank_tolerance,
            least_size=least_size,
            largest_step=closure.LARGEST_STEP * length,
            smallest_step=closure.SMALLEST_STEP * length,
            largest_correction=closure.LARGEST_CORRECTION,
            slowest_contraction=closure.SLOWEST_CONTRACTION,
            no_inverse=closure.NO_INVERSE,
            margin=MARGIN,
            arrival_tolerance=arrival_tolerance,
            most_corrections=closure.MOST_CORRECTIONS,
        )


@dataclass(frozen=True, slots=True, eq=False)
class PathsToWalk:
    """Paths, and what becomes of them.

    Attributes
    ----------
    start : ndarray, shape (b, nq)
        Closed poses; rows may be the same memory.
    displacement, target : ndarray, shape (b, n)
        Of the motors.
    design : ndarray, shape (b, k), or None
        What the programs take of each path's own machine; None where they are of one machine.
    q, gap, share : ndarray, shapes (b, nq), (b,) and (b,)
        Where each ended, how far the loops are open there, m, and at which share of the way.
    iterations, end : ndarray of int, shape (b,)
    """

    start: Array
    displacement: Array
    target: Array
    design: Array | None
    q: Array
    gap: Array
    share: Array
    iterations: Index
    end: Index

    @classmethod
    def of(
        cls,
        start: Array,
        displacement: Array,
        target: Array,
        design: Array | None = None,
        ends: tuple[Array, Array] | None = None,
    ) -> PathsToWalk:
        """Return paths that are not walked yet; q and share of their ends go where it is told."""
        count = len(start)
        given = (start, np.ascontiguousarray(displacement), np.ascontiguousarray(target))
        own = None if design is None else np.ascontiguousarray(design)
        q, share = (np.empty(start.shape), np.zeros(count)) if ends is None else ends
        whole = np.zeros((2, count), dtype=np.int64)
        return cls(*given, own, q, np.zeros(count), share, *whole)


class KernelWalk:
    """Memory of one thread in which a kernel walks.

    Parameters
    ----------
    library : ctypes.CDLL
    machine : KernelMachine
    move, arrival, leg : Tape
        Those of a `Walker`.

    """

    def __init__(
        self,
        library: ctypes.CDLL,
        machine: KernelMachine,
        tapes: tuple[Tape, Tape, Tape],
        compiled: Sequence[CompiledProgram | None] = (None, None, None),
    ) -> None:
        lanes = library.pmjac_lanes()
        programs = [Memory(tape, lanes, it) for tape, it in zip(tapes, compiled, strict=True)]
        _, arrival, _ = tapes
        point, states = aligned(arrival.outputs, lanes), (LaneStruct * lanes)()
        nv, motors = machine.struct.nv, machine.struct.motors
        # With the rates with each motor, how these bend by pairs, and their sizes.
        common = np.zeros(arrival.outputs + motors * (nv + 1) + motors * (motors + 1) // 2 * nv)
        learnt = np.full(machine.struct.nq, np.nan)
        self._begin, self._walk = library.pmjac_begin, library.pmjac_walk
        self._kept = machine, programs, point, states, common, learnt
        self._struct = WalkStruct(
            ctypes.addressof(machine.struct),
            *(memory.struct for memory in programs),
            address(point),
            ctypes.addressof(states),
            address(common),
            address(learnt),
            0.0,
        )
        self._argument = ctypes.byref(self._struct)

    def take(
        self,
        paths: PathsToWalk,
        most_tries: int = closure.MOST_STEPS,
        few: int = 0,
        patience: int = closure.MOST_STEPS,
        inverse: float = 0.0,
    ) -> None:
        """Take paths to walk: of at most so many steps, of the last few of fewer.

        Where all start at one pose, `inverse` may be how large that of K* is there at most.
        """
        struct, self._paths = self._struct, paths
        struct.inverse = inverse
        apart, count = paths.start.strides[0] // paths.start.itemsize, len(paths.start)
        self._start = start = np.ascontiguousarray(paths.start if apart else paths.start[:1])
        struct.start, struct.apart = address(start), start.shape[1] if apart else 0
        struct.displacement, struct.target = address(paths.displacement), address(paths.target)
        struct.design, struct.designed = None, 0
        if paths.design is not None:
            struct.design, struct.designed = address(paths.design), paths.design.shape[1]
        struct.q, struct.gap, struct.share = map(address, (paths.q, paths.gap, paths.share))
        struct.iterations, struct.end = address(paths.iterations), address(paths.end)
        struct.count, struct.most_tries = count, most_tries
        struct.few, struct.patience = few, min(patience, most_tries)

    def begin(self) -> None:
        """Go to where the paths start."""
        self._begin(self._argument)

    def go_on(self, steps: int) -> bool:
        """Walk up to so many steps of each lane; tell whether more lead further."""
        return bool(self._walk(self._argument, steps))
