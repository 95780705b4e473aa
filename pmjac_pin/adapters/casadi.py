"""For CasADi: η, K, K* and J_eq of q as a function to differentiate, optimise over and compile."""

from __future__ import annotations

from typing import Any

import numpy as np

from pmjac_pin.adapters import importing
from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.program_text import function_name
from pmjac_pin.algebra.terms import Operand, Term
from pmjac_pin.studies.program import Program
from pmjac_pin.values.checks import check_kind

with importing("casadi"):
    import casadi

_IN_CASADI: Any = {
    "+": casadi.plus, "-": casadi.minus, "*": casadi.times, "/": casadi.rdivide,
    "neg": lambda x: -x, "sin": casadi.sin, "cos": casadi.cos, "sqrt": casadi.sqrt,
    "abs": casadi.fabs, "max": casadi.fmax, "atan2": casadi.atan2, "copysign": casadi.copysign,
    "round": lambda x: casadi.floor(x + 0.5),
}  # fmt: skip
_TAKEN = frozenset({"null", "jac", "hess"})  # CasADi's own


def function(program: Program, name: str | None = None) -> casadi.Function:
    """Return a program as a ``casadi.Function`` of q, and of its parameters where it has any.

    Its outputs have the program's names. As of the program, whether J_eq exists is for the caller
    to ask: η = 0, `sigma` > 0, and so on.
    Quaternions, and cosines with their sines, are taken as they are: of length 1.

    Parameters
    ----------
    program : Program
        Of `pmjac_pin.program`.
    name : str, optional
        Of the function; by default the mechanism's.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> from pmjac_pin.adapters import casadi
    >>> casadi.function(pj.program(pj.load("four_bar")))
    Function(four_bar:(q[3])->(eta[3],K[3],K_star[3x2],J_eq[6],sigma) SXFunction)
    """
    check_kind(program, Program)
    given = {name: casadi.SX.sym(name, count) for name, count in program.arguments.items()}
    inputs = casadi.vertcat(*given.values())
    known: list[Any] = []

    def value(operand: Operand) -> Any:
        return known[operand.index] if isinstance(operand, Term) else operand

    for index, term in enumerate(program.recording.terms):
        if term.operation == "input":  # the first of them
            known.append(inputs[index])
        else:
            known.append(_IN_CASADI[term.operation](*map(value, term.operands)))

    def matrix(numbers: Numbers) -> Any:
        found = casadi.SX(*np.atleast_2d(numbers.T).T.shape)
        for place, number in enumerate(numbers.T.ravel()):  # column by column
            found[place] = value(number)
        return casadi.densify(found)

    called = function_name(program.mechanism.name if name is None else name, _TAKEN, name is None)
    outputs = [matrix(numbers) for numbers in program.outputs.values()]
    return casadi.Function(
        called, list(given.values()), outputs, list(given), list(program.outputs)
    )
