"""Filled again: results whose arrays a later call fills, as NumPy fills its `out`.

Arrays of results are read-only to whoever has them. What calls have returned is known here with
the memory behind them, for as long as it lives; copies of it, and what is made by hand, are not,
and neither is what is being filled: two calls at once would mix their numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.arrays import Array, ReadOnlyArrays

_MEMORY: WeakKeyDictionary[ReadOnlyArrays, dict[str, NDArray[Any]]] = WeakKeyDictionary()


def note_memory(result: ReadOnlyArrays, arrays: dict[str, NDArray[Any]]) -> None:
    """Note which arrays a result shows, so that they can be filled again."""
    _MEMORY[result] = arrays


def memory_of(
    out: ReadOnlyArrays,
    kind: type[ReadOnlyArrays],
    shapes: Mapping[str, tuple[int, ...]],
    given: Sequence[Array],
) -> dict[str, NDArray[Any]]:
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
    if (arrays := _MEMORY.get(out)) is None:
        raise _not_to_be_filled(kind)
    for name, shape in shapes.items():
        if (found := arrays[name].shape) != shape:
            raise ArgumentError(f"`out` with a {name} of shape {shape} expected, got {found}")
    for array in arrays.values():
        if any(np.may_share_memory(array, one) for one in given):
            raise ArgumentError(
                "`out` lies where what is given lies, which would be written over while it is "
                "read; give a copy of the one, or another `out`"
            )
    if _MEMORY.pop(out, None) is None:  # another thread was sooner
        raise _not_to_be_filled(kind)
    return arrays


def _not_to_be_filled(kind: type[ReadOnlyArrays]) -> ArgumentError:
    return ArgumentError(
        f"`out` is a {kind.__name__} as a call has returned it; the arrays of this one, which was "
        "made by hand, copied or unpickled, or is being filled by another call, stay as they are"
    )
