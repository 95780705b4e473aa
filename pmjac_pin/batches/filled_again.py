"""Filled again: results whose arrays a later call fills, as NumPy fills its `out`.

Arrays of results are read-only to whoever has them. What calls have returned knows the memory
behind them; copies of it, and what is made by hand, do not, and what is being filled is left alone:
two calls at once would mix their numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from operator import is_
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.batches.result_shapes import ResultShapes
from pmjac_pin.batches.turn import RefillTurn, Turns
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.values.arrays import Array, ReadOnlyArrays


class Shown(Turns):
    """Turns to fill the arrays that a result shows, the first of them the call's that makes it.

    Attributes
    ----------
    arrays : mapping of str to ndarray
        By their names.
    shapes : ResultShapes
        Of them.
    """

    __slots__ = ("arrays", "shapes")

    def __init__(
        self, arrays: Mapping[str, NDArray[Any]], shapes: ResultShapes, first: RefillTurn
    ) -> None:
        super().__init__(first)
        self.arrays, self.shapes = arrays, shapes


@dataclass(frozen=True, eq=False)
class Refillable(ReadOnlyArrays):
    """Base of results that can be filled again where a call has made them."""

    __slots__ = ("_shown",)

    def __getstate__(self) -> dict[str, Any]:
        """Return what copies and pickles know: not the memory behind the arrays."""
        return self.__dict__


Result = TypeVar("Result", bound=Refillable)


def showing(kind: type[Result], known: dict[str, Any], shown: Shown) -> Result:
    """Return what shows arrays, by others that nobody can write to, and can be filled again."""
    result = kind.of_sealed(known)
    object.__setattr__(result, "_shown", shown)
    return result


def shown_by(
    out: Refillable,
    kind: type[Refillable],
    shapes: ResultShapes,
    given: Sequence[Array],
    turn: RefillTurn,
) -> Shown:
    """Take the arrays of a result that is to be filled again, or say why they cannot be.

    They are this call's until its turn is over.

    Parameters
    ----------
    out : Refillable
    kind : type
        What it must be.
    shapes : mapping of str to tuple of int
        Of its arrays.
    given : sequence of ndarray
        What is read while they are filled.
    turn : RefillTurn
        The call's that fills them.

    Raises
    ------
    ArgumentError
    """
    if type(out) is not kind:
        raise ArgumentError(f"`out` is a {kind.__name__} to be filled again, got {quoted(out)}")
    shown: Shown | None = getattr(out, "_shown", None)
    if shown is not None:
        _check_to_be_filled(shown, shapes, given)
    if shown is None or not shown.go_on_with(turn, kind):
        raise ArgumentError(
            f"`out` is a {kind.__name__} as a call has returned it; the arrays of this one, which "
            "was made by hand, copied or unpickled, or is being filled by another call, stay as "
            "they are"
        )
    return shown


def _check_to_be_filled(shown: Shown, shapes: ResultShapes, given: Sequence[Array]) -> None:
    if shown.shapes is not shapes:
        for name, shape in shapes.items():
            if (found := shown.shapes[name]) != shape:
                raise ArgumentError(f"`out` with a {name} of shape {shape} expected, got {found}")
    arrays = shown.arrays.values()
    for one in given:
        # What owns its memory lies where nothing else does.
        lies = is_ if one.flags.owndata else np.may_share_memory
        if any(map(partial(lies, one), arrays)):
            raise ArgumentError(
                "`out` lies where what is given lies, which would be written over while it is "
                "read; give a copy of the one, or another `out`"
            )
