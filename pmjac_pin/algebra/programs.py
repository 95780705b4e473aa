"""Programs: arrays of terms and doubles, so that kinematics becomes straight-line code."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.algebra.arrays import Arrays, Numbers
from pmjac_pin.algebra.terms import Term
from pmjac_pin.values.arrays import Array


class Programs(Arrays):
    """Recorded numbers, and doubles among them.

    Examples
    --------
    >>> from pmjac_pin.algebra.terms import Recording
    >>> programs, recording = Programs(), Recording(1)
    >>> x = programs.numbers(recording.inputs)
    >>> square = programs.squared(programs.stack([programs.cos(x[0]), programs.constant(2.0)]))
    >>> [term.operation for term in recording.terms]
    ['input', 'cos', '*', '+']
    """

    __slots__ = ()

    def exact(self, values: Array) -> Numbers:
        """Return doubles, or recorded numbers among them, as they are."""
        return values if values.dtype == object else values.astype(float).astype(object)

    def constant(self, values: ArrayLike) -> Numbers:
        """Return doubles, or recorded numbers among them, as numbers."""
        return self.exact(np.asarray(values))[..., None, None]

    def numbers(self, terms: Sequence[Term]) -> Numbers:
        """Return terms as components."""
        return objects(terms)[:, None, None]

    def vanishes(self, x: Numbers) -> bool:
        """Tell whether x takes no part in a program: is zero at every pose."""
        return all(one == 0.0 for one in x.ravel())

    def cos(self, x: Any) -> Any:
        """Return cos x of a number, or of each."""
        return _COSINES(x)

    def sin(self, x: Any) -> Any:
        """Return sin x of a number, or of each."""
        return _SINES(x)

    def sqrt(self, x: Any) -> Any:
        """Return √x of a number, or of each."""
        return _ROOTS(x)

    def atan2(self, sine: Any, cosine: Any) -> Any:
        """Return the angle of a sine and a cosine, of a number, or of each."""
        return _ARCTANGENTS(sine, cosine)

    def largest(self, x: Any, y: Any) -> Any:
        """Return the larger of two numbers, or of each two."""
        return _MAXIMA(x, y)

    def with_sign(self, x: Any, of: Any) -> Any:
        """Return |x| with the sign of another number, or of each."""
        return _SIGNED(x, of)

    def unit(self, x: Numbers) -> Numbers:
        """Return x: what q holds of a turn has length 1, as Pinocchio takes it to have."""
        return x


PROGRAMS = Programs()


def root(x: Any) -> Any:
    """Return √x of a term or a double."""
    return x.recording.term("sqrt", x) if isinstance(x, Term) else math.sqrt(x)


def roots(x: Numbers) -> Numbers:
    """Return √x of each term or double."""
    return np.asarray(_ROOTS(x), dtype=object)


def largest(x: Any, y: Any) -> Any:
    """Return the larger of two terms or doubles."""
    if x is y or (not isinstance(y, Term) and y == -math.inf):
        return x
    if isinstance(x, Term):
        return x.recording.term("max", x, y)
    return y.recording.term("max", y, x) if isinstance(y, Term) else max(x, y)


def with_sign(x: Any, of: Any) -> Any:
    """Return |x| with the sign of another term or double."""
    if isinstance(of, Term):
        return of.recording.term("copysign", x, of)
    return abs(x) * math.copysign(1.0, of)


def cosine(x: Any) -> Any:
    """Return cos x of a term or a double."""
    return x.recording.term("cos", x) if isinstance(x, Term) else math.cos(x)


def sine(x: Any) -> Any:
    """Return sin x of a term or a double."""
    return x.recording.term("sin", x) if isinstance(x, Term) else math.sin(x)


def angle_of(y: Any, x: Any) -> Any:
    """Return atan2(y, x) of terms or doubles."""
    if isinstance(y, Term):
        return y.recording.term("atan2", y, x)
    return x.recording.term("atan2", y, x) if isinstance(x, Term) else math.atan2(y, x)


_ROOTS = np.frompyfunc(root, 1, 1)
_MAXIMA = np.frompyfunc(largest, 2, 1)
_SIGNED = np.frompyfunc(with_sign, 2, 1)
_COSINES = np.frompyfunc(cosine, 1, 1)
_SINES = np.frompyfunc(sine, 1, 1)
_ARCTANGENTS = np.frompyfunc(angle_of, 2, 1)


def objects(entries: Iterable[Any]) -> Numbers:
    """Return an array of terms and doubles."""
    known = list(entries)
    found = np.empty(len(known), dtype=object)
    found[:] = known
    return found


def zeros(*shape: int) -> Numbers:
    """Return an array of the double 0: what takes no part in a program."""
    found = np.empty(shape, dtype=object)
    found[...] = 0.0
    return found
