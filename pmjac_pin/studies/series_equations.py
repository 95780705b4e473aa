"""SeriesEquations: the loop equations along joint values that are series over many pieces at once.

Some joints' values are given as series in the variables, and the entries of q of all others. So the
equations are series, too, whose coefficients are enclosed; and [K K*] is enclosed over all poses
near by, the given joints at their values.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.boxes import BOXES
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.algebra.series import Exponents, Series, SeriesAlgebra
from pmjac_pin.errors import ArgumentError
from pmjac_pin.kinematics.loops import Loops, riding
from pmjac_pin.kinematics.tree import Link, Poses, Tree
from pmjac_pin.mechanism import Mechanism
from pmjac_pin.model.coupling import Coupling
from pmjac_pin.model.joint_kind import JointMotion
from pmjac_pin.values.arrays import Array

ORDER = 4  #: of the series
_SLID = 2.0  # more than √3: of three slides, and of axes that turn


@dataclass(frozen=True, slots=True, eq=False)
class EquationsAlong:
    """The equations along given values, in b pieces.

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


class SeriesEquations:
    """The loop equations of a mechanism, some joints of which have given values.

    Parameters
    ----------
    mechanism : Mechanism
    variables : int
        Of the series.
    driven : iterable of int
        The columns of the joints whose values are given.

    Raises
    ------
    ArgumentError
        A joint of a kind that cannot be taken apart; a gear on a joint without end.

    Attributes
    ----------
    rows : int
        How many equations.
    algebra : SeriesAlgebra
    """

    def __init__(self, mechanism: Mechanism, variables: int, driven: Iterable[int]) -> None:
        model = mechanism.kinematics.model
        self._tree = Tree(model)
        self._loops = Loops(model, self._tree, mechanism.spec.loops, mechanism.parameters)
        partition = mechanism.problem.partition
        self._driven = set(driven)
        self._scale, self._nv = partition.column_scale, model.nv
        self.algebra = SeriesAlgebra(variables, ORDER)
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

    def of_series(
        self, values: Mapping[int, Series], entries: Series, count: int
    ) -> EquationsAlong:
        """Return the equations along series, of 2b poses: in the middles of b pieces, and all over.

        Parameters
        ----------
        values : mapping of int to Series
            Of the driven joints, by their columns.
        entries : Series
            All entries of q.
        count : int
            b
        """
        motions: dict[int, JointMotion] = {}

        def motion(link: Link) -> JointMotion:
            kind, pitch = link.kind, link.edge.pitch
            if (value := values.get(link.column)) is None:
                found = kind.motion(self.algebra, entries[link.entries], pitch)
            else:
                found = kind.at(self.algebra, value, pitch)
            motions[link.column] = found
            return found

        poses = Poses(self._tree, self.algebra, motion)
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
        """Return [K K*] (b, p, nv) over all poses up to some radii (b,) from the series.

        And the least cosine between axes that the rows want to coincide.

        Parameters
        ----------
        along : EquationsAlong
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

        poses = Poses(self._tree, BOXES, motion, range(self._nv))
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

    def _coupled(self, coupling: Coupling, values: Mapping[int, Series], entries: Series) -> Series:
        first, second = (
            values[column] if column in values else entries[coupling.coordinates.entry(column)]
            for column in coupling.columns.tolist()
        )
        scaled = first.each(lambda term: term * Intervals.exact(coupling.ratio))
        offset = self.algebra.boxes(Intervals.exact([[coupling.offset]]))
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
