"""What a kernel needs to walk paths of one mechanism: its numbers, and memory of one thread."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pmjac_pin.algebra.c_kernels import address
from pmjac_pin.algebra.lane_programs import Memory
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.closing import newton_correction, straight_path
from pmjac_pin.closing.closed import NO_INVERSE
from pmjac_pin.closing.closure_problem import ROUNDING, ClosureProblem
from pmjac_pin.closing.path_kernel import LaneStruct, MachineStruct, WalkStruct
from pmjac_pin.closing.step_guard import MARGIN
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.values.arrays import Array, aligned

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
    limits : (float, float)
        Between which all motors can be.

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
        limits: tuple[float, float] = (-np.inf, np.inf),
    ) -> None:
        partition = problem.partition
        length, motors = partition.length, partition.actuated
        self._entries = np.array([coordinates.entry(k) for k in motors.tolist()], dtype=np.int32)
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
            walking=newton_correction.WALKING * length,
            rank_tolerance=rank_tolerance,
            least_size=least_size,
            largest_step=straight_path.LARGEST_STEP * length,
            smallest_step=straight_path.SMALLEST_STEP * length,
            largest_correction=newton_correction.LARGEST_CORRECTION,
            slowest_contraction=newton_correction.SLOWEST_CONTRACTION,
            no_inverse=NO_INVERSE,
            margin=MARGIN,
            arrival_tolerance=arrival_tolerance,
            lowest=limits[0],
            highest=limits[1],
            most_corrections=newton_correction.MOST_CORRECTIONS,
        )


class Following(NamedTuple):
    """What a kernel does as soon as all paths of a walk have arrived.

    Attributes
    ----------
    function, given : int
        Where a function in C is, and the pointer that it takes, before all q and their number.
    kept : object
        What the pointer points to. Arrays that are pointed to from there are kept by who gave it.
    """

    function: int | None
    given: int
    kept: object


class CommonStart(NamedTuple):
    """A closed pose from which all paths start.

    Attributes
    ----------
    q : bytes
        Its numbers, shape (nq,).
    inverse : float
        How large the inverse of K* is there at most; 0 where that is not known.
    """

    q: bytes
    inverse: float


class KernelWalk:
    """Memory of one thread in which a kernel walks.

    Parameters
    ----------
    library : ctypes.CDLL
    machine : KernelMachine
    move, arrival, leg : Tape
        Those of a `Walker`.
    compiled : sequence of CompiledProgram or None
        What computes the same as the tapes.
    few, patience : int
        The last `few` paths take at most `patience` steps.

    Attributes
    ----------
    gap : ndarray, shape (b or more,)
        How far the loops are open where paths ended, m.
    ways : ndarray, shape (b or more, n)
        How far the motors go, where that was not given.
    iterations, end : ndarray of int, shape (b or more,)
    set_out, go_on : callable
        Walk up to so many steps of each lane, from where the paths start or from where they are;
        tell whether more lead further: 1, or 0. Less than 0 of `set_out` where nothing is done.
    """

    def __init__(
        self,
        library: ctypes.CDLL,
        machine: KernelMachine,
        tapes: tuple[Tape, Tape, Tape],
        compiled: Sequence[CompiledProgram | None] = (None, None, None),
        *,
        few: int = 0,
        patience: int = straight_path.MOST_STEPS,
    ) -> None:
        lanes = library.pmjac_lanes()
        programs = [Memory(tape, lanes, it) for tape, it in zip(tapes, compiled, strict=True)]
        _, arrival, _ = tapes
        point, states = aligned(arrival.outputs, lanes), (LaneStruct * lanes)()
        nv = machine.struct.nv
        motors = self._motors = machine.struct.motors
        # With the rates with each motor, how these bend by pairs, and their sizes.
        common = np.zeros(arrival.outputs + motors * (nv + 1) + motors * (motors + 1) // 2 * nv)
        learnt = np.full(machine.struct.nq, np.nan)
        self._kept = machine, programs, point, states, common, learnt
        self._struct = WalkStruct(
            ctypes.addressof(machine.struct),
            *(memory.struct for memory in programs),
            address(point),
            ctypes.addressof(states),
            address(common),
            address(learnt),
            few=few,
            patience=patience,
        )
        argument, self._one = ctypes.byref(self._struct), np.zeros(machine.struct.nq)
        self.set_out: Callable[[int], int] = partial(library.pmjac_set_out, argument)
        self.go_on: Callable[[int], int] = partial(library.pmjac_walk, argument)
        self._where_one_is = address(self._one)
        self._common: CommonStart | None = None
        self._following: Following | None = None
        self._make_room(1)

    def take(
        self,
        start: Array | CommonStart,
        displacement: Array | None,
        target: Array,
        ends: tuple[Array, Array],
        *,
        most_tries: int = straight_path.MOST_STEPS,
        design: Array | None = None,
        following: Following | None = None,
        only_inside: bool = False,
    ) -> object:
        """Take paths to walk; return what is to be kept until they are: C reads and writes there.

        Parameters
        ----------
        start : ndarray, shape (b, nq), or CommonStart
            Closed poses.
        displacement, target : ndarray, shape (b, n)
            Of the motors. No displacement: from entries of q to the targets.
        ends : (ndarray, ndarray), shapes (b, nq) and (b,)
            Where each ended, q and its share of the way; not before it is walked.
        most_tries : int
            Steps of each path.
        design : ndarray, shape (b, k), optional
            What the programs take of each path's own machine; None where they are of one machine.
        following : Following, optional
        only_inside : bool
            Whether nothing is done where a target is no number between the limits of the machine.
        """
        struct, count, (q, share) = self._struct, len(target), ends
        if count > len(self.end):
            self._make_room(count)
        target = np.ascontiguousarray(target)
        struct.target, struct.q, struct.share = address(target), address(q), address(share)
        struct.count, struct.most_tries, struct.only_inside = count, most_tries, only_inside
        if start is not self._common:
            start = self._take_start(start)
        if displacement is None:
            struct.ways = struct.displacement = self._where_ways_are
        else:
            displacement = np.ascontiguousarray(displacement)
            struct.ways, struct.displacement = None, address(displacement)
        struct.designed = 0
        if design is not None:
            design = np.ascontiguousarray(design)
            struct.design, struct.designed = address(design), design.shape[1]
        if following is not self._following:
            struct.follow, struct.given, _ = following or (None, None, None)
            self._following = following
        return start, displacement, target, ends, design

    def _take_start(self, start: Array | CommonStart) -> Array | CommonStart:
        """Take where paths start; return what holds it."""
        struct = self._struct
        if isinstance(start, CommonStart):
            self._one[:] = np.frombuffer(start.q)
            struct.start, struct.apart, struct.inverse = self._where_one_is, 0, start.inverse
            self._common = start
            return start
        rows = np.ascontiguousarray(start)
        struct.start, struct.apart, struct.inverse = address(rows), rows.shape[1], 0.0
        self._common = None
        return rows

    def _make_room(self, count: int) -> None:
        self.gap, self.ways = np.empty(count), np.empty((count, self._motors))
        self._where_ways_are = address(self.ways)
        self.iterations, self.end = np.empty((2, count), dtype=np.int64)
        struct = self._struct
        struct.gap, struct.iterations = address(self.gap), address(self.iterations)
        struct.end = address(self.end)

    @property
    def is_over(self) -> bool:
        """Whether no path leads further."""
        return not self._struct.busy

    @property
    def all_arrived(self) -> bool:
        """Whether all paths that were taken are at their targets."""
        return bool(self._struct.arrived == self._struct.count)
