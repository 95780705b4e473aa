"""Tangents: how the terms of a program change as its inputs do, in forward mode."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from pmjac_pin.algebra.terms import Term
from pmjac_pin.errors import ArgumentError


def tangents(outputs: Sequence[Any], inputs: Sequence[Term], rates: Sequence[Any]) -> list[Any]:
    """Return the derivatives of terms and doubles along rates of the inputs.

    Parameters
    ----------
    outputs : sequence of Term or float
    inputs : sequence of Term
        What the outputs are recorded of: terms whose own operands are not looked at.
    rates : sequence of Term or float
        Of each input.

    Raises
    ------
    ArgumentError
        An operation that has no derivative everywhere.

    Examples
    --------
    >>> from pmjac_pin.algebra.terms import Recording
    >>> recording = Recording(2)
    >>> x, v = recording.inputs
    >>> [slope] = tangents([x * x * 3.0], [x], [v])
    >>> slope is (x * v + x * v) * 3.0
    True
    """
    known: dict[int, Any] = {term.index: rate for term, rate in zip(inputs, rates, strict=True)}

    def slope(of: Any) -> Any:
        return known[of.index] if isinstance(of, Term) else 0.0

    for term in sorted(_needed(outputs, known), key=lambda one: one.index):
        known[term.index] = _slope(term, slope)
    return [slope(output) for output in outputs]


def _needed(outputs: Sequence[Any], known: Collection[int]) -> set[Term]:
    """Return all terms that outputs are made of, down to those that are known."""
    found: set[Term] = set()
    waiting = [output for output in outputs if isinstance(output, Term)]
    while waiting:
        term = waiting.pop()
        if term not in found and term.index not in known:
            found.add(term)
            waiting += [one for one in term.operands if isinstance(one, Term)]
    return found


def _slope(term: Term, slope: Callable[[Any], Any]) -> Any:
    if term.operation == "input":
        return 0.0
    if term.operation not in _SLOPE_RULES:
        raise ArgumentError(f"{term.operation!r} has no derivative everywhere")
    return _SLOPE_RULES[term.operation](term, slope)


def _quotient(term: Term, slope: Callable[[Any], Any]) -> Any:
    above, below = term.operands
    return (slope(above) - term * slope(below)) / below


def _product_slope(term: Term, slope: Callable[[Any], Any]) -> Any:
    one, other = term.operands
    return slope(one) * other + one * slope(other)


def _of(term: Term, operation: Any) -> Any:
    return term.recording.term(operation, *term.operands)


_SLOPE_RULES: Mapping[str, Callable[[Term, Callable[[Any], Any]], Any]] = MappingProxyType(
    {
        "+": lambda term, slope: slope(term.operands[0]) + slope(term.operands[1]),
        "-": lambda term, slope: slope(term.operands[0]) - slope(term.operands[1]),
        "*": _product_slope,
        "/": _quotient,
        "neg": lambda term, slope: -slope(term.operands[0]),
        "sin": lambda term, slope: slope(term.operands[0]) * _of(term, "cos"),
        "cos": lambda term, slope: -(slope(term.operands[0]) * _of(term, "sin")),
        "sqrt": lambda term, slope: 0.5 * slope(term.operands[0]) / term,
    }
)
