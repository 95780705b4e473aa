"""Tape: a recorded program as instructions over numbered slots."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import repeat
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.programs import Operand, Recording, Term
from pmjac_pin.values.arrays import Array, read_only

#: What instructions do; the last three are a·b + c, a·b − c and c − a·b.
INSTRUCTIONS = (
    "load", "store", "+", "-", "*", "/", "neg", "sin", "cos", "sqrt", "abs", "max", "copysign",
    "atan2", "round", "muladd", "mulsub", "submul",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Tape:
    """A program that can be run.

    Attributes
    ----------
    code : ndarray of int32, shape (instructions, 5)
        Which of `INSTRUCTIONS`, the target, and up to three operands. All are slots, but for the
        input that is loaded and the output that is stored to.
    constants : ndarray
        What the first slots hold from the beginning.
    slots, inputs, outputs : int
        How many.
    stages : tuple of int
        How many instructions it takes until the outputs of each stage are there, too.

    Examples
    --------
    >>> recording = Recording(2)
    >>> x, y = recording.inputs
    >>> tape = Tape.of(recording, [x * y + 1.0])
    >>> [INSTRUCTIONS[code] for code in tape.code[:, 0]]
    ['load', 'load', 'muladd', 'store']
    """

    code: NDArray[np.int32]
    constants: Array
    slots: int
    inputs: int
    outputs: int
    stages: tuple[int, ...] = ()

    @classmethod
    def of(
        cls, recording: Recording, outputs: Sequence[Term | float], stages: Sequence[int] = ()
    ) -> Tape:
        """Return the instructions that compute some terms, and nothing else.

        Parameters
        ----------
        recording : Recording
        outputs : sequence of Term or float
        stages : sequence of int
            How many of the outputs are to be there as early as can be, ascending.
        """
        return _Writer(recording, outputs, stages).tape()

    @classmethod
    def placed(
        cls, recording: Recording, outputs: Sequence[Term | float], stages: Sequence[int] = ()
    ) -> tuple[Tape, list[tuple[int, int, int]]]:
        """Return the same, and which constant is which operand: (term, operand, slot) each."""
        writer = _Writer(recording, outputs, stages)
        return writer.tape(), writer.places()


class _Writer:
    """Writes a tape: slots are used again as soon as what they hold has been used.

    What instructions take has numbers: terms their index, constants those behind them.
    """

    def __init__(
        self, recording: Recording, outputs: Sequence[Term | float], stages: Sequence[int]
    ) -> None:
        self._recording, self._outputs, self._stages = recording, outputs, stages
        self._targets: dict[int, list[int]] = {}
        for number, output in enumerate(outputs):
            if isinstance(output, Term):
                self._targets.setdefault(output.index, []).append(number)
        self._uses = uses(recording, [x.index for x in outputs if isinstance(x, Term)])
        self._products = self._fused()
        self._constants: dict[float, int] = {}
        self._stores = [0] * len(outputs)  # the instruction by which each is there
        self._code: list[int] = []

    def tape(self) -> Tape:
        steps = [self._step(term) for term in self._computed()]
        shown = [
            (number, self._constant(output))
            for number, output in enumerate(self._outputs)
            if not isinstance(output, Term)
        ]
        for number, slot in shown:
            self._store(number, slot)
        slots = self._write(steps)
        return Tape(
            code=read_only(np.array(self._code, dtype=np.int32).reshape(-1, 5)),
            constants=read_only(np.array(list(self._constants), dtype=float)),
            slots=slots,
            inputs=len(self._recording.inputs),
            outputs=len(self._outputs),
            stages=tuple(1 + max(self._stores[:count], default=-1) for count in self._stages),
        )

    def places(self) -> list[tuple[int, int, int]]:
        """Return which operands of the terms that are computed the constants are."""
        return [
            (term.index, number, self._constants[float(x)])
            for term in self._recording.terms
            if self._uses[term.index] and term.operation != "input"
            for number, x in enumerate(term.operands)
            if not isinstance(x, Term)
        ]

    def _fused(self) -> dict[int, Term]:
        """Return of sums the product that is computed with them, and used by nothing else."""
        counts, found = self._uses, dict[int, Term]()
        for term, count in zip(self._recording.terms, counts, strict=True):
            if count and term.operation in _SUMS:
                for x in term.operands:
                    if isinstance(x, Term) and x.operation == "*" and counts[x.index] == 1:
                        found[term.index] = x
                        break
        return found

    def _computed(self) -> list[Term]:
        """Return the terms that have an instruction of their own, in its order."""
        hidden = {product.index for product in self._products.values()}
        terms = [
            term
            for term, count in zip(self._recording.terms, self._uses, strict=True)
            if count and term.index not in hidden
        ]
        if self._stages:
            stages = self._stage_of_terms()
            terms.sort(key=lambda term: stages[term.index])
        return terms

    def _stage_of_terms(self) -> list[int]:
        """Return at which stage each term is needed first."""
        found = [len(self._stages)] * len(self._recording.terms)
        for index, numbers in self._targets.items():
            found[index] = bisect_right(self._stages, min(numbers))
        for term in reversed(self._recording.terms):
            if self._uses[term.index]:
                stage = found[term.index]
                for x in term.operands:
                    if isinstance(x, Term) and found[x.index] > stage:
                        found[x.index] = stage
        return found

    def _step(self, term: Term) -> _Step:
        """Return an instruction, the term that it computes, and what it takes."""
        name: str = term.operation
        operands = term.operands
        if name == "input":
            return _LOAD, term.index, [int(operands[0])]  # type: ignore[arg-type]
        if (product := self._products.get(term.index)) is not None:
            first, second = operands
            other = second if first is product else first
            name = "muladd" if name == "+" else "mulsub" if first is product else "submul"
            operands = (*product.operands, other)
        count = len(self._uses)
        taken = [x.index if isinstance(x, Term) else count + self._constant(x) for x in operands]
        return _NUMBER[name], term.index, taken

    def _write(self, steps: Iterable[_Step]) -> int:
        """Write the steps; return how many slots they take, those of constants among them."""
        code, targets, free, count = self._code, self._targets, list[int](), len(self._constants)
        slot = [*repeat(0, len(self._uses)), *range(count)]
        left = [*self._uses, *repeat(math.inf, count)]
        for index, numbers in targets.items():
            left[index] -= len(numbers)  # what is stored is so at once
        for number, term, sources in steps:
            slots = sources
            if number != _LOAD:
                slots = [slot[x] for x in sources]
                for x in sources:
                    left[x] -= 1
                for x in sources:  # a sum goes on in its own slot, the last that is freed
                    if not left[x]:
                        left[x] = _FREED
                        free.append(slot[x])
            if free:
                own = free.pop()
            else:
                own = count
                count += 1
            slot[term] = own
            code += (number, own, *slots, *_NOTHING[len(slots) :])
            if term in targets:
                for output in targets[term]:
                    self._store(output, own)
                if not left[term]:
                    free.append(own)
        return count

    def _store(self, output: int, slot: int) -> None:
        self._stores[output] = len(self._code) // _WIDTH
        self._code += (_STORE, output, slot, 0, 0)

    def _constant(self, number: float) -> int:
        """Return the slot of a constant."""
        return self._constants.setdefault(float(number), len(self._constants))


_NUMBER = {name: number for number, name in enumerate(INSTRUCTIONS)}
_LOAD, _STORE = _NUMBER["load"], _NUMBER["store"]
_SUMS = frozenset("+-")
_WIDTH = 5  # of an instruction
_NOTHING = (0, 0, 0)  # in place of operands
_FREED = -1

#: An instruction, the term that it computes, and what it takes.
_Step: TypeAlias = tuple[int, int, Sequence[int]]


def uses(recording: Recording, targets: Iterable[int]) -> list[int]:
    """Return how often each term that the targets rest on is used, those by their index."""
    counts = [0] * len(recording.terms)
    for index in targets:
        counts[index] += 1
    for term in reversed(recording.terms):
        if counts[term.index]:
            for x in term.operands:  # that of an input is no term
                if isinstance(x, Term):
                    counts[x.index] += 1
    return counts
