"""A grid of motor values walked from cell to neighbouring cell, as a map wants it.

Each pose starts from a closed one beside it: paths are short, and one assembly mode is kept. Cells
are walked to in waves. A cell that a path from one neighbour does not reach is tried from the
others as these are closed, once each. Paths that end take many steps: a wave does not wait for
them, and they are walked together when nothing else is left.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np

from pmjac_pin.batches.pieces import Progress, interrupted
from pmjac_pin.batches.results import ManyClosed, ManyInGrid, Status, Statuses
from pmjac_pin.errors import Interrupted, unknown_name
from pmjac_pin.model.coordinates import JointCoordinates
from pmjac_pin.rates.partition import Partition
from pmjac_pin.values.arrays import Array, Index, Mask, sealed
from pmjac_pin.values.columns import named_axes

FROM_GUESS = -1  # in place of a neighbour's number
_SEEDS = 64  # cells tried from the guess at a time until one is reached

_FEW_STEPS = 4  # a path to the cell beside takes one or two, but where it ends

#: (cells, where their paths begin (k, nq), or None for the guess, steps or None for all that it
#: takes) ↦ what became of them, NOT_DONE where it takes more.
CloseCells: TypeAlias = Callable[[Index, Array | None, int | None], ManyClosed]


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Cells of motor values.

    Attributes
    ----------
    values : ndarray, shape (*grid, n)
    nearest : ndarray of int, shape (cells,)
        All cells in the order in which they are tried from the guess.
    coordinates : JointCoordinates
    """

    values: Array
    nearest: Index
    coordinates: JointCoordinates

    @classmethod
    def over(
        cls, over: object, partition: Partition, coordinates: JointCoordinates, rest: Array
    ) -> Grid:
        """Return all combinations of the values of some motors.

        Parameters
        ----------
        over : mapping of str to array_like, shape (k,), or xarray.Dataset
            The axes.
        partition : Partition
        coordinates : JointCoordinates
        rest : ndarray, shape (n,)
            Where the motors are that are no axes, and where the others are near.
        """
        motors = partition.actuated_names
        units = dict(zip(motors, partition.units_of(partition.actuated), strict=True))
        axes = named_axes(over, "over", units)
        for name in axes:
            if name not in motors:
                raise unknown_name("motor", name, motors)
        meshed = np.meshgrid(*axes.values(), indexing="ij")
        values = np.tile(rest, (*meshed[0].shape, 1))
        values[..., [motors.index(name) for name in axes]] = np.stack(meshed, axis=-1)
        away = (values - rest).reshape(-1, rest.size) / partition.motor_scale
        nearest = np.argsort(np.linalg.norm(away, axis=1), kind="stable")
        return cls(values, nearest, coordinates)

    @property
    def cells(self) -> Array:
        """The motor values of all cells, row by row."""
        return self.values.reshape(-1, self.values.shape[-1])

    def walk(self, nq: int, close: CloseCells, progress: Progress | None = None) -> ManyInGrid:
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
            for told in self._wander(walked, close):
                if progress is not None:
                    progress(told, count)
        except KeyboardInterrupt:
            stopped = walked.status == Status.STOPPED  # there may be other ways to them
            walked.status[stopped] = Status.NOT_DONE
            done = f"{count - int(stopped.sum())} of {count} cells"
            raise interrupted(done, self._found(walked)) from None
        return self._found(walked)

    def _wander(self, walked: _Walked, close: CloseCells) -> Iterator[int]:
        """Walk to the nearest cells that are reached, and on from cell to cell.

        Yield of how many cells it is known now what became of them.
        """
        reached = self.nearest[:0]
        for start in range(0, self.nearest.size, _SEEDS):
            cells = self.nearest[start : start + _SEEDS]
            edges = _Edges(np.full(cells.size, FROM_GUESS), cells)
            reached, _ = walked.wave(close, edges, None)
            yield walked.known
            if reached.size:
                break
        quick, slow = self._edges(reached), self._edges(reached[:0])
        while (quick := walked.waiting(quick)).size or (slow := walked.waiting(slow)).size:
            few = bool(quick.size)
            now, later = (quick if few else slow).once()
            reached, unfinished = walked.wave(close, now, _FEW_STEPS if few else None)
            quick = (later if few else quick).and_(self._edges(reached))
            slow = slow.and_(unfinished) if few else later
            yield walked.known
        yield self.nearest.size  # to the others no path leads

    def _edges(self, cells: Index) -> _Edges:
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
        return _Edges(np.concatenate(sources), np.concatenate(neighbours))

    def _found(self, walked: _Walked) -> ManyInGrid:
        shape = self.values.shape[:-1]
        return ManyInGrid(
            q=sealed(walked.q.reshape(*shape, -1)),
            share=sealed(walked.share.reshape(shape)),
            status=sealed(walked.status.reshape(shape)),
            actuated=self.values,
            source=sealed(walked.source.reshape(shape)),
            coordinates=self.coordinates,
        )


class _Edges(NamedTuple):
    """Cells, and from where each is to be walked to."""

    sources: Index
    cells: Index

    @property
    def size(self) -> int:
        return self.cells.size

    def those(self, which: Mask) -> _Edges:
        return _Edges(self.sources[which], self.cells[which])

    def and_(self, other: _Edges) -> _Edges:
        return _Edges(*map(np.concatenate, zip(self, other, strict=True)))

    def once(self) -> tuple[_Edges, _Edges]:
        """Return each cell once, and the rest."""
        now = np.zeros(self.size, dtype=bool)
        now[np.unique(self.cells, return_index=True)[1]] = True
        return self.those(now), self.those(~now)


class _Walked(NamedTuple):
    """Rows of q, shares, statuses, and from which cell each was reached or tried last."""

    q: Array
    share: Array
    status: Statuses
    source: Index

    @property
    def known(self) -> int:
        return int((self.status != Status.STOPPED).sum())

    def waiting(self, edges: _Edges) -> _Edges:
        """Return those that lead to cells which no path has reached."""
        return edges.those(self.status[edges.cells] == Status.STOPPED)

    def wave(
        self, close: CloseCells, edges: _Edges, most_steps: int | None
    ) -> tuple[Index, _Edges]:
        """Walk along edges; return cells that are closed now, and edges that take more steps."""
        start = None if (edges.sources == FROM_GUESS).all() else self.q[edges.sources]
        try:
            poses = close(edges.cells, start, most_steps)
        except Interrupted as stopped:
            self._take(stopped.done, edges)
            raise
        self._take(poses, edges)
        unfinished = edges.those(poses.status == Status.NOT_DONE)
        return edges.cells[poses.status == Status.CLOSED], unfinished

    def _take(self, poses: ManyClosed, edges: _Edges) -> None:
        """Note what became of cells."""
        known = poses.status != Status.NOT_DONE
        at = edges.cells[known]
        self.q[at], self.share[at] = poses.q[known], poses.share[known]
        self.status[at], self.source[at] = poses.status[known], edges.sources[known]
