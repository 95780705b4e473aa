"""Runs a tape with NumPy: each instruction over a few thousand sets of inputs at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from pmjac_pin.algebra.tape import INSTRUCTIONS, Array, Tape

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
    >>> from pmjac_pin.algebra.programs import Recording
    >>> recording = Recording(2)
    >>> x, y = recording.inputs
    >>> tape = Tape.of(recording, [x * y + 1.0, 5.0])
    >>> run(tape, np.array([[1.0, 2.0], [3.0, 4.0]])).tolist()
    [[4.0, 9.0], [5.0, 5.0]]
    """
    count = inputs.shape[1]
    found, width = np.empty((tape.outputs, count)), min(count, _CHUNK)
    store = np.empty((tape.slots - len(tape.constants) + 1, width))
    steps = [(_STEPS[INSTRUCTIONS[code]], *places) for code, *places in tape.code.tolist()]
    with np.errstate(all="ignore"):
        for start in range(0, count, width or 1):
            end = min(start + width, count)
            spare, *slots = store[:, : end - start]
            slots = [*tape.constants, *slots]
            part, target = inputs[:, start:end], found[:, start:end]
            for step, *places in steps:
                step(slots, spare, part, target, *places)
    return found


_Step = Callable[..., None]


def _one(of: Any) -> _Step:
    return lambda slots, spare, inputs, outputs, d, a, b, c: of(slots[a], out=slots[d])


def _two(of: Any) -> _Step:
    return lambda slots, spare, inputs, outputs, d, a, b, c: of(slots[a], slots[b], out=slots[d])


def _fused(turned: bool, of: Any) -> _Step:
    def step(
        slots: Any, spare: Any, inputs: Any, outputs: Any, d: int, a: int, b: int, c: int
    ) -> None:
        np.multiply(slots[a], slots[b], out=spare)
        first, second = (slots[c], spare) if turned else (spare, slots[c])
        of(first, second, out=slots[d])

    return step


def _load(
    slots: Any, spare: Any, inputs: Any, outputs: Any, d: int, a: int, b: int, c: int
) -> None:
    slots[d][:] = inputs[a]


def _store(
    slots: Any, spare: Any, inputs: Any, outputs: Any, d: int, a: int, b: int, c: int
) -> None:
    outputs[d] = slots[a]


_STEPS: dict[str, _Step] = {
    **{name: _one(of) for name, of in _ONE.items()},
    **{name: _two(of) for name, of in _TWO.items()},
    "muladd": _fused(False, np.add),
    "mulsub": _fused(False, np.subtract),
    "submul": _fused(True, np.subtract),
    "load": _load,
    "store": _store,
}
