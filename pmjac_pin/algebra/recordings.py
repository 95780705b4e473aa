"""Recordings: programs of siblings, which differ in their constants alone, written once.

What machines of other dimensions do is mostly the same operations on the same terms. Recorded once
more beside the terms that are known already, each operation is looked at and not looked for, and
the tape is known but for its constants. Where any operation differs, it is recorded afresh: so what
comes out is what recording says, whatever was recorded before.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.algebra.tape import Tape
from pmjac_pin.algebra.terms import Operand, Operation, Recording, Term
from pmjac_pin.values.arrays import Array, read_only

RecordedOutputs = Sequence[Term | float]
Make = Callable[[Sequence[Term]], RecordedOutputs]

_SIBLINGS_PATIENCE = (
    3  # times that a sibling may differ more often than not before no other is tried
)


class _Differs(Exception):
    """What is recorded once more is something else."""


class _Repeated(Recording):
    """A recording whose operations are checked, not made, when they are recorded once more.

    Attributes
    ----------
    same : bool
        Whether all were the same since then. From the first that is not, others are made: an error
        would get lost in what NumPy does with terms.
    """

    __slots__ = ("_log", "_logging", "_next", "_seen", "same")

    def __init__(self, inputs: int) -> None:
        self._log: list[Term] = []
        self._next, self._seen, self.same = 0, set[int](), False
        self._logging = False  # the inputs stay
        super().__init__(inputs)
        self._logging = True

    def again(self) -> None:
        """Record once more from here on."""
        self._next, self._seen, self.same = 0, set(), True
        self._logging = False

    def term(self, operation: Operation, *operands: Operand) -> Term:
        """Return the term of an operation, or the one that was made in its place before."""
        if self.same:
            if (known := self._in_place(operation, operands)) is not None:
                return known
            self.same = False
        found = super().term(operation, *operands)
        if self._logging:
            self._log.append(found)
        return found

    def _in_place(self, operation: Operation, operands: tuple[Operand, ...]) -> Term | None:
        """Return the next term that was made, None where it is another."""
        if self._next == len(self._log):
            return None
        known = self._log[self._next]
        self._next += 1
        before = known.operands
        if known.operation != operation or len(before) != len(operands):
            return None
        first = known.index not in self._seen
        for old, new in zip(before, operands, strict=True):
            # Doubles may be others, but for those of one term.
            of_terms = isinstance(old, Term) or isinstance(new, Term)
            if old is not new and (of_terms or not (first or old == new)):
                return None
        if first:
            self._seen.add(known.index)
            known.operands = operands
        return known


class _Known:
    """A program: its recording, its tape and where each of the tape's constants comes from."""

    def __init__(self, inputs: int, make: Make, stages: Sequence[int]) -> None:
        self._recording = _Repeated(inputs)
        self._outputs = list(make(self._recording.inputs))
        self.tape, places = Tape.placed(self._recording, self._outputs, stages)
        self._terms = [(self._recording.terms[term], operand) for term, operand, _ in places]
        self._slots: NDArray[np.intp] = np.array([slot for *_, slot in places], dtype=np.intp)
        self._shown = [
            (number, self.tape.constants.tolist().index(float(output)))
            for number, output in enumerate(self._outputs)
            if not isinstance(output, Term)
        ]

    def again(self, make: Make) -> Tape:
        """Return the tape of a sibling.

        Raises
        ------
        _Differs
        """
        self._recording.again()
        outputs = list(make(self._recording.inputs))
        if not self._recording.same or len(outputs) != len(self._outputs):
            raise _Differs
        for old, new in zip(self._outputs, outputs, strict=True):
            if old is not new and (isinstance(old, Term) or isinstance(new, Term)):
                raise _Differs
        given = [float(term.operands[operand]) for term, operand in self._terms]  # type: ignore[arg-type]
        given += [float(outputs[number]) for number, _ in self._shown]  # type: ignore[arg-type]
        slots = np.concatenate([self._slots, [slot for _, slot in self._shown]]).astype(np.intp)
        return self._with(slots, np.array(given))

    def _with(self, slots: NDArray[np.intp], given: Array) -> Tape:
        tape = self.tape
        constants = np.full(len(tape.constants), np.nan)
        constants[slots] = given
        if not np.array_equal(constants[slots], given):  # one constant that was two by chance
            raise _Differs
        return replace(tape, constants=read_only(constants))


class Recordings:
    """Programs by their names, of machines that may be siblings.

    The first program of a name is written and forgotten, since most machines have no sibling; the
    second is kept for those that follow, as long as most of them are the same.

    Examples
    --------
    >>> recordings = Recordings()
    >>> tapes = [
    ...     recordings.tape("line", 1, lambda x, k=k: [k * x[0] + 0.5]) for k in (2.0, 3.0, 4.0)
    ... ]
    >>> tapes[2].code is tapes[1].code, tapes[2].constants.tolist()
    (True, [4.0, 0.5])
    """

    def __init__(self) -> None:
        self._known: dict[str, _Known] = {}
        self._worth: dict[str, int] = {}  # how often more it paid than not
        self._lock = Lock()

    def tape(self, name: str, inputs: int, make: Make, stages: Sequence[int] = ()) -> Tape:
        """Return the tape of outputs that are made of so many inputs.

        Parameters
        ----------
        name : str
        inputs : int
        make : callable
            Inputs ↦ outputs.
        stages : sequence of int
            As of `Tape.of`.
        """
        with self._lock:
            worth = self._worth.setdefault(name, _SIBLINGS_PATIENCE)
            if worth == _SIBLINGS_PATIENCE and name not in self._known:
                self._worth[name] += 1  # a sibling may follow
            elif worth > 0:
                return self._beside(name, inputs, make, stages)
            else:
                self._known.pop(name, None)
        return Tape.recorded(inputs, make, stages)

    def _beside(self, name: str, inputs: int, make: Make, stages: Sequence[int]) -> Tape:
        if (known := self._known.get(name)) is not None:
            try:
                tape = known.again(make)
            except _Differs:
                self._worth[name] -= 1
            else:
                self._worth[name] = min(self._worth[name] + 1, 2 * _SIBLINGS_PATIENCE)
                return tape
        known = self._known[name] = _Known(inputs, make, stages)
        return known.tape
