"""Rooted programs: recorded numbers that measure tilts and turns by their chords and angles."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.jets import half_skew
from pmjac_pin.algebra.programs import Programs

_NO_SINE = 1e-150  # of a turn that is none, and yet is divided by
_AXIS_LOST = 1e-12  # sine of an angle below which, at half a turn, the axis is lost


class RootedPrograms(Programs):
    """Recorded numbers, and doubles among them, whose rows are those of `Floats`.

    They take more operations than polynomials, and do not vanish at half a turn. Only for the
    last 1e-12 rad before it the axis of a turn is lost.

    Examples
    --------
    >>> from pmjac_pin.algebra.terms import Recording
    >>> rooted, recording = RootedPrograms(), Recording(1)
    >>> x = rooted.numbers(recording.inputs)
    >>> rooted.replaced(x, [2.0], x, 1.0).shape
    (1, 1, 1)
    """

    __slots__ = ()

    rooted = True

    def replaced(self, x: Numbers, by: ArrayLike, of: Numbers, least: float) -> Numbers:
        """Return x, constant where another number is below a double: both where x is finite."""
        kept = 0.5 + self.with_sign(0.5, of - least)
        return np.asarray(kept * x + (1.0 - kept) * self.constant(by))

    def rotation_vector(self, rotation: Numbers) -> Numbers:
        """Return log R; at half a turn, where the axis is lost, one of that length."""
        sine_axis = half_skew(self, rotation)
        cosine = 0.5 * (rotation[0, 0] + rotation[1, 1] + rotation[2, 2] - 1.0)
        sine = self.largest(self.sqrt(self.squared(sine_axis)), _NO_SINE)
        vector = sine_axis * (self.atan2(sine, cosine) / sine)
        # By 1 + cos(angle) alone, the square of how far it is, rounding would lose the axis sooner.
        short_of = sine + (1.0 + cosine)
        return self.replaced(vector, [math.pi, 0.0, 0.0], short_of, _AXIS_LOST)


ROOTED_PROGRAMS = RootedPrograms()
