"""Recorded programs as text: one statement a term, in C99 and in Python."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from typing import TypeAlias

from pmjac_pin.algebra.arrays import Numbers
from pmjac_pin.algebra.terms import Operand, Recording, Term
from pmjac_pin.errors import ArgumentError, quoted

Outputs: TypeAlias = Mapping[str, Numbers]

#: The arguments that the inputs are entries of, in their order, and how many each has.
Arguments: TypeAlias = Mapping[str, int]

#: No function in C has these names.
C_WORDS = frozenset(
    """auto break case char const continue default do double else enum extern float for goto if
    inline int long main register restrict return short signed sizeof static struct switch typedef
    union unsigned void volatile while""".split()  # noqa: SIM905 - thirty-five quotes
)
_INFIX = frozenset("+-*/")
_C_FUNCTIONS = {
    "sin": "sin", "cos": "cos", "sqrt": "sqrt", "abs": "fabs", "max": "fmax",
    "copysign": "copysign", "atan2": "atan2", "round": "rint",
}  # fmt: skip
_NUMPY_FUNCTIONS = {
    "sin": "np.sin", "cos": "np.cos", "sqrt": "np.sqrt", "abs": "np.abs", "max": "np.maximum",
    "copysign": "np.copysign", "atan2": "np.arctan2", "round": "np.rint",
}  # fmt: skip


def function_name(name: object, taken: Set[str], adapt: bool = False) -> str:
    """Return the name of a function, adapted from one that need not be one where that is asked for.

    Raises
    ------
    ArgumentError
        A name that the language does not allow.

    Examples
    --------
    >>> function_name("2nd arm", C_WORDS, adapt=True)
    'mechanism_2nd_arm'
    """
    if adapt:
        name = re.sub(r"\W", "_", str(name), flags=re.ASCII)
        name = f"mechanism_{name}" if name in taken or name[:1].isdigit() else name
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII):
        raise ArgumentError(f"a function's name is letters, digits and _, got {quoted(name)}")
    if name in taken:
        raise ArgumentError(f"{name!r} is a word of the language; give another name")
    return name


def c_text(
    name: str,
    recording: Recording,
    outputs: Outputs,
    head: Iterable[str],
    arguments: Arguments | None = None,
) -> str:
    """Return a function in C99 that writes each output row by row.

    Parameters
    ----------
    name : str
        Of the function.
    recording : Recording
        Its inputs are the entries of the function's first arguments.
    outputs : mapping of str to ndarray
        Terms and doubles, by the names of the other arguments.
    head : iterable of str
        Lines of the comment above.
    arguments : mapping of str to int, optional
        Of the inputs: ``q`` alone when None.

    Examples
    --------
    >>> import numpy as np
    >>> recording = Recording(1)
    >>> square = np.array([recording.inputs[0] * recording.inputs[0]])
    >>> print(c_text("square", recording, {"area": square}, ["The area of a square."]))
    /*
     * The area of a square.
     */
    #include <math.h>
    <BLANKLINE>
    void square(
        const double q[1],
        double area[1])
    {
        const double t0 = q[0];
        const double t1 = t0 * t0;
        area[0] = t1;
    }
    <BLANKLINE>
    """
    lines = ["/*", *(f" * {in_comment(line)}" for line in head), " */", "#include <math.h>", ""]
    return "\n".join([*lines, c_function(f"void {name}", recording, outputs, arguments)])


def c_function(
    declared: str, recording: Recording, outputs: Outputs, arguments: Arguments | None = None
) -> str:
    """Return the function alone, declared so: ``void name``, or ``static void name``."""
    given = arguments or {"q": len(recording.inputs)}
    declarations = [f"const double {key}[{count}]" for key, count in given.items()]
    declarations += [f"double {key}[{array.size}]" for key, array in outputs.items() if array.size]
    lines = [f"{declared}(", ",\n".join(f"    {one}" for one in declarations) + ")", "{"]
    statements = _statements(recording, outputs, _entries(given, "{}[{}]"), _C_FUNCTIONS)
    lines += [f"    const double {left} = {right};" for left, right in statements]
    for key, array in outputs.items():
        lines += [f"    {key}[{k}] = {_name(x)};" for k, x in enumerate(array.ravel().tolist())]
    return "\n".join([*lines, "}", ""])


def python_text(
    name: str,
    recording: Recording,
    outputs: Outputs,
    head: Iterable[str],
    numpy: str,
    *,
    arguments: Arguments | None = None,
) -> str:
    """Return a Python function of q, shape (..., nq), that gives arrays (..., *shape) by name.

    Parameters
    ----------
    name, recording, outputs, head, arguments
        As for `c_text`; of several arguments the leading axes are broadcast.
    numpy : str
        The module that is NumPy here: ``numpy`` or ``jax.numpy``.
    """
    given = arguments or {"q": len(recording.inputs)}
    shown = "\n".join(map(_in_docstring, head))
    lines = [f'"""{shown}\n"""', "", f"import {numpy} as np", "", ""]
    lines += [f"def {name}({', '.join(given)}):"]
    if len(given) > 1:
        shapes = ", ".join(f"{key}.shape[:-1]" for key in given)
        lines += [f"    shape = np.broadcast_shapes({shapes})"]
        lines += [f"    {key} = np.broadcast_to({key}, (*shape, {n}))" for key, n in given.items()]
    lines += ["    nothing = np.zeros(q.shape[:-1])"]
    statements = _statements(recording, outputs, _entries(given, "{}[..., {}]"), _NUMPY_FUNCTIONS)
    lines += [f"    {left} = {right}" for left, right in statements]
    lines += ["    return {"]
    lines += [f'        "{key}": {_stacked(array)},' for key, array in outputs.items()]
    return "\n".join([*lines, "    }", ""])


def _stacked(array: Numbers) -> str:
    """Return an array of each pose, in Python."""
    shape = "".join(f", {size}" for size in array.shape)
    if not array.size:  # of nothing there is no stack
        return f"np.zeros((*q.shape[:-1]{shape}))"
    entries = "".join(f"            {_whole(x)},\n" for x in array.ravel().tolist())
    return f"np.stack([\n{entries}        ], -1).reshape(*q.shape[:-1]{shape})"


def _entries(arguments: Arguments, entry: str) -> list[str]:
    """Return what the inputs are called."""
    return [entry.format(key, k) for key, count in arguments.items() for k in range(count)]


def _statements(
    recording: Recording, outputs: Outputs, entries: Sequence[str], functions: Mapping[str, str]
) -> Iterator[tuple[str, str]]:
    """Yield names and expressions of the terms that the outputs rest on."""
    needed = {x.index for array in outputs.values() for x in array.ravel() if isinstance(x, Term)}
    for term in reversed(recording.terms):
        if term.index in needed and term.operation != "input":
            needed.update(x.index for x in term.operands if isinstance(x, Term))
    for term in recording.terms:
        if term.index in needed:
            yield _name(term), _expression(term, entries, functions)


def _expression(term: Term, entries: Sequence[str], functions: Mapping[str, str]) -> str:
    operation, operands = term.operation, term.operands
    if operation == "input":
        return entries[int(operands[0])]  # type: ignore[arg-type]
    known: Sequence[str] = [_name(x) for x in operands]
    if operation == "neg":
        return f"-{known[0]}"
    if operation in _INFIX:
        return f" {operation} ".join(known)
    return f"{functions[operation]}({', '.join(known)})"


def _name(operand: Operand) -> str:
    if isinstance(operand, Term):
        return f"t{operand.index}"
    text = repr(operand + 0.0)  # of -0.0, too
    return f"({text})" if operand < 0.0 else text


def _whole(operand: Operand) -> str:
    """Return a number of each pose."""
    return _name(operand) if isinstance(operand, Term) else f"nothing + {_name(operand)}"


def in_comment(line: str) -> str:
    """Return a line that ends no comment in C."""
    return _comment_text(line).replace("*/", "* /").replace("/*", "/ *")


def _in_docstring(line: str) -> str:
    return _comment_text(line).replace('"', "'")


def _comment_text(line: str) -> str:
    return line.encode("unicode_escape").decode()
