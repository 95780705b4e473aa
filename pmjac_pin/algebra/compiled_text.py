"""A tape as text in C, after `compiled.h`, for vectors of the processor that it is compiled on."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pmjac_pin.algebra.tape import INSTRUCTIONS, Tape

HEAD = Path(__file__).with_name("compiled.h")
_LINES = 500  # in one function: twice as many take more than twice as long to compile

_TEXT = {
    "+": "{} + {}", "-": "{} - {}", "*": "{} * {}", "/": "{} / {}", "neg": "-{}",
    "sin": "wave({}, 0)", "cos": "wave({}, 1)", "sqrt": "root({})", "abs": "magnitude({})",
    "max": "largest({}, {})", "copysign": "with_sign({}, {})", "atan2": "arctangent({}, {})",
    "round": "whole({})", "muladd": "{} * {} + {}", "mulsub": "{} * {} - {}",
    "submul": "{2} - {0} * {1}",
}  # fmt: skip
_OPERANDS = {name: text.count("{") for name, text in _TEXT.items()}


def compiled_text(tape: Tape) -> str:
    """Return a file in C that computes what a tape does, to the last bit.

    Examples
    --------
    >>> from pmjac_pin.algebra.terms import Recording
    >>> recording = Recording(2)
    >>> x, y = recording.inputs
    >>> text = compiled_text(Tape.of(recording, [x * y + 1.0]))
    >>> "v2 = v0 * v1 + all(0x1.0000000000000p+0);" in text
    True
    """
    return "".join([HEAD.read_text(encoding="utf-8"), *_Text(tape).lines()])


class _Text:
    """The functions of one program; each value is a variable, and kept for functions after it."""

    def __init__(self, tape: Tape) -> None:
        self._tape = tape
        stages = tape.stages or (len(tape.code),)
        starts = [0, *stages[:-1]]
        self._stages = [
            [range(at, min(at + _LINES, end)) for at in range(start, end, _LINES)]
            for start, end in zip(starts, stages, strict=True)
        ]
        self._functions = [part for stage in self._stages for part in stage]
        self._operands: list[list[int]] = []  # those of each instruction: who made them, or −1 − k
        self._last: dict[int, int] = {}  # in which function each value is used last
        self._follow()
        self._place: dict[int, int] = {}

    def lines(self) -> Iterator[str]:
        """Yield the text."""
        kept = self._keep()
        for number, part in enumerate(self._functions):
            yield f"\nAPART part_{number}(Rows rows, Many *kept)\n{{\n    (void)rows, (void)kept;\n"
            yield from (f"    {line}\n" for line in self._part(number, part))
            yield "}\n"
        yield f"\nint64_t pmjac_kept(void) {{ return {kept}; }}\n"
        yield "\nstatic void run_stage(int64_t stage, Rows rows, Many *kept)\n{\n"
        number = 0
        for stage, parts in enumerate(self._stages):
            calls = "".join(f" part_{number + k}(rows, kept);" for k in range(len(parts)))
            number += len(parts)
            yield f"    if (stage == {stage}) {{{calls} }}\n"
        yield "}\n"

    def _follow(self) -> None:
        """Find who made the operands of each instruction."""
        made = {slot: -1 - slot for slot in range(len(self._tape.constants))}
        lengths = [len(part) for part in self._functions]
        part_of = np.repeat(np.arange(len(lengths)), lengths)
        code = self._tape.code.tolist()
        for index, (instruction, target, *places) in enumerate(code):
            name = INSTRUCTIONS[instruction]
            count = 1 if name == "store" else _OPERANDS.get(name, 0)
            operands = [made[place] for place in places[:count]]
            self._operands.append(operands)
            for operand in operands:
                self._last[operand] = int(part_of[index])
            if name != "store":
                made[target] = index

    def _keep(self) -> int:
        """Give places to values that functions after their own use; return how many there are."""
        count, free, held = 0, list[int](), list[int]()
        for number, part in enumerate(self._functions):
            for index in part:
                if self._last.get(index, -1) > number:
                    if not free:
                        free, count = [count], count + 1
                    self._place[index] = free.pop()
                    held.append(index)
            free += [self._place[index] for index in held if self._last[index] == number]
            held = [index for index in held if self._last[index] > number]
        return count

    def _part(self, number: int, part: range) -> Iterator[str]:
        known: set[int] = set()
        for index in part:
            instruction, target, entry, *_ = self._tape.code[index].tolist()
            name = INSTRUCTIONS[instruction]
            for operand in self._operands[index]:
                if 0 <= operand < part.start and operand not in known:
                    known.add(operand)
                    yield f"const Many v{operand} = kept[{self._place[operand]}];"
            operands = map(self._name, self._operands[index])
            if name == "store":
                yield f"store(rows.outputs + {target} * rows.to, {next(operands)});"
                continue
            if name == "load":
                value = f"load(rows.inputs + {entry} * rows.from)"
            else:
                value = _TEXT[name].format(*operands)
            yield f"const Many v{index} = {value};"
            if self._last.get(index, -1) > number:
                yield f"kept[{self._place[index]}] = v{index};"

    def _name(self, operand: int) -> str:
        if operand >= 0:
            return f"v{operand}"
        number = float(self._tape.constants[-1 - operand])
        if math.isfinite(number):
            return f"all({number.hex()})"
        return "all(NAN)" if math.isnan(number) else f"all({math.copysign(1.0, number)} * INFINITY)"
