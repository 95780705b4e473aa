"""Runs a tape with NumPy: each instruction over a few thousand sets of inputs at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from pmjac_pin.algebra.tape import INSTRUCTIONS, Tape
from pmjac_pin.values.arrays import Array

_CHUNK = 2048  # sets of inputs at a time: what the slots hold stays in the processor's cache

_ONE = {
    "neg": np.negative, "sin": np.sin, "cos": np.cos, "sqrt": np.sqrt, "abs": np.abs,
    "round": np.rint,
}  # fmt: skip
_TWO = {
    "+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide, "max": np.maximum,
    "copysign": np.copysign, "atan2": np.arctan2,
}  # fmt: skip


def run(tape: Tape, inputs: Array) -> Array:
    """Return the outputs, shape (outputs, N), of inputs of shape (inputs, N).

    Examples
    --------
    >>> from pmjac_pin.algebra.terms import Recording
    >>> recording = Recording(2)
    >>> x, y = recording.inputs
    >>> tape = Tape.of(recording, [x * y + 1.0, 5.0])
    >>> run(tape, np.array([[1.0, 2.0], [3.0, 4.0]])).tolist()
    [[4.0, 9.0], [5.0, 5.0]]
    """
    count = inputs.shape[1]
    found, width = np.empty((tape.outputs, count)), min(count, _CHUNK)
    store = np.empty((tape.slots - len(tape.constants) + 1, width))
    steps = [(_OPERATIONS[INSTRUCTIONS[code]], *places) for code, *places in tape.code.tolist()]
    with np.errstate(all="ignore"):
        for start in range(0, count, width or 1):
            part = slice(start, min(start + width, count))
            spare, *slots = store[:, : part.stop - start]
            chunk = _Chunk([*tape.constants, *slots], spare, inputs[:, part], found[:, part])
            for step, target, a, b, c in steps:
                step(chunk, target, a, b, c)
    return found


class _Chunk(NamedTuple):
    """What instructions work on: constants and arrays in slots, and one array to spare."""

    slots: list[Any]
    spare: Array
    inputs: Array
    outputs: Array


_Instruction = Callable[[_Chunk, int, int, int, int], None]


def _unary(of: Any) -> _Instruction:
    def step(chunk: _Chunk, target: int, a: int, b: int, c: int) -> None:
        of(chunk.slots[a], out=chunk.slots[target])

    return step


def _two(of: Any) -> _Instruction:
    def step(chunk: _Chunk, target: int, a: int, b: int, c: int) -> None:
        of(chunk.slots[a], chunk.slots[b], out=chunk.slots[target])

    return step


def _muladd(chunk: _Chunk, target: int, a: int, b: int, c: int) -> None:
    np.multiply(chunk.slots[a], chunk.slots[b], out=chunk.spare)
    np.add(chunk.spare, chunk.slots[c], out=chunk.slots[target])


def _mulsub(chunk: _Chunk, target: int, a: int, b: int, c: int) -> None:
    np.multiply(chunk.slots[a], chunk.slots[b], out=chunk.spare)
    np.subtract(chunk.spare, chunk.slots[c], out=chunk.slots[target])


def _submul(chunk: _Chunk, target: int, a: int, b: int, c: int) -> None:
    np.multiply(chunk.slots[a], chunk.slots[b], out=chunk.spare)
    np.subtract(chunk.slots[c], chunk.spare, out=chunk.slots[target])


def _load(chunk: _Chunk, target: int, a: int, b: int, c: int) -> None:
    chunk.slots[target][:] = chunk.inputs[a]


def _store(chunk: _Chunk, target: int, a: int, b: int, c: int) -> None:
    chunk.outputs[target] = chunk.slots[a]


_OPERATIONS: dict[str, _Instruction] = {
    **{name: _unary(of) for name, of in _ONE.items()},
    **{name: _two(of) for name, of in _TWO.items()},
    "muladd": _muladd,
    "mulsub": _mulsub,
    "submul": _submul,
    "load": _load,
    "store": _store,
}
