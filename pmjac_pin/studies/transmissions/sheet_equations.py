"""SheetEquations: the loop equations along a sheet, as series over pieces of its cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import product

import numpy as np

from pmjac_pin.algebra.boxes import Boxes
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.series import Exponents, Series, SeriesAlgebra
from pmjac_pin.errors import ArgumentError
from pmjac_pin.kinematics.loops import Loops, riding
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.coupling import Coupling
from pmjac_pin.model.joint_kind import JointMotion
from pmjac_pin.studies.transmissions.sheet import Sheet, half_width, middle
from pmjac_pin.values.arrays import Array, Index, Mask

ORDER = 4
_BOXES = Boxes()
_SLID = 2.0  # more than √3: of three slides, and of axes that turn


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


@dataclass(frozen=True, slots=True, eq=False)
class EquationsAlong:
    """The equations along a sheet, in b pieces.

    Attributes
    ----------
    residual : mapping of exponents to Intervals (b, p)
        Coefficients of η, the variables from −1 to 1 over each piece: those below the order in
        its middle, those of the order all over it.
    motions : mapping of int to JointMotion
        How each joint moves all over the pieces, by its first column.
    """

    residual: Mapping[Exponents, Intervals]
    motions: Mapping[int, JointMotion]


class SheetEquations:
    """The loop equations of a mechanism whose motors are the joints of a sheet.

    Raises
    ------
    ArgumentError
        A joint of a kind that cannot be taken apart; a gear on a joint without end.

    Attributes
    ----------
    rows : int
        How many equations.
    """

    def __init__(self, mechanism: Mechanism, sheet: Sheet) -> None:
        model = mechanism.kinematics.model
        self._sheet, self._tree = sheet, Tree(model)
        self._loops = Loops(model, self._tree, mechanism.spec.loops, mechanism.parameters)
        partition = mechanism.problem.partition
        self._driven = {column: k for k, column in enumerate(partition.actuated.tolist())}
        self._scale, self._nv = partition.column_scale, model.nv
        self._algebra = SeriesAlgebra(len(sheet.axes), ORDER)
        self.rows = self._loops.count
        for coupling in self._loops.couplings.values():
            if coupling.coordinates.wraps[coupling.columns].any():
                raise ArgumentError("a gear on a joint that turns without end")

    def entry_scale(self) -> Array:
        """Return what an unknown of 1 is in each entry of q: `Partition.column_scale`."""
        found = np.ones(max(link.entries.stop for link in self._tree.links.values()))
        for link in self._tree.links.values():
            slides, column = link.kind.slides, link.column
            found[link.entries] = self._scale[column + link.kind.nv - 1]
            found[link.entries.start : link.entries.start + slides] = self._scale[column]
        return found

    def along(self, pieces: Pieces) -> EquationsAlong:
        """Return the equations along the sheet over some pieces."""
        values, entries = self._values(pieces)
        motions: dict[int, JointMotion] = {}

        def motion(link: Link) -> JointMotion:
            kind, pitch, place = link.kind, link.edge.pitch, self._driven.get(link.column)
            if place is None:
                found = kind.motion(self._algebra, entries[link.entries], pitch)
            else:
                found = kind.at(self._algebra, values[place], pitch)
            motions[link.column] = found
            return found

        poses, count = Poses(self._tree, self._algebra, motion), pieces.at.shape[1]
        rows: dict[Exponents, tuple[Array, Array]] = {}
        for pair in self._loops.pairs:
            for (where, _), block in zip(pair.blocks, riding(pair, poses), strict=True):
                self._put(rows, where, block.rows.value, count)
        for row, coupling in self._loops.couplings.items():
            self._put(rows, slice(row, row + 1), self._coupled(coupling, values, entries), count)
        wide = {
            column: JointMotion(*(tuple(_wide(x, count) for x in part) for part in one))
            for column, one in motions.items()
        }
        residual = {key: Intervals(*(end.T.copy() for end in ends)) for key, ends in rows.items()}
        return EquationsAlong(residual, wide)

    def around(self, along: EquationsAlong, radius: Array) -> tuple[Intervals, Array]:
        """Return [K K*] (b, p, nv) over all poses up to some radii (b,) from the sheet.

        And the least cosine between axes that the rows want to coincide.

        Parameters
        ----------
        along : Along
        radius : ndarray, shape (b,)
            Of each unknown, in the units of `Partition.column_scale`.
        """

        def motion(link: Link) -> JointMotion:
            known, column = along.motions[link.column], link.column
            if column in self._driven:
                return known
            kind = link.kind
            slide = radius * self._scale[column] * _SLID
            turn = radius * self._scale[column + kind.nv - 1] * _SLID
            if kind.screw:
                slide = abs(link.edge.pitch) * turn
            slides = tuple(x.widened(slide) for x in known.slides)
            return JointMotion(slides, tuple(x.widened(turn) for x in known.turn))

        poses = Poses(self._tree, _BOXES, motion, range(self._nv))
        shape = (self.rows, self._nv, radius.size)
        lower, upper, cosine = np.zeros(shape), np.zeros(shape), np.ones(radius.size)
        for pair in self._loops.pairs:
            for (where, _), block in zip(pair.blocks, riding(pair, poses), strict=True):
                columns = list(block.rows.columns)
                if columns:
                    lower[where, columns] = block.rows.rates.lower
                    upper[where, columns] = block.rows.rates.upper
                if block.cosine is not None:
                    cosine = np.minimum(cosine, block.cosine.value.lower[0])
        for row, coupling in self._loops.couplings.items():
            lower[row] = upper[row] = coupling.gradient[:, None]
        return Intervals(*(np.moveaxis(end, -1, 0).copy() for end in (lower, upper))), cosine

    def _values(self, pieces: Pieces) -> tuple[list[Series], Series]:
        """Return the values of the joints that drive, and the sheet's entries of q, as series.

        Of 2b poses: in the middles of the pieces, and all over them.
        """
        algebra, axes = self._algebra, self._sheet.axes
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
        powers = self._sheet.powers(cells)
        whole = Intervals(
            *(end.transpose(0, 2, 1)[:, :, None] for end in (powers.lower, powers.upper))
        )
        total = algebra.boxes(whole[0])
        for number, exponents in enumerate(product(range(4), repeat=len(axes))):
            if number:
                factors = zip(variables, exponents, strict=True)
                monomial = reduce(Series.__mul__, [s for s, k in factors for _ in range(k)])
                total = total + monomial.each(whole[number].__mul__)
        return values, total

    def _coupled(self, coupling: Coupling, values: Sequence[Series], entries: Series) -> Series:
        first, second = (
            values[self._driven[column]]
            if column in self._driven
            else entries[coupling.coordinates.entry(column)]
            for column in coupling.columns.tolist()
        )
        scaled = first.each(lambda term: term * Intervals.exact(coupling.ratio))
        offset = self._algebra.boxes(Intervals.exact([[coupling.offset]]))
        return (second - scaled - offset)[None]

    def _put(
        self, rows: dict[Exponents, tuple[Array, Array]], where: slice, block: Series, count: int
    ) -> None:
        """Write a block's coefficients: below the order of the middles, else of whole pieces."""
        for exponents, term in block.terms.items():
            part = slice(count, None) if sum(exponents) == ORDER else slice(0, count)
            ends = rows.setdefault(
                exponents, (np.zeros((self.rows, count)), np.zeros((self.rows, count)))
            )
            for side, end in zip(ends, (term.lower, term.upper), strict=True):
                shape = (end.shape[0], 2 * count)
                side[where] = np.broadcast_to(end[:, 0], shape)[:, part]


def _wide(series: Series, count: int) -> Intervals:
    """Return what a series is all over the pieces."""
    value = series.value
    shape = (*value.shape[:-1], 2 * count)
    ends = (np.broadcast_to(end, shape)[..., count:] for end in (value.lower, value.upper))
    return Intervals(*ends)
