"""A grid of motor values walked from cell to neighbouring cell, as a map wants it.

Each pose starts from a closed one beside it: paths are short, and one assembly mode is kept. Cells
are walked to in waves. A cell that a path from one neighbour does not reach is tried from the
others as these are closed, once each.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from pmjac_pin.batches.results import ManyClosed, Status, Statuses
from pmjac_pin.errors import unknown_name
from pmjac_pin.values.arrays import Array, Index
from pmjac_pin.values.columns import named_columns

FROM_GUESS = -1  # in place of a neighbour's number
_SEEDS = 64  # cells tried from the guess at a time until one is reached

#: (cells, where their paths begin (k, nq), or None for the guess) ↦ what became of them.
CloseCells: TypeAlias = Callable[[Index, Array | None], ManyClosed]


class Walked(NamedTuple):
    """Rows of q, shares, statuses, and from which cell each was reached or tried last."""

    q: Array
    share: Array
    status: Statuses
    source: Index


def walk_grid(shape: tuple[int, ...], nearest: Index, nq: int, close: CloseCells) -> Walked:
    """Walk to all cells of a grid.

    Parameters
    ----------
    shape : tuple of int
        How many cells there are along each axis.
    nearest : ndarray of int, shape (cells,)
        All cells in the order in which they are tried from the guess.
    nq : int
    close : callable
    """
    count = nearest.size
    found = Walked(
        q=np.full((count, nq), np.nan),
        share=np.zeros(count),
        status=np.full(count, Status.STOPPED, dtype=np.int8),
        source=np.full(count, FROM_GUESS),
    )
    reached = nearest[:0]
    for start in range(0, count, _SEEDS):
        cells = nearest[start : start + _SEEDS]
        reached = _take(found, cells, np.full(cells.size, FROM_GUESS), close(cells, None))
        if reached.size:
            break
    sources, cells = _edges(shape, reached)
    while cells.size:
        waiting = found.status[cells] == Status.STOPPED
        sources, cells = sources[waiting], cells[waiting]
        _, now = np.unique(cells, return_index=True)  # each cell once in a wave
        poses = close(cells[now], found.q[sources[now]])
        reached = _take(found, cells[now], sources[now], poses)
        more = _edges(shape, reached)
        sources = np.concatenate([np.delete(sources, now), more[0]])
        cells = np.concatenate([np.delete(cells, now), more[1]])
    return found


def spread(over: Any, motors: Sequence[str], rest: Array) -> Array:
    """Return the motor values of all cells, (*grid, n).

    Parameters
    ----------
    over : mapping of str to array_like, shape (k,)
        The axes.
    motors : sequence of str
    rest : ndarray, shape (n,)
        Where the motors are that are no axes.
    """
    axes = named_columns(over, "over")
    for name in axes:
        if name not in motors:
            raise unknown_name("motor", name, tuple(motors))
    meshed = np.meshgrid(*axes.values(), indexing="ij")
    values = np.tile(rest, (*meshed[0].shape, 1))
    values[..., [motors.index(name) for name in axes]] = np.stack(meshed, axis=-1)
    return values


def _take(found: Walked, cells: Index, sources: Index, poses: ManyClosed) -> Index:
    """Note what became of cells; return those that are closed now."""
    found.q[cells], found.share[cells] = poses.q, poses.share
    found.status[cells], found.source[cells] = poses.status, sources
    closed: Index = cells[poses.status == Status.CLOSED]
    return closed


def _edges(shape: tuple[int, ...], cells: Index) -> tuple[Index, Index]:
    """Return cells and their neighbours along each axis, one beside the other."""
    sources, neighbours = [cells[:0]], [cells[:0]]
    places = np.unravel_index(cells, shape)
    for axis, size in enumerate(shape):
        for step in (-1, 1):
            moved = places[axis] + step
            inside = (moved >= 0) & (moved < size)
            beside = [place[inside] for place in places]
            beside[axis] = moved[inside]
            sources.append(cells[inside])
            neighbours.append(np.ravel_multi_index(beside, shape))
    return np.concatenate(sources), np.concatenate(neighbours)
