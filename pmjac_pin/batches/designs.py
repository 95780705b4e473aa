"""Many poses, each of a design of its own: the same machine at other values of its parameters.

Nothing is built or recorded for a design: programs take its parameters as inputs, home poses of all
are found at once, and paths of all are walked in the same lanes. What is not certain there has the
status NOT_DONE, and is left to the design's own mechanism, which says the same of the others.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.batches.judge import certain_jacobians
from pmjac_pin.batches.measures import fill_measures
from pmjac_pin.batches.result_shapes import empty_arrays, shapes_of
from pmjac_pin.batches.results import (
    ManyClosed,
    ManyJacobians,
    ManyMeasures,
    Status,
    Statuses,
)
from pmjac_pin.closing.closure_problem import CLOSURE_TOLERANCE, ClosureProblem
from pmjac_pin.closing.design_homes import DesignHomes, DesignsOfFile
from pmjac_pin.closing.design_programs import DesignPrograms
from pmjac_pin.closing.many_paths import Paths, Walker
from pmjac_pin.closing.path_kernel import many_paths_kernel
from pmjac_pin.closing.paths_in_lanes import PathsInLanes
from pmjac_pin.closing.recorded_rates import DOUBTS
from pmjac_pin.closing.straight_path import HARDLY_ANYTHING, LARGEST_STEP, MOST_STEPS
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.limits import beyond_limits
from pmjac_pin.rates.many_radii import fill_radii
from pmjac_pin.values.arrays import Array, Index, Mask

_BESIDE = 0.02  # rad or lengths: where motors are led to see that they move
_LESS = 1.0 - 1e-6  # of the rank tolerance: what is nearer to it is not certain
_LARGER = 2.0  # than at any home: what the size of [K K*] is taken for where it vanishes


class Designs:
    """The designs of one mechanism.

    Attributes
    ----------
    mechanism : Mechanism
        One of them.
    programs : DesignPrograms
    """

    def __init__(self, mechanism: Mechanism, designs: DesignsOfFile) -> None:
        self.mechanism, self.programs, self._designs = mechanism, designs.programs, designs

    @classmethod
    def of(cls, mechanism: Mechanism, swept: Iterable[str]) -> Designs | None:
        """Return designs that differ in some parameters; None for machines that are not served.

        Raises
        ------
        NoToolError
        """
        mechanism.need_tool()
        if mechanism.blueprint is None:
            return None
        designs = mechanism.recorded.designs(mechanism.blueprint, swept)
        return None if designs is None else cls(mechanism, designs)

    def at(self, values: Array, which: Index) -> DesignBatch:
        """Return what computes poses of designs.

        Parameters
        ----------
        values : ndarray, shape (d, k)
            Of the swept parameters.
        which : ndarray of int, shape (N,)
            The design of each pose.
        """
        homes = self._designs.homes(values)
        moving = DesignBatch(self, homes, np.arange(len(values))).moves()
        return DesignBatch(self, replace(homes, certain=homes.certain & moving), which)


@dataclass(frozen=True, eq=False)
class DesignBatch:
    """Many poses of designs, in the order of `which`.

    Attributes
    ----------
    of : Designs
    homes : DesignHomes
    which : ndarray of int, shape (N,)
    """

    of: Designs
    homes: DesignHomes
    which: Index

    def part(self, which: Index | slice) -> DesignBatch:
        """Return that of some of the poses."""
        return replace(self, which=self.which[which])

    def close(self, values: Array, whose: str) -> ManyClosed:
        """Close the loops from each design's home, as `Batch.close` does.

        Parameters
        ----------
        values : ndarray, shape (N, n)
            Of the motors.
        whose : str
            Limits: "none", "motors" or "all".
        """
        mechanism = self.of.mechanism
        coordinates, motors = mechanism.coordinates, mechanism.problem.partition.actuated
        paths = self._paths(values)
        certain = self.homes.certain[self.which] & paths.settled
        status = np.where(paths.share == 1.0, Status.CLOSED, Status.STOPPED).astype(np.int8)
        if whose != "none":
            status[coordinates.beyond(values, motors).any(axis=1)] = Status.LIMITS
        if whose == "all":
            status[beyond_limits(coordinates, paths.q) & (status == Status.CLOSED)] = Status.LIMITS
        status[~certain] = Status.NOT_DONE
        return ManyClosed(paths.q, paths.share, status, coordinates=coordinates)

    def jacobian(self, q: Array) -> ManyJacobians:
        """Return J_eq in LOCAL_WORLD_ALIGNED at closed poses (N, nq)."""
        told = run(self._programs.jacobian, self._inputs(q))
        J_eq, status = self._judged(told)
        return ManyJacobians(J_eq.transpose(2, 0, 1), status)

    def measures(self, q: Array) -> ManyMeasures:
        """Return what `Batch.measures` does at closed poses (N, nq)."""
        n, inputs = self._motors.size, self._inputs(q)
        found = empty_arrays(shapes_of(ManyMeasures, len(q), n))

        def fill(part: slice, J_eq: Array) -> tuple[Array, Mask]:
            told = run(self._programs.measures, inputs[:, part])
            entries, status = self.part(part)._judged(told)
            J_eq[:] = entries.transpose(2, 0, 1)
            return told[DOUBTS + 6 * n :], status == Status.CLOSED

        partition = replace(self._problem.partition, size=0.0)
        sizes, certain = fill_measures(fill, partition, list(found.values()))
        found["status"][:] = np.where(certain, Status.CLOSED, Status.NOT_DONE)
        fill_radii(found["J_eq"], sizes, found["velocity_radii"], found["angular_radii"])
        return ManyMeasures(**found)

    def moves(self) -> Mask:
        """Tell of which poses' designs the motors lead away from home, and K* can follow there.

        That is what their ranks rest on: where loops forbid some of it, they close nowhere beside.
        """
        values = self.of.mechanism.coordinates.values_of(self._start, self._motors)
        direction = np.random.default_rng(0).uniform(0.5, 1.0, self._motors.size)
        moving = np.ones(len(values), dtype=bool)
        for way in (_BESIDE, -_BESIDE):
            paths = self._paths(values + way * direction * self._strokes)
            moving &= paths.settled & (paths.share == 1.0)
            moving &= self._judged(run(self._programs.jacobian, self._inputs(paths.q)))[1] == 0
        return moving

    @property
    def at_rest(self) -> Array:
        """The motors' values at home, shape (N, n)."""
        return self.of.mechanism.coordinates.values_of(self._start, self._motors)

    @property
    def _programs(self) -> DesignPrograms:
        return self.of.programs

    @property
    def _motors(self) -> Index:
        return self.of.mechanism.problem.partition.actuated

    @property
    def _start(self) -> Array:
        return self.homes.q[self.which]

    @property
    def _strokes(self) -> Array:
        """What counts as one length of each motor, rad or m, shape (N, n)."""
        turns = self.of.mechanism.coordinates.rotational[self._motors]
        return np.where(turns, 1.0, self.homes.length[self.which][:, None])

    @property
    def _problem(self) -> ClosureProblem:
        """The problem of all: lengths in characteristic ones."""
        problem = self.of.mechanism.problem
        sizes = self.homes.size[self.homes.certain]
        partition = problem.partition
        ones = np.ones(partition.column_scale.size)
        largest = _LARGER * float(sizes.max(initial=partition.size))
        unit = replace(partition, length=1.0, column_scale=ones, size=largest)
        return replace(problem, partition=unit, rounding=0.0)

    def _inputs(self, q: Array) -> Array:
        return np.vstack([q.T, self.homes.designs[self.which].T])

    def _paths(self, values: Array) -> Paths:
        """Walk from home to motor values; what is not settled is not known."""
        coordinates, start = self.of.mechanism.coordinates, self._start
        at_rest = coordinates.values_of(start, self._motors)
        displacement = coordinates.shorter_way(at_rest, values, self._motors)
        designs = self.homes.designs[self.which]
        paths = self._walker().walk(start, displacement, values, lambda: None, design=designs)
        far = np.linalg.norm(displacement / self._strokes, axis=1)
        ended = (paths.share > 0.0) & ((1.0 - paths.share) * far > HARDLY_ANYTHING)
        settled = (paths.settled | self._singular(paths)) & (far <= MOST_STEPS * LARGEST_STEP)
        return paths._replace(settled=settled & ((paths.share == 1.0) | ended))

    def _singular(self, paths: Paths) -> Mask:
        """Tell which paths that are not settled end where K* has less rank than it may have."""
        singular, which = paths.settled & False, np.flatnonzero(~paths.settled)
        if which.size:
            programs, partition = self._programs, self._problem.partition
            poses = np.vstack([paths.q[which].T, self.homes.designs[self.which[which]].T])
            smallest = programs.nearness(poses)
            singular[which] = smallest < _LESS * partition.rank_tolerance
        return singular

    def _walker(self) -> Walker | PathsInLanes:
        programs, coordinates = self._programs, self.of.mechanism.coordinates
        tapes: tuple[Tape, Tape, Tape] = programs.move, programs.arrival, programs.leg
        library = many_paths_kernel()
        if library is None:
            return Walker(self._problem, coordinates, *tapes)
        return PathsInLanes(library, tapes, self._problem, coordinates)

    def _judged(self, told: Array) -> tuple[Array, Statuses]:
        """Return J_eq (6, n, N), and NOT_DONE where it is not certain."""
        partition, tolerance = self._problem.partition, CLOSURE_TOLERANCE * self.homes.length
        certain = certain_jacobians(partition, tolerance[self.which], told)
        certain &= told[2] >= partition.least_size
        status = np.where(certain, Status.CLOSED, Status.NOT_DONE).astype(np.int8)
        n = self._motors.size
        return told[DOUBTS : DOUBTS + 6 * n].reshape(6, n, -1), status
