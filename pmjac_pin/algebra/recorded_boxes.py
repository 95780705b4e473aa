"""Recorded boxes: programs whose numbers stand for intervals, so that none may be rounded.

Doubles that are written into a program would be multiplied and added as it is recorded, and so
rounded. Here all but −1, 0 and 1 are inputs of the program, whose values are intervals; whatever
comes of −1, 0 and 1 alone is a small whole number.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.programs import Programs, objects
from pmjac_pin.algebra.terms import Recording, Term
from pmjac_pin.values.arrays import Array


class RecordedBoxes(Programs):
    """Recorded numbers that stand for intervals.

    Parameters
    ----------
    inputs : int
        Of the program, before those that stand for its constants.

    Attributes
    ----------
    recording : Recording

    Examples
    --------
    >>> boxes = RecordedBoxes(1)
    >>> x = boxes.numbers(boxes.recording.inputs)
    >>> thrice = boxes.times(np.array([[3.0]]), x)[0, 0, 0]
    >>> thrice.operation, boxes.constants.lower.tolist()
    ('*', [3.0])
    """

    __slots__ = ("_known", "_lower", "_upper", "recording")

    def __init__(self, inputs: int) -> None:
        self.recording = Recording(inputs)
        self._known: dict[tuple[float, float], Term] = {}

    @property
    def constants(self) -> Intervals:
        """The values of the inputs after those that were asked for."""
        ends = np.array(list(self._known), dtype=float).reshape(-1, 2)
        return Intervals(ends[:, 0].copy(), ends[:, 1].copy())

    def exact(self, values: Array) -> Numbers:
        """Return doubles, or recorded numbers among them, as they are."""
        array = np.asarray(values)
        known = [x if isinstance(x, Term) else self._double(x) for x in array.ravel().tolist()]
        return objects(known).reshape(array.shape)

    def constant(self, values: ArrayLike) -> Numbers:
        """Return doubles, or recorded numbers among them, as numbers."""
        return self.exact(np.asarray(values))[..., None, None]

    def between(self, ends: Intervals) -> Numbers:
        """Return intervals as numbers, their axes the components."""
        pairs = zip(ends.lower.ravel().tolist(), ends.upper.ravel().tolist(), strict=True)
        return objects(self._input(*pair) for pair in pairs).reshape(*ends.shape, 1, 1)

    def _double(self, x: float) -> Term | float:
        if x in (-1.0, 0.0, 1.0):
            return float(x)
        return -self._input(-x, -x) if x < 0.0 else self._input(x, x)

    def _input(self, lower: float, upper: float) -> Term:
        key = (lower, upper)
        if key not in self._known:
            self._known[key] = self.recording.input()
        return self._known[key]
