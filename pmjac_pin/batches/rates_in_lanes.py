"""J_eq of many poses by the kernel: what it is given, and memory of one thread.

`Rates` of `many_rates.c` is one value, so that a walk of paths can ask for all of it as soon as
they have arrived: what calls C twice comes back to Python with cold caches twice.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from pmjac_pin.algebra.c_kernels import COUNT, NUMBER, POINTER, address, loaded
from pmjac_pin.algebra.lane_programs import PROGRAM_SOURCES, Memory, ProgramStruct
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.closing.kernel_walk import Following
from pmjac_pin.closing.recorded_rates import DOUBTS
from pmjac_pin.rates.many_radii import NOTHING, radii_kernel
from pmjac_pin.values.arrays import Array, Mask

if TYPE_CHECKING:
    from pmjac_pin.algebra.compiled_programs import CompiledProgram


class CertaintyStruct(ctypes.Structure):
    """`Certainty`."""

    _fields_ = tuple(
        (name, NUMBER)
        for name in ("tolerance", "weakest", "rank_tolerance", "least_size", "felt", "spread")
    )


class RatesStruct(ctypes.Structure):
    """`Rates`."""

    _fields_ = (
        ("program", ProgramStruct),
        ("asked", CertaintyStruct),
        *((name, POINTER) for name in ("radii", "nothing")),
        *((name, COUNT) for name in ("nq", "entries", "more")),
        *((name, POINTER) for name in ("J_eq", "others", "certain", "linear", "angular")),
        ("uncertain", COUNT),
    )


class RatesInLanes:
    """Memory of one thread in which the kernel finds J_eq.

    Parameters
    ----------
    library : ctypes.CDLL
    tape : Tape
    asked : sequence of float
        The numbers of `CertaintyStruct`.
    motors : int
    compiled : CompiledProgram, optional
        What computes the same as the tape.

    Attributes
    ----------
    following : Following
        What finds it behind a walk.
    """

    __slots__ = ("_certain", "_count", "_kept", "_others", "_run", "_struct", "following")

    def __init__(
        self,
        library: ctypes.CDLL,
        tape: Tape,
        asked: Sequence[float],
        motors: int,
        compiled: CompiledProgram | None = None,
    ) -> None:
        memory, radii = Memory(tape, library.pmjac_lanes(), compiled), radii_kernel()
        entries = 6 * motors
        self._struct = RatesStruct(
            memory.struct,
            CertaintyStruct(*asked),
            None if radii is None else ctypes.cast(radii.pmjac_radii, POINTER),
            ctypes.addressof(NOTHING),
            tape.inputs,
            entries,
            tape.outputs - DOUBTS - entries,
        )
        self._kept, self._run = memory, library.pmjac_rates
        function = ctypes.cast(library.pmjac_rates, POINTER).value
        self.following = Following(function, ctypes.addressof(self._struct), self._struct)
        self._others, self._certain, self._count = np.empty(0), np.empty(0, dtype=bool), 0

    def take(self, J_eq: Array, radii: Sequence[Array] = ()) -> None:
        """Take where J_eq goes and the radii of its blocks, row by row.

        The poses are told to `run`, or by the walk that it follows.
        """
        struct, count = self._struct, len(J_eq)
        if count > len(self._certain):
            self._make_room(count)
        self._count, struct.uncertain, struct.J_eq = count, -1, address(J_eq)
        if radii:
            linear, angular = radii
            struct.linear, struct.angular = address(linear), address(angular)
        else:
            struct.linear = struct.angular = None

    def run(self, poses: Array) -> None:
        """Find it at so many rows of q.

        Raises
        ------
        MemoryError
        """
        rows = np.ascontiguousarray(poses)
        if self._run(self.following.given, address(rows), len(rows)):
            raise MemoryError("no memory for singular values")

    @property
    def is_done(self) -> bool:
        """Whether all that was taken is found."""
        return bool(self._struct.uncertain >= 0)

    @property
    def is_certain(self) -> bool:
        """Whether it is found, and J_eq certain everywhere."""
        return bool(self._struct.uncertain == 0)

    def told(self) -> tuple[Array, Mask]:
        """Give away what the tape gives behind J_eq, (k, N), and where J_eq is certain, (N,)."""
        count, more = self._count, self._struct.more
        others = self._others[: more * count].reshape(more, count)
        certain, self._certain = self._certain[:count], np.empty(0, dtype=bool)
        return others, certain

    def _make_room(self, count: int) -> None:
        self._others = np.empty(self._struct.more * count)
        self._certain = np.empty(count, dtype=bool)
        self._struct.others, self._struct.certain = map(address, (self._others, self._certain))


@cache
def rates_kernel() -> ctypes.CDLL | None:
    """Return the kernel that was built from the source beside it, None where there is none."""
    sources = ("batches/many_rates.c", *PROGRAM_SOURCES)
    return loaded("batches/_many_rates.so", *sources, pmjac_rates=(POINTER, POINTER, COUNT))
