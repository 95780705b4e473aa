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


class Shown(NamedTuple):
    """The arrays that a result shows, and their shapes, by their names.

    While a call fills them it is the one value in `filled_by`.
    """

    arrays: Mapping[str, NDArray[Any]]
    shapes: Shapes
    filled_by: dict[None, object]


_SHOWN: WeakKeyDictionary[ReadOnlyArrays, Shown] = WeakKeyDictionary()


def note_shown(result: ReadOnlyArrays, shown: Shown) -> None:
    """Note what a result shows, so that it can be filled again."""
    _SHOWN[result] = shown


def let_go(out: ReadOnlyArrays, call: object) -> None:
    """Leave to others what a call has filled, if it was this one."""
    shown = _SHOWN.get(out)
    if shown is not None and shown.filled_by.get(None) is call:
        shown.filled_by.clear()


def shown_by(
    out: ReadOnlyArrays,
    kind: type[ReadOnlyArrays],
    shapes: Shapes,
    given: Sequence[Array],
    call: object,
) -> Shown:
    """Take the arrays of a result that is to be filled again, or say why they cannot be.

    They are this call's until `let_go` is told so.

    Parameters
    ----------
    out : ReadOnlyArrays
    kind : type
        What it must be.
    shapes : mapping of str to tuple of int
        Of its arrays.
    given : sequence of ndarray
        What is read while they are filled.
    call : object
        Who fills them.

    Raises
    ------
    ArgumentError
    """
    if type(out) is not kind:
        raise ArgumentError(f"`out` is a {kind.__name__} to be filled again, got {quoted(out)}")
    shown = _SHOWN.get(out)
    if shown is not None:
        _check_to_be_filled(shown, shapes, given)
    # One step, which no other thread divides: whoever is first has them.
    if shown is None or shown.filled_by.setdefault(None, call) is not call:
        raise ArgumentError(
            f"`out` is a {kind.__name__} as a call has returned it; the arrays of this one, which "
            "was made by hand, copied or unpickled, or is being filled by another call, stay as "
            "they are"
        )
    return shown


def _check_to_be_filled(shown: Shown, shapes: Shapes, given: Sequence[Array]) -> None:
    if shown.shapes is not shapes:
        for name, shape in shapes.items():
            if (found := shown.shapes[name]) != shape:
                raise ArgumentError(f"`out` with a {name} of shape {shape} expected, got {found}")
    arrays = shown.arrays.values()
    for one in given:
        # What owns its memory lies where nothing else does.
        owns = one.flags.owndata and all(one is not array for array in arrays)
        if not owns and any(map(partial(np.may_share_memory, one), arrays)):
            raise ArgumentError(
                "`out` lies where what is given lies, which would be written over while it is "
                "read; give a copy of the one, or another `out`"
            )
