"""Fixed terms: what of a program is the same wherever some of its inputs move, told apart.

Then what is fixed is computed once, and what moves takes it as inputs.
"""

from __future__ import annotations

from collections.abc import Sequence

from pmjac_pin.algebra.tape import uses
from pmjac_pin.algebra.terms import Operand, Recording, Term


def apart(
    recording: Recording, moving: int, outputs: Sequence[Term | float]
) -> tuple[list[Term], Recording, list[Term | float]]:
    """Return the fixed terms that others are made of, and a recording of these with the outputs.

    Parameters
    ----------
    recording : Recording
    moving : int
        How many of its inputs move, the first ones. They are the first of the new recording, too,
        and the fixed terms come after them.
    outputs : sequence of Term or float

    Examples
    --------
    >>> recording = Recording(2)
    >>> x, a = recording.inputs
    >>> fixed, later, (found,) = apart(recording, 1, [x * (a * a)])
    >>> [term.operation for term in fixed], [term.operation for term in later.terms]
    (['*'], ['input', 'input', '*'])
    """
    later, fixed = Recording(moving), []
    moved: dict[int, Term] = dict(enumerate(later.inputs))

    def taken(x: Operand) -> Operand:
        if not isinstance(x, Term):
            return x
        if x.index not in moved:
            fixed.append(x)
            moved[x.index] = later.input()
        return moved[x.index]

    counts = uses(recording, [x.index for x in outputs if isinstance(x, Term)])
    moves = [index < moving for index in range(len(recording.terms))]
    for term in recording.terms:
        if term.operation == "input" or not counts[term.index]:
            continue
        moves[term.index] = any(isinstance(x, Term) and moves[x.index] for x in term.operands)
        if moves[term.index]:
            operands = [taken(x) for x in term.operands]
            moved[term.index] = later.term(term.operation, *operands)
    return fixed, later, [taken(x) for x in outputs]
