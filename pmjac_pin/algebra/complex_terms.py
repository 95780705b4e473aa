"""Complex numbers of a program: pairs of its terms, or of doubles.

Arrays of them are arrays of objects, to which NumPy's sums and products apply.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.programs import objects
from pmjac_pin.algebra.terms import Term


class ComplexTerm:
    """A complex number: its real and its imaginary part, each a term or a double.

    Examples
    --------
    >>> from pmjac_pin.algebra.terms import Recording
    >>> recording = Recording(2)
    >>> [z] = complex_terms(recording.inputs)
    >>> (z * 0.0).real, (z * 1j).imag is z.real, len(recording.terms)
    (0.0, True, 3)
    """

    __slots__ = ("imag", "real")

    def __init__(self, real: Term | float, imag: Term | float) -> None:
        self.real, self.imag = real, imag

    def __neg__(self) -> ComplexTerm:
        return ComplexTerm(-self.real, -self.imag)

    def __add__(self, other: Any) -> ComplexTerm:
        return ComplexTerm(self.real + other.real, self.imag + other.imag)

    __radd__ = __add__

    def __sub__(self, other: Any) -> ComplexTerm:
        return ComplexTerm(self.real - other.real, self.imag - other.imag)

    def __rsub__(self, other: Any) -> ComplexTerm:
        return ComplexTerm(other.real - self.real, other.imag - self.imag)

    def __mul__(self, other: Any) -> ComplexTerm:
        return ComplexTerm(
            self.real * other.real - self.imag * other.imag,
            self.real * other.imag + self.imag * other.real,
        )

    __rmul__ = __mul__

    def __rtruediv__(self, other: Any) -> ComplexTerm:
        square = self.real * self.real + self.imag * self.imag
        return ComplexTerm(self.real / square, -self.imag / square).__mul__(other)


def complex_terms(parts: Sequence[Term]) -> Numbers:
    """Return numbers of real and imaginary parts, one after the other."""
    pairs = zip(parts[::2], parts[1::2], strict=True)
    return objects(ComplexTerm(real, imag) for real, imag in pairs)


def real_and_imaginary(numbers: Iterable[Any]) -> list[Term | float]:
    """Return the real and the imaginary parts of numbers, one after the other."""
    return [part for number in numbers for part in (number.real, number.imag)]
