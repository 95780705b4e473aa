"""A grid of motor values walked from cell to neighbouring cell, as a map wants it.

Each pose starts from a closed one beside it: paths are short, and one assembly mode is kept. Cells
are walked to in waves. A cell that a path from one neighbour does not reach is tried from the
others as these are closed, once each.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from pmjac_pin.batches.pieces import interrupted
from pmjac_pin.batches.results import ManyClosed, ManyInGrid, Status, Statuses
from pmjac_pin.errors import Interrupted, unknown_name
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, Index, Mask, sealed
from pmjac_pin.values.columns import named_columns

FROM_GUESS = -1  # in place of a neighbour's number
_SEEDS = 64  # cells tried from the guess at a time until one is reached

#: (cells, where their paths begin (k, nq), or None for the guess) ↦ what became of them.
CloseCells: TypeAlias = Callable[[Index, Array | None], ManyClosed]


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Cells of motor values.

    Attributes
    ----------
    values : ndarray, shape (*grid, n)
    nearest : ndarray of int, shape (cells,)
        All cells in the order in which they are tried from the guess.
    """

    values: Array
    nearest: Index

    @classmethod
    def over(cls, over: object, partition: Partition, rest: Array) -> Grid:
        """Return all combinations of the values of some motors.

        Parameters
        ----------
        over : mapping of str to array_like, shape (k,)
            The axes.
        partition : Partition
        rest : ndarray, shape (n,)
            Where the motors are that are no axes, and where the others are near.
        """
        axes, motors = named_columns(over, "over"), partition.actuated_names
        for name in axes:
            if name not in motors:
                raise unknown_name("motor", name, motors)
        meshed = np.meshgrid(*axes.values(), indexing="ij")
        values = np.tile(rest, (*meshed[0].shape, 1))
        values[..., [motors.index(name) for name in axes]] = np.stack(meshed, axis=-1)
        away = (values - rest).reshape(-1, rest.size) / partition.column_scale[partition.actuated]
        return cls(values, np.argsort(np.linalg.norm(away, axis=1), kind="stable"))

    @property
    def cells(self) -> Array:
        """The motor values of all cells, row by row."""
        return self.values.reshape(-1, self.values.shape[-1])

    def walk(self, nq: int, close: CloseCells) -> ManyInGrid:
        """Walk to all cells.

        Raises
        ------
        Interrupted
        """
        count = self.nearest.size
        walked = _Walked(
            q=np.full((count, nq), np.nan),
            share=np.zeros(count),
            status=np.full(count, Status.STOPPED, dtype=np.int8),
            source=np.full(count, FROM_GUESS),
        )
        try:
            self._wander(walked, close)
        except KeyboardInterrupt:
            stopped = walked.status == Status.STOPPED  # there may be other ways to them
            walked.status[stopped] = Status.NOT_DONE
            done = f"{count - int(stopped.sum())} of {count} cells"
            raise interrupted(done, self._found(walked)) from None
        return self._found(walked)

    def _wander(self, walked: _Walked, close: CloseCells) -> None:
        """Walk to the nearest cells that are reached, and on from cell to cell."""
        reached = self.nearest[:0]
        for start in range(0, self.nearest.size, _SEEDS):
            cells = self.nearest[start : start + _SEEDS]
            reached = walked.wave(close, cells, np.full(cells.size, FROM_GUESS))
            if reached.size:
                break
        sources, cells = self._edges(reached)
        while (waiting := walked.status[cells] == Status.STOPPED).any():
            sources, cells = sources[waiting], cells[waiting]
            _, now = np.unique(cells, return_index=True)  # each cell once in a wave
            reached = walked.wave(close, cells[now], sources[now])
            more = self._edges(reached)
            sources = np.concatenate([np.delete(sources, now), more[0]])
            cells = np.concatenate([np.delete(cells, now), more[1]])

    def _edges(self, cells: Index) -> tuple[Index, Index]:
        """Return cells and their neighbours along each axis, one beside the other."""
        sources, neighbours = [cells[:0]], [cells[:0]]
        shape = self.values.shape[:-1]
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

    def _found(self, walked: _Walked) -> ManyInGrid:
        shape = self.values.shape[:-1]
        return ManyInGrid(
            q=sealed(walked.q.reshape(*shape, -1)),
            share=sealed(walked.share.reshape(shape)),
            status=sealed(walked.status.reshape(shape)),
            actuated=self.values,
            source=sealed(walked.source.reshape(shape)),
        )


class _Walked(NamedTuple):
    """Rows of q, shares, statuses, and from which cell each was reached or tried last."""

    q: Array
    share: Array
    status: Statuses
    source: Index

    def wave(self, close: CloseCells, cells: Index, sources: Index) -> Index:
        """Walk to cells from others; return those that are closed now."""
        start = None if (sources == FROM_GUESS).all() else self.q[sources]
        try:
            poses = close(cells, start)
        except Interrupted as stopped:
            known = stopped.done.status != Status.NOT_DONE
            self._take(stopped.done, known, cells, sources)
            raise
        return self._take(poses, np.ones(cells.size, dtype=bool), cells, sources)

    def _take(self, poses: ManyClosed, known: Mask, cells: Index, sources: Index) -> Index:
        """Note what became of cells."""
        at = cells[known]
        self.q[at], self.share[at] = poses.q[known], poses.share[known]
        self.status[at], self.source[at] = poses.status[known], sources[known]
        closed: Index = cells[poses.status == Status.CLOSED]
        return closed
