"""Tape: a recorded program as instructions over numbered slots."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

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
    """Writes a tape: slots are used again as soon as what they hold has been used."""

    def __init__(
        self, recording: Recording, outputs: Sequence[Term | float], stages: Sequence[int]
    ) -> None:
        self._recording, self._outputs, self._stages = recording, outputs, stages
        self._targets: dict[int, list[int]] = {}
        for number, output in enumerate(outputs):
            if isinstance(output, Term):
                self._targets.setdefault(output.index, []).append(number)
        self._uses = uses(recording, [x.index for x in outputs if isinstance(x, Term)])
        self._factor = dict(self._fused())
        self._left = [0] * len(recording.terms)
        self._constants: dict[float, int] = {}
        self._slot: dict[int, int] = {}
        self._free: list[int] = []
        self._count = 0
        self._code: list[tuple[int, ...]] = []

    def tape(self) -> Tape:
        hidden = {term.index for term in self._factor.values()}
        steps = [
            (term, *self._instruction(term))
            for term in self._recording.terms
            if self._uses[term.index] and term.index not in hidden
        ]
        if self._stages:
            stages = self._stage_of_terms()
            steps.sort(key=lambda step: stages[step[0].index])
        for _, _, operands in steps:
            for x in operands:
                if isinstance(x, Term):
                    self._left[x.index] += 1
                else:
                    self._know(x)
        for output in self._outputs:
            if not isinstance(output, Term):
                self._know(output)
        self._count = len(self._constants)
        for number, output in enumerate(self._outputs):
            if not isinstance(output, Term):
                self._write("store", number, self._constants[float(output)])
        for term, name, operands in steps:
            self._compute(term, name, operands)
        return Tape(
            code=read_only(np.array(self._code, dtype=np.int32).reshape(-1, 5)),
            constants=read_only(np.array(list(self._constants), dtype=float)),
            slots=self._count,
            inputs=len(self._recording.inputs),
            outputs=len(self._outputs),
            stages=tuple(map(self._until, self._stages)),
        )

    def _stage_of_terms(self) -> list[int]:
        """Return at which stage each term is needed first."""
        found = [len(self._stages)] * len(self._recording.terms)
        for index, numbers in self._targets.items():
            found[index] = bisect_right(self._stages, min(numbers))
        for term in reversed(self._recording.terms):
            if self._uses[term.index] and term.operation != "input":
                for x in term.operands:
                    if isinstance(x, Term):
                        found[x.index] = min(found[x.index], found[term.index])
        return found

    def _until(self, outputs: int) -> int:
        """Return how many instructions it takes until so many outputs are there."""
        stores = (
            place
            for place, (name, target, *_) in enumerate(self._code)
            if name == _NUMBER["store"] and target < outputs
        )
        return max(stores, default=-1) + 1

    def places(self) -> list[tuple[int, int, int]]:
        """Return which operands of the terms that are computed the constants are."""
        return [
            (term.index, number, self._constants[float(x)])
            for term in self._recording.terms
            if self._uses[term.index] and term.operation != "input"
            for number, x in enumerate(term.operands)
            if not isinstance(x, Term)
        ]

    def _fused(self) -> Iterator[tuple[int, Term]]:
        """Return sums by the product that is computed with them, and used by nothing else."""
        taken: set[int] = set()
        for term in self._recording.terms:
            if term.operation not in {"+", "-"} or not self._uses[term.index]:
                continue
            for x in term.operands:
                if isinstance(x, Term) and self._serves_once(x) and x.index not in taken:
                    taken.add(x.index)
                    yield term.index, x
                    break

    def _serves_once(self, term: Term) -> bool:
        return term.operation == "*" and self._uses[term.index] == 1

    def _instruction(self, term: Term) -> tuple[str, Sequence[Operand]]:
        if term.operation == "input":
            return "load", ()
        if (product := self._factor.get(term.index)) is None:
            return term.operation, term.operands
        first, second = term.operands
        other = second if first is product else first
        name = "muladd" if term.operation == "+" else "mulsub" if first is product else "submul"
        return name, (*product.operands, other)

    def _compute(self, term: Term, name: str, operands: Sequence[Operand]) -> None:
        slot, left, free, sources = self._slot, self._left, self._free, []
        used: dict[int, None] = {}  # a sum goes on in its own slot, the last that is freed
        for x in operands:
            if isinstance(x, Term):
                sources.append(slot[x.index])
                left[x.index] -= 1
                used[x.index] = None
            else:
                sources.append(self._constants[float(x)])
        free += [slot[index] for index in used if not left[index]]
        if name == "load":
            sources = [int(term.operands[0])]  # type: ignore[arg-type]
        own = slot[term.index] = free.pop() if free else self._count
        self._count = max(self._count, own + 1)
        self._write(name, own, *sources)
        for number in self._targets.get(term.index, ()):
            self._write("store", number, own)
        if not left[term.index]:
            free.append(own)

    def _know(self, number: float) -> None:
        self._constants.setdefault(float(number), len(self._constants))

    def _write(self, name: str, target: int, *sources: int) -> None:
        self._code.append((_NUMBER[name], target, *(*sources, 0, 0, 0)[:3]))


_NUMBER = {name: number for number, name in enumerate(INSTRUCTIONS)}


def uses(recording: Recording, targets: Iterable[int]) -> list[int]:
    """Return how often each term that the targets rest on is used, those by their index."""
    counts = [0] * len(recording.terms)
    for index in targets:
        counts[index] += 1
    for term in reversed(recording.terms):
        if counts[term.index] and term.operation != "input":
            for x in term.operands:
                if isinstance(x, Term):
                    counts[x.index] += 1
    return counts
