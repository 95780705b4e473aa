"""Programs that take a machine's parameters as inputs: of all designs at once, recorded once.

Behind what a program of one machine takes stand the values of some parameters, and 1/length of the
design's characteristic length, which makes metres and radians comparable. In which order K* is
reduced is chosen by where its entries are, for all designs: whether that holds at a pose of one is
certified there. Gaps and motions are told in characteristic lengths, so that what is asked of them
is the same for all.

Served are machines from files whose loops have no gears, and K* as many columns as rank.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.programs import PROGRAMS, objects
from pmjac_pin.algebra.singular_values import singular_values
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.tape_runner import run
from pmjac_pin.algebra.terms import Term
from pmjac_pin.closing.arms import Arms, arms_of
from pmjac_pin.closing.blueprint import Blueprint
from pmjac_pin.closing.parts import Parts
from pmjac_pin.closing.recorded_dimensions import RecordedDimensions
from pmjac_pin.closing.recorded_rates import DOUBTS, RecordedRates
from pmjac_pin.closing.recorded_step import LEG_STAGES, leg, leg_inputs
from pmjac_pin.errors import ArgumentError
from pmjac_pin.kinematics.dimensions import Dimensions
from pmjac_pin.kinematics.joint_steps import between
from pmjac_pin.kinematics.recorded import Recorder
from pmjac_pin.model.frames import find_frame
from pmjac_pin.model.loop_between_frames import LoopBetweenFrames
from pmjac_pin.model.loop_spec import JointLoop
from pmjac_pin.model.rows import Distance
from pmjac_pin.rates.sparse_qr import norm
from pmjac_pin.values.arrays import Array

_SAME_SCALE = 1e-9  # relative: else scales are not what they are taken for

Record = Callable[[RecordedRates, Sequence[Term]], Sequence[Any]]


class DesignPrograms:
    """Programs of the designs of one machine.

    Parameters
    ----------
    parts : Parts
        Of one of them; parameters that are no inputs stay as they are there.
    blueprint : Blueprint
        What it was made of.
    names : sequence of str
        The parameters that are inputs.

    Attributes
    ----------
    names : tuple of str
    arms_of_loops : tuple of slice
        Which of `sizes_tape`'s outputs are the arms of each loop.

    Raises
    ------
    ArgumentError
        A machine that is not served.
    """

    def __init__(self, parts: Parts, blueprint: Blueprint, names: Sequence[str]) -> None:
        self.names, self._parts = tuple(names), parts
        self._dimensions = RecordedDimensions(parts, blueprint)
        self._check_loops()
        partition = parts.problem.partition
        mine = self._scales(1.0 / partition.length, self._dimensions.at(parts.values))
        for scale, known in zip(mine, (partition.row_scale, partition.column_scale), strict=True):
            if not np.allclose(scale.astype(float), known, rtol=_SAME_SCALE, atol=0.0):
                raise ArgumentError("the scales of this machine are not those of one length alone")

    @property
    def inputs(self) -> int:
        """How many numbers a design is."""
        return len(self.names) + 1

    def numbers(self, values: Array, length: Array | float) -> Array:
        """Return designs (d, inputs) of the parameters' values (d, k) and lengths, m."""
        per_length = np.broadcast_to(1.0 / np.asarray(length), len(values))
        return np.column_stack([values, per_length])

    @cached_property
    def move(self) -> Tape:
        """`RecordedRates.move_tape`: it is the same for all."""
        return Tape.recorded(self._parts.model.nq + self._parts.model.nv, self._own.move)

    @cached_property
    def between(self) -> Tape:
        """(q, q′) ↦ v with q ⊕ v = q′: it is the same for all."""

        def make(inputs: Sequence[Term]) -> list[Any]:
            one, other = np.split(objects(inputs), 2)
            way: list[Any] = between(PROGRAMS, self._own.recorder.tree, one, other).tolist()
            return way

        return Tape.recorded(2 * self._parts.model.nq, make)

    @cached_property
    def arrival(self) -> Tape:
        """`RecordedRates.arrival_tape`, gap and sizes in characteristic lengths."""
        nq, count = self._parts.model.nq, self._own.arrival_inputs

        def make(inputs: Sequence[Term]) -> list[Any]:
            design = inputs[count:]
            outputs = self.rates(design).arrival(inputs[:count])
            for place in (nq, nq + 3, nq + 4):
                outputs[place] = outputs[place] * design[-1]
            return outputs

        return Tape.recorded(count + self.inputs, make)

    @cached_property
    def leg(self) -> Tape:
        """`leg_tape`."""
        count = leg_inputs(self._own.recorder)

        def make(inputs: Sequence[Term]) -> list[Any]:
            dimensions, rates = self._recorded(inputs[count:])
            return leg(rates, self._arms(dimensions), inputs[:count])

        return Tape.recorded(count + self.inputs, make, LEG_STAGES)

    @cached_property
    def measures(self) -> Tape:
        """`RecordedRates.measures_tape`."""
        return self._of_poses(RecordedRates.measures)

    @cached_property
    def jacobian(self) -> Tape:
        """`RecordedRates.jacobian_tape` in LOCAL_WORLD_ALIGNED."""

        def judged(rates: RecordedRates, q: Sequence[Term]) -> list[Any]:
            return rates.equivalent(rates.recorder.at(q), "LOCAL_WORLD_ALIGNED").judged()

        return self._of_poses(judged)

    @cached_property
    def sizes(self) -> Tape:
        """Q ↦ what `Size` measures: rods and lever arms of loops, then the places it looks at."""
        return self._of_poses(self._measured)

    @cached_property
    def arms_of_loops(self) -> tuple[slice, ...]:
        """Which of the outputs of `sizes` are rods and arms of each loop."""
        loops, ends = self._parts.kinematics.loops, []
        for rows, pair in zip(loops.slices, loops.ends, strict=True):
            rods = sum(rows.start <= row < rows.stop for row in loops.rods)
            ends.append(rods + sum(self._turning(end.columns).size for end in pair))
        stops = np.cumsum([0, *ends]).tolist()
        return tuple(slice(*pair) for pair in itertools.pairwise(stops))

    def nearness(self, poses: Array) -> Array:
        """Return the smallest singular value of K*, beside the size of [K K*], shape (b,).

        Parameters
        ----------
        poses : ndarray, shape (nq + inputs, b)
            And the design of each.
        """
        partition, told = self._parts.problem.partition, run(self.measures, poses)
        entries = told[DOUBTS + 6 * partition.actuated.size + 15 :]
        like = entries.reshape(-1, partition.passive.size, poses.shape[1])
        nearness: Array = singular_values(like, (partition.passive_rank - 1,))[0] / told[2]
        return nearness

    def rates(self, design: Sequence[Any]) -> RecordedRates:
        """Return what records, at numbers of a design."""
        return self._recorded(design)[1]

    def _of_poses(self, record: Record) -> Tape:
        nq = self._parts.model.nq

        def make(inputs: Sequence[Term]) -> Sequence[Any]:
            return record(self.rates(inputs[nq:]), inputs[:nq])

        return Tape.recorded(nq + self.inputs, make)

    @cached_property
    def _own(self) -> RecordedRates:
        """What records the machine that is known."""
        parts = self._parts
        recorder = Recorder(parts.model, parts.spec, parts.values, parts.place)
        return RecordedRates(recorder, parts.problem.partition, parts.problem.partition.passive)

    def _recorded(self, design: Sequence[Any]) -> tuple[Dimensions, RecordedRates]:
        parts = self._parts
        values = {**parts.values, **dict(zip(self.names, design, strict=False))}
        dimensions = self._dimensions.at(values)
        rows, columns = self._scales(design[-1], dimensions)
        partition = replace(
            parts.problem.partition,
            length=1.0 / design[-1],
            row_scale=_sealed(rows),
            column_scale=_sealed(columns),
        )
        recorder = Recorder(parts.model, parts.spec, parts.values, parts.place, dimensions)
        return dimensions, RecordedRates(recorder, partition, partition.passive)

    def _scales(self, per_length: Any, dimensions: Dimensions) -> tuple[Numbers, Numbers]:
        """Return the scales of rows and columns, as `closing.scales` has them."""
        loops, rotational = self._parts.kinematics.loops, self._parts.coordinates.rotational
        columns = [per_length if turns else 1.0 for turns in rotational.tolist()]
        rows = [1.0 / per_length if unit == "rad" else 1.0 for unit in loops.row_units]
        for row, rod in self._rods(dimensions.values).items():
            rows[row] = 0.5 / rod
        return objects(rows), objects(columns)

    def _rods(self, values: Mapping[str, Any]) -> dict[int, Any]:
        rods, row = {}, 0
        for loop in self._loops:
            for block in loop.rows(values):
                if isinstance(block, Distance):
                    rods[row] = block.length
                row += len(block.names)
        return rods

    def _arms(self, dimensions: Dimensions) -> Arms:
        parts = self._parts
        return arms_of(parts.model, parts.spec.loops, dimensions.values, dimensions)

    def _measured(self, rates: RecordedRates, q: Sequence[Term]) -> list[Any]:
        """Record rods and arms, loop by loop, then the places of frames and tool."""
        loops = self._parts.kinematics.loops
        rods = {row: 0.5 / rates.partition.row_scale[row] for row in loops.rods}
        found: list[Any] = []
        places: list[Any] = []
        for rows, pair, frames in zip(
            loops.slices, loops.ends, self._frames_of_loops(), strict=True
        ):
            found += [rods[row] for row in rods if rows.start <= row < rows.stop]
            for end, motion in zip(pair, rates.recorder.motions(q, frames), strict=True):
                turning = self._turning(end.columns)
                found += _recorded_distances(motion.jacobian[:, turning, 0])
                places += motion.position[:, 0].tolist()
        return [*found, *places, *rates.recorder.at(q).position]

    def _frames_of_loops(self) -> list[list[Any]]:
        model = self._parts.model
        return [[find_frame(model, name) for name in loop.frames] for loop in self._loops]

    @property
    def _loops(self) -> list[LoopBetweenFrames]:
        return [loop for loop in self._parts.spec.loops if not isinstance(loop, JointLoop)]

    def _turning(self, columns: Any) -> Any:
        return columns[self._parts.coordinates.rotational[columns]]

    def _check_loops(self) -> None:
        """Raise where loops or scales are of a kind that is not served."""
        parts, partition = self._parts, self._parts.problem.partition
        if len(self._loops) < len(parts.spec.loops):
            raise ArgumentError("loops of geared joints are not recorded for all designs")
        ranks = {partition.passive.size, partition.passive_rank, partition.constraint_rank}
        regular = len(ranks) == 1 and partition.tool_full and not partition.isolated
        if not (regular and partition.passive.size):
            raise ArgumentError("passive joints do not follow the motors by loops alone")
        ends = parts.kinematics.loops.ends
        if not all(sum(self._turning(end.columns).size for end in pair) for pair in ends):
            raise ArgumentError("a loop in which nothing turns is measured otherwise")
        if parts.problem.given_tolerance:
            raise ArgumentError("with a tolerance of its own a machine is for itself")
        if parts.place.any() or set(partition.loop_sizes) != {partition.length}:
            raise ArgumentError("a machine far from the origin, or with small loops, is for itself")


def _recorded_distances(motions: Numbers) -> list[Any]:
    """Return how far a point is from the axes that turn it, as `Size` does."""
    found = []
    for linear, angular in zip(motions[:3].T, motions[3:].T, strict=True):
        along = linear @ angular
        found.append(norm(objects(a - along * b for a, b in zip(linear, angular, strict=True))))
    return found


def _sealed(numbers: Numbers) -> Numbers:
    numbers.setflags(write=False)
    return numbers
