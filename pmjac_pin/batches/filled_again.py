"""Filled again: results whose arrays a later call fills, as NumPy fills its `out`.

Arrays of results are read-only to whoever has them. What calls have returned is known here with
the memory behind them, for as long as it lives; copies of it, and what is made by hand, are not,
and neither is what is being filled: two calls at once would mix their numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeAlias
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.arrays import Array, ReadOnlyArrays

Shapes: TypeAlias = Mapping[str, tuple[int, ...]]


class Memory(NamedTuple):
    """The arrays that a result shows, and their shapes, by their names."""

    arrays: Mapping[str, NDArray[Any]]
    shapes: Shapes


_MEMORY: WeakKeyDictionary[ReadOnlyArrays, Memory] = WeakKeyDictionary()


def note_memory(result: ReadOnlyArrays, memory: Memory) -> None:
    """Note what a result shows, so that it can be filled again."""
    _MEMORY[result] = memory


def memory_of(
    out: ReadOnlyArrays,
    kind: type[ReadOnlyArrays],
    shapes: Shapes,
    given: Sequence[Array],
) -> Memory:
    """Take the arrays of a result that is to be filled again, or say why they cannot be.

    They are nobody else's until `note_memory` is told that they are filled.

    Parameters
    ----------
    out : ReadOnlyArrays
    kind : type
        What it must be.
    shapes : mapping of str to tuple of int
        Of its arrays.
    given : sequence of ndarray
        What is read while they are filled.

    Raises
    ------
    ArgumentError
    """
    if type(out) is not kind:
        raise ArgumentError(f"`out` is a {kind.__name__} to be filled again, got {quoted(out)}")
    if (memory := _MEMORY.pop(out, None)) is None:
        raise ArgumentError(
            f"`out` is a {kind.__name__} as a call has returned it; the arrays of this one, which "
            "was made by hand, copied or unpickled, or is being filled by another call, stay as "
            "they are"
        )
    try:
        _check_to_be_filled(memory, shapes, given)
    except ArgumentError:
        note_memory(out, memory)
        raise
    return memory


def _check_to_be_filled(memory: Memory, shapes: Shapes, given: Sequence[Array]) -> None:
    if memory.shapes is not shapes:
        for name, shape in shapes.items():
            if (found := memory.shapes[name]) != shape:
                raise ArgumentError(f"`out` with a {name} of shape {shape} expected, got {found}")
    arrays = memory.arrays.values()
    for one in given:
        # What owns its memory lies where nothing else does.
        if not one.flags.owndata and any(map(partial(np.may_share_memory, one), arrays)):
            raise ArgumentError(
                "`out` lies where what is given lies, which would be written over while it is "
                "read; give a copy of the one, or another `out`"
            )
