"""J_eq at many poses by a program: by the kernel, or by NumPy where none was built."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.batches.judge import FELT, certain_jacobians, rank_bounds
from pmjac_pin.batches.rates_in_lanes import RatesInLanes, rates_kernel
from pmjac_pin.closing.recorded_rates import DOUBTS, SPREAD
from pmjac_pin.rates.many_radii import fill_radii, radii_kernel
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, Mask
from pmjac_pin.values.spares import Spares

if TYPE_CHECKING:
    from pmjac_pin.algebra.compiled_programs import CompiledProgram


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

    Attributes
    ----------
    goes_ahead : bool
        Whether it can follow a walk.
    """

    def __init__(
        self,
        tape: Tape,
        partition: Partition,
        tolerance: float,
        compiled: CompiledProgram | None = None,
    ) -> None:
        self._tape, self._partition, self._tolerance = tape, partition, tolerance
        self._compiled, self._spares, self._finds_radii = compiled, None, False
        self.goes_ahead = False
        if (library := rates_kernel()) is not None:
            bounds = rank_bounds(partition)
            asked = (tolerance, bounds.weakest, bounds.tolerance, bounds.least_size, FELT, SPREAD)
            motors = partition.actuated.size
            self._finds_radii = radii_kernel() is not None
            self.goes_ahead = self._finds_radii and not partition.isolated
            self._spares = Spares(partial(RatesInLanes, library, tape, asked, motors, compiled))

    def fill(self, poses: Array, J_eq: Array, radii: Sequence[Array] = ()) -> tuple[Array, Mask]:
        """Find J_eq; return the other numbers of the program, and where J_eq is certain.

        Parameters
        ----------
        poses : ndarray, shape (N, nq)
        J_eq : ndarray, shape (N, 6, n)
            Where it goes, row by row.
        radii : sequence of two ndarray, optional
            Where those of its blocks go, of shapes (N, 3), as `fill_radii` finds them beside the
            other numbers, which are sizes.

        Returns
        -------
        ndarray, ndarray of bool
            Shapes (k, N), of what the tape gives behind J_eq, and (N,).
        """
        if radii and not self._finds_radii:
            sizes, certain = self.fill(poses, J_eq)
            fill_radii(J_eq, sizes, *radii)
            return sizes, certain
        if self._spares is None:
            return self._by_numpy(poses, J_eq)
        memory = self._spares.take()
        memory.take(J_eq, radii)
        memory.run(poses)
        others, certain = memory.told()
        self.put_back(memory)
        if self._partition.isolated:
            certain.fill(False)
        return others, certain

    def ahead(self, J_eq: Array, radii: Sequence[Array]) -> RatesInLanes:
        """Return what fills these as soon as a walk that it follows has filled as many poses.

        To be put back when what it has found is not needed.

        Raises
        ------
        RuntimeError
            Where it does not go ahead.
        """
        if self._spares is None or not self.goes_ahead:
            raise RuntimeError("nothing goes ahead: no kernel finds it, or it is certain nowhere")
        memory = self._spares.take()
        memory.take(J_eq, radii)
        return memory

    def put_back(self, memory: RatesInLanes) -> None:
        """Leave memory to others."""
        if self._spares is not None:
            self._spares.put_back(memory)

    def _by_numpy(self, poses: Array, J_eq: Array) -> tuple[Array, Mask]:
        told = run(self._tape, poses.T) if self._compiled is None else self._compiled.run(poses.T)
        entries, count = told[DOUBTS:], J_eq.shape[1] * J_eq.shape[2]
        J_eq[:] = entries[:count].reshape(*J_eq.shape[1:], -1).transpose(2, 0, 1)
        return entries[count:], certain_jacobians(self._partition, self._tolerance, told)
