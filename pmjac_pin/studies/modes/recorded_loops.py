"""The loop equations over boxes as a program, which a kernel runs over many boxes at once."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.fixed_terms import apart
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.programs import zeros
from pmjac_pin.algebra.recorded_boxes import RecordedBoxes
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.studies.modes.box_equations import Cuts, Enclosed
from pmjac_pin.studies.modes.interval_loops import IntervalLoops
from pmjac_pin.studies.modes.pruning_kernel import LoopsInLanes, enclosed, pruning_kernel
from pmjac_pin.values.arrays import Array


@dataclass(frozen=True, slots=True, eq=False)
class BoxProgram:
    """The equations of a mechanism over boxes of its unknowns, whatever its motors' values.

    Attributes
    ----------
    library : ctypes.CDLL
        The kernel that runs it.
    fixed : Tape
        What is the same for all boxes: of 0 for each unknown, the motors' values and `constants`.
    whole, values : Tape
        Of the unknowns and what is fixed, as `LoopsInLanes` has them.
    constants : Intervals
    """

    library: ctypes.CDLL
    fixed: Tape
    whole: Tape
    values: Tape
    constants: Intervals


def recorded(loops: IntervalLoops) -> BoxProgram | None:
    """Return equations as a program, None where no kernel was built that runs it.

    To record them takes about as long as to enclose them once without the kernel. None, too, where
    rows of a kind from elsewhere have doubles in them that may have been rounded.
    """
    kernel = pruning_kernel()
    if kernel is None:
        return None
    unknowns = len(loops.places)
    boxes = RecordedBoxes(unknowns + len(loops.tree.given))
    residual, jacobian, cosines = _recorded(boxes, loops)
    outputs = [*residual, *jacobian.ravel(), *cosines]
    fixed, later, outputs = apart(boxes.recording, unknowns, outputs)
    values = Tape.of(later, outputs[: len(residual)])
    whole, before = Tape.of(later, outputs), Tape.of(boxes.recording, fixed)
    if not all(float(x).is_integer() for tape in (before, whole) for x in tape.constants):
        return None
    return BoxProgram(kernel, before, whole, values, boxes.constants)


class RecordedLoops:
    """All equations of a mechanism over boxes (b, k) of its unknowns, by their program.

    Parameters
    ----------
    program : BoxProgram
    loops : IntervalLoops
        The same, not recorded, at the motors' values.

    Attributes
    ----------
    names : tuple of str
        Of the p rows.
    tolerance : ndarray, shape (p,)
        How far each row can be from 0 at a pose that counts as closed.
    """

    __slots__ = ("_lanes", "_unknowns", "names", "tolerance")

    def __init__(self, program: BoxProgram, loops: IntervalLoops) -> None:
        self.names, self.tolerance = loops.names, loops.tolerance
        self._unknowns, library = len(loops.places), program.library
        motors = Intervals.exact([0.0] * self._unknowns + list(loops.tree.given.values()))
        given = enclosed(library, program.fixed, Intervals.join([motors, program.constants]))
        self._lanes = LoopsInLanes(library, program.whole, program.values, given, self.tolerance)

    def evaluate(self, box: Intervals) -> Enclosed:
        """Return all rows and their derivatives by all unknowns."""
        count, rows, unknowns = len(box.lower), len(self.names), self._unknowns
        found = self._lanes.enclose(box)
        rates = found[rows : rows * (unknowns + 1)]
        lower, upper = (
            end.reshape(rows, unknowns, count).transpose(2, 0, 1)
            for end in (rates.lower, rates.upper)
        )
        return Enclosed(
            Intervals(found.lower[:rows].T, found.upper[:rows].T),
            Intervals(lower, upper),
            np.asarray(~(found.upper[rows * (unknowns + 1) :] <= 0.0).any(axis=0)),
        )

    def residual(self, box: Intervals) -> Intervals:
        """Return all rows, shape (b, p)."""
        return self.evaluate(box).residual

    def narrowed(self, box: Intervals, scale: Array, progress: float) -> tuple[Intervals, Cuts]:
        """Return boxes narrowed, and what becomes of each."""
        return self._lanes.narrowed(box, scale, progress)


def _recorded(boxes: RecordedBoxes, loops: IntervalLoops) -> tuple[Numbers, Numbers, list[Any]]:
    """Return rows (p,), derivatives (p, k) and cosines over the unknowns and the given values."""
    tree = loops.tree
    inputs = dict(zip((*tree.unknowns, *tree.given), boxes.recording.inputs, strict=True))
    poses = tree.at(boxes, lambda name: boxes.numbers([inputs[name]])[0], True)
    blocks, cosines = loops.at(poses)
    residual, jacobian = zeros(len(loops.names)), zeros(len(loops.names), len(loops.places))
    start = 0
    for block in blocks:
        where = slice(start, start + block.value.shape[0])
        start = where.stop
        residual[where] = block.value[:, 0, 0]
        if block.columns:
            jacobian[where, [loops.places[column] for column in block.columns]] = block.rates[
                ..., 0
            ]
    return residual, jacobian, [cosine[0, 0] for cosine in cosines]
