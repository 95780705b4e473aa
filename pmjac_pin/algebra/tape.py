"""Tape: a recorded program as instructions over numbered slots."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.terms import Operand, Recording, Term
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
    def recorded(
        cls,
        inputs: int,
        make: Callable[[Sequence[Term]], Sequence[Term | float]],
        stages: Sequence[int] = (),
    ) -> Tape:
        """Return the instructions of what is made of so many inputs, of which nobody else knows.

        Parameters
        ----------
        inputs : int
        make : callable
            Inputs ↦ outputs. Their recording is let go as soon as it is written.
        stages : sequence of int
            As of `of`.

        Examples
        --------
        >>> Tape.recorded(2, lambda inputs: [inputs[0] * inputs[1]]).outputs
        1
        """
        recording = Recording(inputs)
        tape = cls.of(recording, make(recording.inputs), stages)
        recording.forget()
        return tape

    @classmethod
    def placed(
        cls, recording: Recording, outputs: Sequence[Term | float], stages: Sequence[int] = ()
    ) -> tuple[Tape, list[tuple[int, int, int]]]:
        """Return the same, and which constant is which operand: (term, operand, slot) each."""
        writer = _Writer(recording, outputs, stages)
        return writer.tape(), writer.places()


class _Writer:
    """Writes a tape: slots are used again as soon as what they hold has been used.

    How many constants there are is known in the end. So slots count from the first behind these,
    and constants backwards from −1, until all is written.
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
        self._code: list[int] = []
        self._stores = [0] * len(outputs)  # the instruction by which each is there

    def tape(self) -> Tape:
        doubles = [(k, x) for k, x in enumerate(self._outputs) if not isinstance(x, Term)]
        slots = self._write(self._computed(), len(doubles))
        first: list[int] = []
        for place, (output, double) in enumerate(doubles):
            self._stores[output] = place
            first += self._store(output, self._constant(double))
        return Tape(
            code=read_only(self._numbered(first + self._code)),
            constants=read_only(np.array(list(self._constants), dtype=float)),
            slots=len(self._constants) + slots,
            inputs=len(self._recording.inputs),
            outputs=len(self._outputs),
            stages=tuple(1 + max(self._stores[:count], default=-1) for count in self._stages),
        )

    def _numbered(self, written: Sequence[int]) -> NDArray[np.int32]:
        """Return the instructions, constants in the first slots."""
        code = np.array(written, dtype=np.int32).reshape(-1, 5)
        slots = np.where(code < 0, ~code, code + len(self._constants))
        return np.where(_IS_SLOT[code[:, 0]], slots, code).astype(np.int32)

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
            if count and term.operation in _ADDITIVE:
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

    def _write(self, terms: Iterable[Term], before: int) -> int:
        """Write what computes terms, behind some other instructions; return how many slots."""
        code, targets, free, count = self._code, self._targets, list[int](), 0
        slot, left = [0] * len(self._uses), self._uses.copy()
        for index, numbers in targets.items():
            left[index] -= len(numbers)  # what is stored is so at once
        for term in terms:
            index, (number, operands) = term.index, self._instruction(term)
            slots, taken = list[int](), list[int]()
            for x in operands:
                if isinstance(x, Term):
                    taken.append(x.index)
                    slots.append(slot[x.index])
                    left[x.index] -= 1
                else:  # of an input its number
                    slots.append(int(x) if number == _LOAD else self._constant(x))
            for x in taken:  # a sum goes on in its own slot, the last that is freed
                if not left[x]:
                    left[x] = _FREED
                    free.append(slot[x])
            if free:
                own = free.pop()
            else:
                own = count
                count += 1
            slot[index] = own
            code += (number, own, *slots, *_NO_OPERANDS[len(slots) :])
            if index in targets:
                for output in targets[index]:
                    self._stores[output] = before + len(code) // 5
                    code += self._store(output, own)
                if not left[index]:
                    free.append(own)
        return count

    def _instruction(self, term: Term) -> tuple[int, Sequence[Operand]]:
        operation, operands = term.operation, term.operands
        if (product := self._products.get(term.index)) is None:
            return _NUMBER[operation], operands
        first, second = operands
        other = second if first is product else first
        name = "muladd" if operation == "+" else "mulsub" if first is product else "submul"
        return _NUMBER[name], (*product.operands, other)

    def _store(self, output: int, slot: int) -> tuple[int, ...]:
        return _NUMBER["store"], output, slot, 0, 0

    def _constant(self, number: float) -> int:
        return ~self._constants.setdefault(float(number), len(self._constants))


_NUMBER = {name: number for number, name in enumerate(INSTRUCTIONS)}
_NUMBER["input"] = _NUMBER["load"]
_LOAD = _NUMBER["load"]
_ADDITIVE = frozenset("+-")
_NO_OPERANDS = (0, 0, 0)  # in place of operands
_FREED = -1
_OF_ONE = frozenset({"store", "neg", "sin", "cos", "sqrt", "abs", "round"})


def _slots_read(name: str) -> int:
    """Return how many of an instruction's operands are slots."""
    if name in INSTRUCTIONS[-3:]:
        return 3
    return 0 if name == "load" else 1 if name in _OF_ONE else 2


#: Which numbers of an instruction are slots.
_IS_SLOT = np.array(
    [[False, name != "store", *(np.arange(3) < _slots_read(name))] for name in INSTRUCTIONS]
)


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
