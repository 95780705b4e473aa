"""J_eq at many poses by a program: by the kernel, or by NumPy where none was built."""

from __future__ import annotations

import ctypes
from functools import cache, partial
from typing import TYPE_CHECKING

import numpy as np

from pmjac_pin.algebra.c_kernels import COUNT, POINTER, address, loaded
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.batches.judge import FELT, certain_jacobians, rank_bounds
from pmjac_pin.closing.path_kernel import Memory
from pmjac_pin.closing.recorded_rates import DOUBTS, SPREAD
from pmjac_pin.rates.many_radii import NOTHING, fill_radii, radii_kernel
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, Mask
from pmjac_pin.values.spares import Spares

if TYPE_CHECKING:
    from pmjac_pin.algebra.compiled_programs import CompiledProgram

_NO_RADII = (None, None, None, None)


class ManyRates:
    """A program of J_eq.

    Parameters
    ----------
    tape : Tape
        `RecordedRates.jacobian_tape`, or one with more behind its numbers.
    partition : Partition
    tolerance : float
        Of closed poses, m.
    compiled : CompiledProgram, optional
        What computes the same as the tape.
    """

    def __init__(
        self,
        tape: Tape,
        partition: Partition,
        tolerance: float,
        compiled: CompiledProgram | None = None,
    ) -> None:
        self._tape, self._partition, self._tolerance = tape, partition, tolerance
        self._compiled, self._kernel = compiled, None
        if (library := rates_kernel()) is not None:
            self._kernel = library, Spares(partial(Memory, tape, library.pmjac_lanes(), compiled))
        radii = radii_kernel()
        self._radii = None if radii is None else ctypes.cast(radii.pmjac_radii, POINTER).value
        bounds = rank_bounds(partition)
        limits = (tolerance, bounds.weakest, bounds.tolerance, bounds.least_size, FELT, SPREAD)
        self._asked = (ctypes.c_double * len(limits))(*limits)

    def fill(
        self, poses: Array, J_eq: Array, radii: tuple[Array, Array] | tuple[()] = ()
    ) -> tuple[Array, Mask]:
        """Find J_eq; return the other numbers of the program, and where J_eq is certain.

        Parameters
        ----------
        poses : ndarray, shape (N, nq)
        J_eq : ndarray, shape (N, 6, n)
            Where it goes, row by row.
        radii : (ndarray, ndarray), optional
            Where those of its blocks go, of shapes (N, 3), as `fill_radii` finds them beside the
            other numbers, which are sizes.

        Returns
        -------
        ndarray, ndarray of bool
            Shapes (k, N), of what the tape gives behind J_eq, and (N,).
        """
        if radii and (self._kernel is None or self._radii is None):
            sizes, certain = self.fill(poses, J_eq)
            fill_radii(J_eq, sizes, *radii)
            return sizes, certain
        if self._kernel is None:
            return self._by_numpy(poses, J_eq)
        count, entries = len(poses), J_eq.shape[1] * J_eq.shape[2]
        others = np.empty((self._tape.outputs - DOUBTS - entries, count))
        certain, rows = np.empty(count, dtype=bool), np.ascontiguousarray(poses)
        library, spares = self._kernel
        memory = spares.take()
        failed = library.pmjac_rates(
            ctypes.byref(memory.struct),
            self._asked,
            address(rows),
            rows.shape[1],
            count,
            entries,
            len(others),
            *map(address, (J_eq, others, certain)),
            *((self._radii, NOTHING, *map(address, radii)) if radii else _NO_RADII),
        )
        spares.put_back(memory)
        if failed:
            raise MemoryError("no memory for singular values")
        if self._partition.isolated:
            certain.fill(False)
        return others, certain

    def _by_numpy(self, poses: Array, J_eq: Array) -> tuple[Array, Mask]:
        told = run(self._tape, poses.T) if self._compiled is None else self._compiled.run(poses.T)
        entries, count = told[DOUBTS:], J_eq.shape[1] * J_eq.shape[2]
        J_eq[:] = entries[:count].reshape(*J_eq.shape[1:], -1).transpose(2, 0, 1)
        return entries[count:], certain_jacobians(self._partition, self._tolerance, told)


@cache
def rates_kernel() -> ctypes.CDLL | None:
    """Return the kernel that was built from the source beside it, None where there is none."""
    sources = ("closing/walk.h", "algebra/tape_kernel.c", "algebra/lanes.h")
    library = loaded("batches/_many_rates.so", "batches/many_rates.c", *sources)
    if library is not None:
        library.pmjac_rates.argtypes = [*[POINTER] * 3, *[COUNT] * 4, *[POINTER] * 7]
    return library
