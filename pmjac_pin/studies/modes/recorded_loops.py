"""The loop equations over boxes as a program, which a kernel runs over many boxes at once."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.fixed_terms import apart
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.programs import zeros
from pmjac_pin.algebra.recorded_boxes import RecordedBoxes
from pmjac_pin.algebra.tape import Tape
from pmjac_pin.studies.modes.box_equations import BoxEquations, Cuts, Enclosed
from pmjac_pin.studies.modes.interval_loops import IntervalLoops
from pmjac_pin.studies.modes.pruning_kernel import LoopsInLanes, enclosed, pruning_kernel
from pmjac_pin.values.arrays import Array


def recorded(loops: IntervalLoops) -> BoxEquations:
    """Return the same equations, as a program where a kernel was built that runs it.

    To record them takes about as long as to enclose them once without the kernel.
    """
    kernel = pruning_kernel()
    return loops if kernel is None else RecordedLoops(kernel, loops)


class RecordedLoops:
    """All equations of a mechanism over boxes (b, k) of its unknowns, recorded.

    Parameters
    ----------
    library : ctypes.CDLL
        The kernel.
    loops : IntervalLoops
        The same, not recorded.

    Attributes
    ----------
    names : tuple of str
        Of the p rows.
    tolerance : ndarray, shape (p,)
        How far each row can be from 0 at a pose that counts as closed.
    """

    __slots__ = ("_lanes", "_unknowns", "names", "tolerance")

    def __init__(self, library: ctypes.CDLL, loops: IntervalLoops) -> None:
        self.names, self.tolerance = loops.names, loops.tolerance
        self._unknowns = len(loops.places)
        boxes = RecordedBoxes(self._unknowns + len(loops.tree.given))
        residual, jacobian, cosines = _recorded(boxes, loops)
        outputs = [*residual, *jacobian.ravel(), *cosines]
        fixed, later, outputs = apart(boxes.recording, self._unknowns, outputs)
        known = Intervals.exact([0.0] * self._unknowns + list(loops.tree.given.values()))
        given = Intervals.join([known, boxes.constants])
        self._lanes = LoopsInLanes(
            library,
            Tape.of(later, outputs),
            Tape.of(later, outputs[: len(residual)]),
            enclosed(library, Tape.of(boxes.recording, fixed), given),
            self.tolerance,
        )

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
