"""Gathering: results of many poses, in new arrays or in those of a call before."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

from numpy.typing import NDArray

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
from pmjac_pin.batches.result_shapes import empty_arrays
from pmjac_pin.batches.turn import RefillTurn
from pmjac_pin.batches.wanted import Results, Wanted
from pmjac_pin.values.arrays import Array, sealed
from pmjac_pin.values.checks import check_callable

#: In which manner poses are computed: (threads, progress) of `Batch.close`.
Manner: TypeAlias = tuple[int | None, Progress | None]


#: Results; the arrays of all of them; which of these are statuses that somebody has already.
_Taken: TypeAlias = tuple[tuple[Any, ...], list[NDArray[Any]], Sequence[int]]


def gathered(
    wanted: Wanted[Results],
    work: PieceWork,
    how: Manner,
    out: Results | None = None,
    given: tuple[Array, ...] = (),
) -> Results:
    """Return results of many poses.

    Parameters
    ----------
    wanted : Wanted
    work : callable
        Fills the arrays of a piece, ``work(piece, given, *parts)``, in their order. Where the
        pieces end depends on the number of poses alone.
    how : Manner
    out : Results, optional
        To be filled again, and returned.
    given : tuple of ndarray
        What is read, row by row.

    Raises
    ------
    ArgumentError, Interrupted
    """
    result: Results
    again = None if out is None else (out,)
    (result,) = gathered_together((wanted,), work, how, again, given)
    return result


def gathered_together(
    wanted: Sequence[Wanted[Any]],
    work: PieceWork,
    how: Manner,
    out: tuple[Any, ...] | None = None,
    given: tuple[Array, ...] = (),
) -> tuple[Any, ...]:
    """Return several results of the same poses, each piece of all of them at a time."""
    asked, progress = how
    check_callable(progress, "progress")
    threads, turn, filling = thread_count(asked), RefillTurn(), None
    try:
        results, arrays, seen = (
            _new(wanted, turn) if out is None else _again(wanted, turn, out, given)
        )
        filling = filling_of(arrays, work, given, seen)
        turn.helpers = filling.helpers
        filling.fill(threads, progress)
    except BaseException as stopped:
        if filling is not None:
            _leave(filling, stopped, results)
        raise
    finally:
        turn.has_ended = True
    return results


def _new(wanted: Sequence[Wanted[Any]], turn: RefillTurn) -> _Taken:
    """Return results in new arrays, which nobody else fills until a turn is over."""
    results: list[Refillable] = []
    found: list[NDArray[Any]] = []
    for kind, shapes, more in wanted:
        arrays = empty_arrays(shapes)
        known: dict[str, Any] = {name: sealed(array) for name, array in arrays.items()}
        found += arrays.values()
        known.update(more)
        results.append(showing(kind, known, Shown(arrays, shapes, turn)))
    return tuple(results), found, ()


def _again(
    wanted: Sequence[Wanted[Any]],
    turn: RefillTurn,
    out: tuple[Any, ...],
    given: Sequence[Array],
) -> _Taken:
    """Return results of a call before, which know what new ones would.

    Raises
    ------
    ArgumentError
        Those that cannot be filled again, while what is given is read.
    """
    found: list[NDArray[Any]] = []
    seen: list[int] = []
    for one, (kind, shapes, _) in zip(out, wanted, strict=True):
        seen.append(len(found) + shapes.status)
        found += shown_by(one, kind, shapes, given, turn).arrays.values()
    for one, (_, _, more) in zip(out, wanted, strict=True):  # none of them was refused
        vars(one).update(more)
    return out, found, seen


def _leave(filling: Whole | Filling, stopped: BaseException, results: tuple[Any, ...]) -> None:
    """Say of what is not filled that it is not done; tell who interrupts what is."""
    done_poses = filling.blank()
    if isinstance(stopped, KeyboardInterrupt) and done_poses is not None:
        told = f"{done_poses} of {filling.count} poses"
        raise interrupted(told, results if len(results) > 1 else results[0]) from None
