"""Programs: numbers that are recorded operations, so that kinematics becomes straight-line code.

Each term is an operation on earlier terms and on doubles. The same operation on the same operands
is the same term, zeros and ones are never multiplied or added, and signs are drawn outwards, so
that a sum and its opposite are one term as well.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Any, Literal, Union

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.algebra.arrays import Arrays, Numbers
from pmjac_pin.values.arrays import Array

Operation = Literal[
    "input", "+", "-", "*", "/", "neg", "sin", "cos", "sqrt", "abs", "max", "copysign", "atan2",
    "round",
]  # fmt: skip

#: What an operation is of: terms, doubles, or the number of an input.
Operand = Union["Term", float, int]


class Recording:
    """The terms of a program, in an order in which they can be computed.

    Parameters
    ----------
    inputs : int
        How many numbers the program is a function of.

    Attributes
    ----------
    terms : list of Term
        The inputs first.

    Examples
    --------
    >>> recording = Recording(2)
    >>> x, y = recording.inputs
    >>> (x + y) * 0.0, (x + 0.0) is x, (x - y) is -(y - x)
    (0.0, True, True)
    """

    __slots__ = ("_known", "inputs", "terms")

    def __init__(self, inputs: int) -> None:
        self.terms: list[Term] = []
        self._known: dict[Operation, dict[tuple[Operand, ...], Term]] = defaultdict(dict)
        self.inputs = tuple(self.term("input", index) for index in range(inputs))

    def input(self) -> Term:
        """Return one input more."""
        found = self.term("input", len(self.inputs))
        self.inputs = (*self.inputs, found)
        return found

    def term(self, operation: Operation, *operands: Operand) -> Term:
        """Return the term of an operation, a new one where it was not recorded before."""
        known = self._known[operation]  # by operands: terms are equal where they are the same
        found = known.get(operands)
        if found is None:
            found = known[operands] = Term(self, len(self.terms), operation, operands)
            self.terms.append(found)
        return found

    def forget(self) -> None:
        """Let all terms go, which know their recording, so that their memory is free at once."""
        self.terms, self.inputs = [], ()
        self._known.clear()


class Term:
    """A number of a program.

    Attributes
    ----------
    recording : Recording
    index : int
        Among the terms.
    operation : str
    operands : tuple of Term, float or int
    """

    __slots__ = ("index", "operands", "operation", "recording")

    def __init__(
        self,
        recording: Recording,
        index: int,
        operation: Operation,
        operands: tuple[Operand, ...],
    ) -> None:
        self.recording, self.index = recording, index
        self.operation, self.operands = operation, operands

    def __neg__(self) -> Any:
        if self.operation == "neg":
            return self.operands[0]
        if self.operation == "-":
            first, second = self.operands
            return self.recording.term("-", second, first)
        return self.recording.term("neg", self)

    def __add__(self, other: Any) -> Any:
        if not isinstance(other, Term):
            return self._plus_double(other)
        if other.operation == "neg":
            return self - other.operands[0]
        if self.operation == "neg":
            return other - self.operands[0]
        older, newer = (self, other) if self.index <= other.index else (other, self)
        return self.recording.term("+", older, newer)

    def _plus_double(self, other: float) -> Any:
        if other == 0.0:
            return self
        if other < 0.0:
            return self - (-other)
        if self.operation == "neg":
            return other - self.operands[0]
        return self.recording.term("+", float(other), self)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        if other is self:
            return 0.0
        if isinstance(other, Term):
            if other.operation == "neg":
                return self + other.operands[0]
        elif other == 0.0:
            return self
        elif other < 0.0:
            return self + (-other)
        if self.operation == "neg":
            return -(self.operands[0] + other)
        return self.recording.term("-", self, other)

    def __rsub__(self, other: float) -> Any:
        return -(self - other)

    def __mul__(self, other: Any) -> Any:
        if not isinstance(other, Term):
            return self._times_double(other)
        if self.operation == "neg":
            return -(self.operands[0] * other)
        if other.operation == "neg":
            return -(self * other.operands[0])
        older, newer = (self, other) if self.index <= other.index else (other, self)
        return self.recording.term("*", older, newer)

    def _times_double(self, other: float) -> Any:
        if other in (0.0, 1.0, -1.0):
            return 0.0 if other == 0.0 else self if other == 1.0 else -self
        if self.operation == "neg":
            return -(self.operands[0] * other)
        if other < 0.0:
            return -(self * -other)
        return self.recording.term("*", float(other), self)

    __rmul__ = __mul__

    def __abs__(self) -> Any:
        return self.recording.term("abs", self)

    def __truediv__(self, other: Any) -> Any:
        if isinstance(other, Term):
            return self.recording.term("/", self, other)
        return self * (1.0 / other)

    def __rtruediv__(self, other: float) -> Any:
        return 0.0 if other == 0.0 else self.recording.term("/", other, self)


class Programs(Arrays):
    """Recorded numbers, and doubles among them.

    Examples
    --------
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
