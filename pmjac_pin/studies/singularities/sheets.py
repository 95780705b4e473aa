"""Sheets: what a slice's grid reaches from one assembly mode, and what says where to look.

A sheet ends where the machine folds: between a cell that is closed and one beside it that is not
reached lies a curve of gain, seldom a limit. Within it the tool loses a motion where the
determinant of its rates by the motors changes sign, or where its smallest singular value has a
valley.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from pmjac_pin.batches.batch import Batch
from pmjac_pin.batches.results import ManyClosed, ManyInGrid, Status
from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.studies.singularities.plane_slice import PlaneSlice
from pmjac_pin.studies.singularities.singular_equations import SingularEquations
from pmjac_pin.values.arrays import Array, Mask

_MOST_CELLS = 2000  # along an axis: some hundred bytes for each of four million
_ALIKE_POSES = 1e-6  # lengths or rad
_CELLS_NEAR = 16  # cells near a pose, to tell on which sheet it is
_STEPS_TO_CELLS = 6  # a path to a cell nearby takes one or two, but where it ends
_CELLS_AWAY = (3.0, 2.0, 1.0, 0.5)
_SOME_STEPS = 60  # away from a fold, or from right beside one


def as_grid(cells: object) -> tuple[int, int]:
    """Return the shape of a slice's grid of so many cells along each axis.

    Raises
    ------
    ArgumentError
        No whole number, fewer than 2, or so many that the grid does not fit into memory.
    """
    if not isinstance(cells, int) or isinstance(cells, bool) or not 2 <= cells <= _MOST_CELLS:
        raise ArgumentError(f"`cells` is a number, 2 to {_MOST_CELLS}, got {quoted(cells)}")
    return cells, cells


def next_to(marked: Mask) -> Mask:
    """Tell which cells of a grid (a, b) are beside a marked one."""
    padded = np.pad(marked, 1)
    rows = padded[:-2, 1:-1] | padded[2:, 1:-1]
    return np.asarray(rows | padded[1:-1, :-2] | padded[1:-1, 2:])


@dataclass(frozen=True, eq=False)
class SliceSheet:
    """The cells of a slice that one assembly mode reaches.

    Attributes
    ----------
    start : Configuration
        A pose on it.
    cells : ManyInGrid
    new : ndarray of bool, shape (a, b)
        Which closed cells no sheet before it has: a sheet that winds about a cusp lies over itself,
        and its layers are several here.
    """

    start: Configuration
    cells: ManyInGrid
    new: Mask

    @cached_property
    def closed(self) -> Mask:
        """Which cells are reached, shape (a, b)."""
        return np.asarray(self.cells.status == Status.CLOSED)

    def border(self) -> Array:
        """Return q of the closed cells beside others that no path reaches, shape (k, nq)."""
        return np.asarray(self.cells.q[self.new & next_to(self.cells.status == Status.STOPPED)])

    def valleys(self, values: Array) -> Array:
        """Return q of cells where something may pass zero between those beside, (k, nq).

        Along a row or a column of the grid it is lower than on both sides, and by as much as what
        is left, as |x| is beside 0.

        Parameters
        ----------
        values : ndarray, shape (a, b)
            Not negative, NaN where nothing is known.
        """
        found = np.zeros(values.shape, dtype=bool)
        for axis in (0, 1):
            along = np.moveaxis(values, axis, 0)
            before, here, after = along[:-2], along[1:-1], along[2:]
            low = (here <= before) & (here <= after) & (before + after > 3.0 * here)
            np.moveaxis(found, axis, 0)[1:-1] |= low
        return np.asarray(self.cells.q[found & self.new])

    def changes(self, signed: Array) -> Array:
        """Return q of cells where something has another sign than in one beside, (k, nq)."""
        found = np.zeros(signed.shape, dtype=bool)
        found[:-1] |= signed[:-1] * signed[1:] <= 0.0
        found[:, :-1] |= signed[:, :-1] * signed[:, 1:] <= 0.0
        return np.asarray(self.cells.q[found & self.closed])


class Sheets:
    """The sheets of a slice that are known.

    Parameters
    ----------
    area : PlaneSlice
    cells : (int, int)
        How many of the grid, along each axis.
    limits : bool
        Whether the motors keep within theirs.
    """

    def __init__(self, area: PlaneSlice, cells: tuple[int, int], *, limits: bool = True) -> None:
        self.area, self.known, self._limits = area, list[SliceSheet](), limits
        self._many, self._axes = Batch(area.mechanism), area.axes(cells)
        self._largest = max(1.0, area.mechanism.characteristic_length)
        self._values = np.stack(np.meshgrid(*self._axes.values(), indexing="ij"), axis=-1)

    @property
    def cell(self) -> Array:
        """Width and height of a cell, m or rad."""
        return np.asarray(self.area.size / [axis.size - 1 for axis in self._axes.values()])

    def add(self, start: Configuration) -> int | None:
        """Return which sheet a pose is on, a new one if it is on none; None where no cell is."""
        leads = list(self._leads(start)) or list(self._leads(start, _SOME_STEPS))
        known = self._among_known(leads)
        if known is None and leads:
            cells = self._many.grid(self._axes, start, enforce_limits=self._limits)
            new = np.asarray(cells.status == Status.CLOSED)
            for other in self.known:
                new &= ~self._alike(cells.q, other.cells.q)
            self.known.append(SliceSheet(start, cells, new))
            return len(self.known) - 1
        return known

    def index(self, pose: Configuration) -> int | None:
        """Return which known sheet a pose is on, None where none has a cell that it leads to."""
        return self._among_known(list(self._leads(pose)))

    def is_off(self, pose: Configuration) -> bool:
        """Tell whether a pose leads to cells nearby which no known sheet has."""
        leads = list(self._leads(pose))
        return bool(leads) and self._among_known(leads) is None

    def away_from(self, q: Array, inward: Array) -> Configuration | None:
        """Return the pose some cells away along motor rates, as far as one mode leads so.

        Parameters
        ----------
        q : ndarray, shape (nq,)
            A pose, right beside a fold.
        inward : ndarray, shape (n,)
            Away from it, on the motors' scaled rates.
        """
        partition = self.area.mechanism.problem.partition
        rates = inward * partition.motor_scale
        longest = float(np.max(np.abs(rates[self.area.motors]) / self.cell))
        strides = np.array(_CELLS_AWAY)[:, None] * rates / longest
        values = self.area.mechanism.coordinates.values_of(q, partition.actuated)
        start = np.broadcast_to(q, (len(strides), q.size))
        found = self._many._toward(values + strides, start, "none", _SOME_STEPS, threads=1)
        for pose, status in zip(found.q, found.status, strict=True):
            if status == Status.CLOSED:
                return self.area.mechanism.configuration(pose)
        return None

    def _among_known(self, leads: list[tuple[int, Array]]) -> int | None:
        for number, sheet in enumerate(self.known):
            closed, rows = sheet.closed.ravel(), sheet.cells.q.reshape(sheet.closed.size, -1)
            for cell, q in leads:
                if closed[cell] and self.area.apart(rows[cell], q) <= _ALIKE_POSES:
                    return number
        return None

    def _alike(self, q: Array, other: Array) -> Mask:
        """Tell which poses of two arrays (a, b, nq) are the same, full turns aside."""
        coordinates = self.area.mechanism.coordinates
        entries = [coordinates.entry(k) for k in np.flatnonzero(coordinates.angles).tolist()]
        away = q - other
        away[..., entries] = np.remainder(away[..., entries] + np.pi, 2.0 * np.pi) - np.pi
        return np.asarray(np.abs(away).max(axis=-1) <= _ALIKE_POSES * self._largest)

    def _leads(
        self, pose: Configuration, steps: int = _STEPS_TO_CELLS
    ) -> Iterator[tuple[int, Array]]:
        """Yield the cells near a pose that straight paths from it reach, and q there."""
        near = self.area.nearest(self._values, self.area.places(pose.q), _CELLS_NEAR)
        start = np.broadcast_to(pose.q, (near.size, pose.q.size))
        places = self._values.reshape(-1, 2)[near]
        reached = self.walked(start, places, limits="motors", steps=steps)
        for cell, q, status in zip(near.tolist(), reached.q, reached.status, strict=True):
            if status == Status.CLOSED:
                yield cell, q

    def walked(
        self, start: Array, places: Array, *, limits: Literal["motors", "none"], steps: int
    ) -> ManyClosed:
        """Walk from closed poses (k, nq) straight to places (k, 2), other motors at rest."""
        mechanism = self.area.mechanism
        targets = mechanism.coordinates.values_of(start, mechanism.problem.partition.actuated)
        targets[:, self.area.motors] = places
        return self._many._toward(targets, start, limits, steps, threads=1)

    def border_seeds(self, sheet: SliceSheet, equations: SingularEquations) -> Iterator[Array]:
        """Yield q near which the sheets' own K* may lose rank: on their borders, in valleys."""
        yield from sheet.border()
        yield from self.inner_seeds(sheet, equations)

    def inner_seeds(self, sheet: SliceSheet, equations: SingularEquations) -> Iterator[Array]:
        """Yield q near which a matrix may lose rank."""
        values = np.full(sheet.closed.shape, np.nan)
        if sheet.new.any():
            matrices = np.array([equations.matrix(q) for q in sheet.cells.q[sheet.closed]])
            found = np.linalg.svd(matrices, compute_uv=False)[:, equations.rank - 1]
            values[sheet.closed] = found
        yield from sheet.valleys(values)
