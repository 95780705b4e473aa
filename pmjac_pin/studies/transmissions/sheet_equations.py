"""SheetEquations: the loop equations along a sheet, as series over pieces of its cells."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import product

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.series import Series, SeriesAlgebra
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.studies.series_equations import EquationsAlong, SeriesEquations
from pmjac_pin.studies.transmissions.sheet import Sheet, half_width, middle
from pmjac_pin.values.arrays import Array, Index, Mask


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Parts of cells.

    Attributes
    ----------
    cells : ndarray of int, shape (n, b)
    at, half : ndarray, shape (n, b)
        The middle and half the width, where a cell goes from −1 to 1: exact in binary.
    """

    cells: Index
    at: Array
    half: Array

    @classmethod
    def whole(cls, shape: Sequence[int]) -> Pieces:
        """Return all cells of a grid of so many."""
        cells = np.array(list(np.ndindex(*shape)), dtype=np.intp).T.reshape(len(shape), -1)
        return cls(cells, np.zeros(cells.shape), np.ones(cells.shape))

    def __getitem__(self, which: slice | Mask) -> Pieces:
        return Pieces(self.cells[:, which], self.at[:, which], self.half[:, which])

    def split(self) -> Pieces:
        """Return their halves along each joint."""
        half, at = 0.5 * self.half, []
        for sides in product((-1.0, 1.0), repeat=len(half)):
            at.append(self.at + half * np.array(sides)[:, None])
        count = len(at)
        return Pieces(np.tile(self.cells, count), np.hstack(at), np.tile(half, count))


class SheetEquations(SeriesEquations):
    """The loop equations of a mechanism whose motors are the joints of a sheet.

    Raises
    ------
    ArgumentError
        As `SeriesEquations`.
    """

    def __init__(self, mechanism: Mechanism, sheet: Sheet) -> None:
        self._columns = mechanism.problem.partition.actuated.tolist()
        super().__init__(mechanism, len(sheet.axes), self._columns)
        self._sheet = sheet

    def along(self, pieces: Pieces) -> EquationsAlong:
        """Return the equations along the sheet over some pieces."""
        values, entries = series_over(self._sheet, pieces, self.algebra)
        by_column = dict(zip(self._columns, values, strict=True))
        return self.of_series(by_column, entries, pieces.at.shape[1])


def series_over(
    sheet: Sheet, pieces: Pieces, algebra: SeriesAlgebra
) -> tuple[list[Series], Series]:
    """Return the values along the axes of a sheet, and its entries of q, as series.

    Of 2b poses: in the middles of the pieces, and all over them.
    """
    axes = sheet.axes
    variables = []
    for k, (at, half) in enumerate(zip(pieces.at, pieces.half, strict=True)):
        ends = Intervals(np.hstack([at, at - half]), np.hstack([at, at + half]))
        slope = Intervals.exact(np.hstack([half, half]))
        variables.append(algebra.variable(k, ends[None], slope[None]))
    cells = np.tile(pieces.cells, 2)
    values = [
        algebra.boxes(middle(axis, cell)[None]) + s.each(half_width(axis, cell).__mul__)
        for axis, cell, s in zip(axes, cells, variables, strict=True)
    ]
    powers = sheet.powers(cells)
    whole = Intervals(*(end.transpose(0, 2, 1)[:, :, None] for end in (powers.lower, powers.upper)))
    total = algebra.boxes(whole[0])
    for number, exponents in enumerate(product(range(4), repeat=len(axes))):
        if number:
            factors = zip(variables, exponents, strict=True)
            monomial = reduce(Series.__mul__, [s for s, k in factors for _ in range(k)])
            total = total + monomial.each(whole[number].__mul__)
    return values, total
