"""Waves: a recorded program as few operations on arrays, of what does not wait for each other."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.tape import uses
from pmjac_pin.algebra.terms import Operand, Operation, Recording, Term
from pmjac_pin.values.arrays import Array, Index


@dataclass(frozen=True, eq=False)
class ArrayProgram:
    """A program over one array of numbers: constants, inputs, then what each step finds.

    Attributes
    ----------
    constants : ndarray
        The first of the numbers; after them come the inputs.
    steps : tuple of (str, tuple of ndarray of int)
        An operation, and where its operands are. What it finds comes next.
    outputs : ndarray of int
        Where they are.
    size : int
        How many numbers there are at the end.

    Examples
    --------
    >>> recording = Recording(2)
    >>> x, y = recording.inputs
    >>> waves = ArrayProgram.of(recording, [(x + 2.0) * (y + 3.0)])
    >>> [(operation, [k.tolist() for k in where]) for operation, where in waves.steps]
    [('+', [[0, 1], [2, 3]]), ('*', [[4], [5]])]
    >>> waves.constants.tolist(), waves.outputs.tolist(), waves.size
    ([2.0, 3.0], [6], 7)
    """

    constants: Array
    steps: tuple[tuple[Operation, tuple[Index, ...]], ...]
    outputs: Index
    size: int

    @classmethod
    def of(cls, recording: Recording, outputs: Sequence[Operand]) -> ArrayProgram:
        """Return the steps that compute some terms, and nothing else."""
        terms = _needed_terms(recording, outputs)
        operands = [x for term in terms for x in term.operands]
        constants = list(dict.fromkeys(x for x in [*operands, *outputs] if not isinstance(x, Term)))
        places: dict[Operand, int] = {x: k for k, x in enumerate([*constants, *recording.inputs])}
        steps = []
        for operation, alike in _in_waves(terms):
            columns = zip(*(term.operands for term in alike), strict=True)
            steps.append((operation, tuple(_numbers_of(places, column) for column in columns)))
            places |= {term: len(places) + k for k, term in enumerate(alike)}
        numbers = np.array(constants, dtype=float)
        return cls(numbers, tuple(steps), _numbers_of(places, outputs), len(places))


def _needed_terms(recording: Recording, outputs: Sequence[Operand]) -> list[Term]:
    counts = uses(recording, [x.index for x in outputs if isinstance(x, Term)])
    return [x for x in recording.terms if counts[x.index] and x.operation != "input"]


def _in_waves(terms: Sequence[Term]) -> list[tuple[Operation, list[Term]]]:
    """Return terms by their operation, after all those that they wait for."""
    waves: dict[Operand, int] = {}
    found: dict[tuple[int, Operation], list[Term]] = defaultdict(list)
    for term in terms:
        waves[term] = 1 + max(waves.get(x, 0) for x in term.operands)
        found[waves[term], term.operation].append(term)
    return [(operation, alike) for (_, operation), alike in sorted(found.items())]


def _numbers_of(places: dict[Operand, int], operands: Sequence[Operand]) -> Index:
    return np.array([places[x] for x in operands], dtype=np.intp)
