"""Gathering: results of many poses, in new arrays or in those of a call before."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, Generic, NamedTuple, TypeVar

from pmjac_pin.batches.filled_again import Refillable, Shown, showing, shown_by
from pmjac_pin.batches.pieces import (
    Filling,
    PieceWork,
    Progress,
    Whole,
    filling_of,
    interrupted,
    thread_count,
)
from pmjac_pin.batches.result_shapes import ResultShapes, empty_arrays
from pmjac_pin.batches.turn import RefillTurn, Turns
from pmjac_pin.values.arrays import Array, sealed
from pmjac_pin.values.checks import check_callable

Results = TypeVar("Results", bound=Refillable)


class Manner(NamedTuple):
    """How many poses are computed.

    Attributes
    ----------
    threads, progress
        As of `Batch.close`.
    given : tuple of ndarray
        What is read while results are filled.
    """

    threads: int | None = None
    progress: Progress | None = None
    given: tuple[Array, ...] = ()


class Wanted(Generic[Results]):
    """Results of many poses that are wanted.

    Parameters
    ----------
    kind : type
        A dataclass of arrays, one of which is called `status`.
    shapes : mapping of str to tuple of int
        Of its arrays, by their names.
    out : Results, optional
        To be filled again.
    more : mapping of str to object
        What the results know besides their arrays.

    Attributes
    ----------
    shapes : ResultShapes
    is_seen : bool
        Whether somebody has them already.
    """

    __slots__ = ("_kind", "_more", "_out", "is_seen", "shapes")

    def __init__(
        self,
        kind: type[Results],
        shapes: ResultShapes,
        out: Results | None = None,
        more: Mapping[str, Any] = MappingProxyType({}),
    ) -> None:
        self._kind, self.shapes, self._out, self._more = kind, shapes, out, more
        self.is_seen = out is not None

    def taken(self, given: Sequence[Array], turn: RefillTurn) -> tuple[Results, Shown]:
        """Return the results and what they show, which nobody else fills until a turn is over.

        Raises
        ------
        ArgumentError
            Results that cannot be filled again, while this is read.
        """
        if self._out is None:
            arrays = empty_arrays(self.shapes)
            known = {name: sealed(array) for name, array in arrays.items()}
            known.update(self._more)
            shown = Shown(arrays, self.shapes, Turns(turn))
            return showing(self._kind, known, shown), shown
        return self._out, shown_by(self._out, self._kind, self.shapes, given, turn)

    def renew(self) -> None:
        """Let results that are filled again know what new ones would."""
        if self._out is not None:
            vars(self._out).update(self._more)


def gathered(wanted: Wanted[Results], work: PieceWork, how: Manner) -> Results:
    """Return results of many poses.

    Parameters
    ----------
    wanted : Wanted
    work : callable
        Fills the arrays of a piece, ``work(piece, *parts)``, in their order. Where the pieces end
        depends on the number of poses alone.
    how : Manner

    Raises
    ------
    ArgumentError, Interrupted
    """
    result: Results
    (result,) = gathered_together((wanted,), work, how)
    return result


def gathered_together(
    wanted: Sequence[Wanted[Any]], work: PieceWork, how: Manner
) -> tuple[Any, ...]:
    """Return several results of the same poses, each piece of all of them at a time."""
    check_callable(how.progress, "progress")
    threads, turn = thread_count(how.threads), RefillTurn()
    try:
        taken = [one.taken(how.given, turn) for one in wanted]
        for one in wanted:  # none of them was refused
            one.renew()
        results = tuple([result for result, _ in taken])
        arrays = [array for _, shown in taken for array in shown.arrays.values()]
        filling = filling_of(arrays, work, _seen(wanted))
        turn.helpers = filling.helpers
        _fill(filling, threads, how.progress, results)
    finally:
        turn.has_ended = True
    return results


def _seen(wanted: Sequence[Wanted[Any]]) -> list[int]:
    """Return the places of statuses among all arrays, of results that are filled again."""
    places, first = [], 0
    for one in wanted:
        if one.is_seen:
            places.append(first + one.shapes.status)
        first += len(one.shapes)
    return places


def _fill(
    filling: Whole | Filling, threads: int, progress: Progress | None, results: tuple[Any, ...]
) -> None:
    """Fill results; say of what is not filled that it is not done."""
    try:
        filling.fill(threads, progress)
    except BaseException as stopped:
        done_poses = filling.blank()
        if isinstance(stopped, KeyboardInterrupt) and done_poses is not None:
            told = f"{done_poses} of {filling.count} poses"
            done = results if len(results) > 1 else results[0]
            raise interrupted(told, done) from None
        raise
