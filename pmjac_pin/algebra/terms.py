"""Terms: recorded operations, which can be computed with as numbers can.

Each term is an operation on earlier terms and on doubles. The same operation on the same operands
is the same term, zeros and ones are never multiplied or added, and signs are drawn outwards, so
that a sum and its opposite are one term as well.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any, Literal, Union

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
