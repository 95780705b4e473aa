"""Enclosure: a proof of how far a sheet is from the closed poses that it interpolates.

By Krawczyk's test along the sheet's polynomials (`SeriesProof`), in pieces of its cells that are
halved until it holds. Rates follow: −K*⁻¹K is within ‖E‖ / (1 − ‖E‖) ‖A K‖ of −A K, by columns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.errors import ArgumentError
from pmjac_pin.rates.partition import Partition, independent_rows
from pmjac_pin.studies.series_proof import ProvenPieces, SeriesProof, upwards
from pmjac_pin.studies.transmissions.newton_program import NewtonProgram
from pmjac_pin.studies.transmissions.sheet import Sheet
from pmjac_pin.studies.transmissions.sheet_equations import Pieces, SheetEquations
from pmjac_pin.values.arrays import Array, Index, Mask

_AT_ONCE = 512  # pieces
_MOST_PIECES, _MOST_HALVED = 20_000, 8  # in all, or for each cell
_ENTRIES = 8.0  # a motion of 1 changes an entry of q by more than 1 / 8: slides turn, too
_ALONE = 1e-4  # rad: how far at least no other pose is wanted
_NARROW = 0.25  # ‖E‖ beyond which bounds on rates are wide: pieces are halved for it
_SMALLEST = 0.25  # of a cell, to which they are


@dataclass(frozen=True, slots=True)
class SheetBounds:
    """Bounds on a sheet, all over its rectangle; `failed` says why nothing is proven.

    Attributes
    ----------
    error : ndarray, shape (k,)
        How far each follower of a `NewtonProgram` is from the sheet at most, m or rad.
    alone : ndarray, shape (nq,)
        No other closed pose has each entry of q nearer to the sheet than this.
    lower, upper : ndarray, shape (k, n)
        Bounds on their rates by those of the joints that drive.
    one_to_one : bool
        No two poses have the same values of the followers.
    pieces : int
        How many the proof took.
    left_out, left_out_gap : int, float
        Rows that depend on the others, and to what they hold, in their own units.
    failed : str
    """

    error: Array
    alone: Array
    lower: Array
    upper: Array
    one_to_one: bool = False
    pieces: int = 0
    left_out: int = 0
    left_out_gap: float = 0.0
    failed: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class _Proven:
    """What holds in each of b pieces."""

    good: Mask
    error: Array
    radius: Array
    ratio: Intervals
    gap: Array


def bounds_of(program: NewtonProgram, sheet: Sheet) -> SheetBounds:
    """Return what interval arithmetic proves of a sheet of closed poses."""
    count, n = program.followers.size, len(sheet.axes)
    nothing = (
        np.full(count, np.inf),
        np.zeros(program.q.size),
        np.full((count, n), -np.inf),
        np.full((count, n), np.inf),
    )
    partition = program.rates.partition
    if partition.idles:
        return SheetBounds(*nothing, failed="joints are left free by those that drive")
    try:
        equations = SheetEquations(program.mechanism, sheet)
    except ArgumentError as error:
        return SheetBounds(*nothing, failed=str(error))
    proof = _Proof(equations, partition, program.followers)
    try:
        found = _all_over(sheet, proof)
        widest = max(float(one.radius[one.good].max(initial=0.0)) for one in found)
        if min(float(one.radius[one.good].min(initial=np.inf)) for one in found) < widest:
            # Where one piece needs it, no other pose is wanted in any.
            proof.krawczyk.least_radius = widest
            found = _all_over(sheet, proof)
    except _TooLargeError as error:
        return SheetBounds(*nothing, failed=f"cells are too large for a proof, at {error}")
    return proof.together(found)


class _TooLargeError(Exception):
    """Pieces are too large for a proof however often they are halved; says where."""


def _all_over(sheet: Sheet, proof: _Proof) -> list[_Proven]:
    """Return what holds in the cells of a sheet, halved where they are too large."""
    waiting = [Pieces.whole([axis.size - 1 for axis in sheet.axes])]
    most = max(_MOST_PIECES, _MOST_HALVED * waiting[0].at.shape[1])
    found: list[_Proven] = []
    done = 0
    while waiting:
        pieces = waiting.pop()
        for start in range(0, pieces.at.shape[1], _AT_ONCE):
            part = pieces[slice(start, start + _AT_ONCE)]
            found.append(proof.of(part))
            done += part.at.shape[1]
            if not (good := found[-1].good).all():
                waiting.append(part[~good].split())
        if done + sum(one.at.shape[1] for one in waiting) > most:
            raise _TooLargeError(sheet_place(sheet, waiting[-1]))
    return found


def sheet_place(sheet: Sheet, pieces: Pieces) -> str:
    """Return the joint values in the middle of the first of some pieces, in words."""
    values = []
    for axis, cell, at in zip(sheet.axes, pieces.cells[:, 0], pieces.at[:, 0], strict=True):
        low, high = float(axis[cell]), float(axis[cell + 1])
        values.append(f"{0.5 * (low + high) + 0.5 * (high - low) * float(at):.4g}")
    return ", ".join(values)


class _Proof:
    """Krawczyk's test over pieces of a sheet."""

    def __init__(self, equations: SheetEquations, partition: Partition, followers: Index) -> None:
        self._equations, self._partition = equations, partition
        passive = partition.passive.tolist()
        self._followers = np.array([passive.index(k) for k in followers.tolist()], dtype=np.intp)
        self._kept = np.zeros(0, dtype=np.intp)
        turns = float(partition.column_scale[partition.passive].max(initial=0.0))
        self.krawczyk = SeriesProof(equations, partition, _ALONE / turns)

    def of(self, pieces: Pieces) -> _Proven:
        """Return what holds in some pieces."""
        along, count = self._equations.along(pieces), pieces.at.shape[1]
        passive = self._partition.passive
        if self._kept.size < self._partition.passive_rank:
            K, _ = self._equations.around(along, np.zeros(count))
            self._kept = self._independent(K.middle[0])
        found = self.krawczyk.of(along, count, self._kept, passive)
        ratio = self._ratio(found)
        narrow = (found.norm < _NARROW) | (pieces.half.max(axis=0) <= _SMALLEST)
        good = found.good & narrow & _regular(ratio)
        error = upwards((found.reach * self._partition.column_scale[passive])[:, self._followers])
        gap = self.krawczyk.gap(along, found, self._kept, passive)
        return _Proven(good, error, found.radius, ratio, gap)

    def together(self, found: list[_Proven]) -> SheetBounds:
        """Return what holds in all of them."""
        error = np.max([one.error[one.good].max(axis=0, initial=0.0) for one in found], axis=0)
        lower = np.min([one.ratio.lower[one.good].min(axis=0, initial=np.inf) for one in found], 0)
        upper = np.max([one.ratio.upper[one.good].max(axis=0, initial=-np.inf) for one in found], 0)
        gap = max(float(one.gap[one.good].max(initial=0.0)) for one in found)
        whole, pieces = Intervals(lower[None], upper[None]), sum(one.good.size for one in found)
        others = self._equations.rows - len(self._kept)
        radius = min(float(one.radius[one.good].min(initial=np.inf)) for one in found)
        alone = radius * self._equations.entry_scale() / _ENTRIES
        return SheetBounds(
            error, alone, lower, upper, bool(_regular(whole)[0]), pieces, others, gap
        )

    def _independent(self, K: Array) -> Index:
        """Return rows of K* that are independent at a pose."""
        bare: Array = K * np.outer(self._partition.row_scale, self._partition.column_scale)
        return independent_rows(bare[:, self._partition.passive], self._partition.passive_rank)

    def _ratio(self, found: ProvenPieces) -> Intervals:
        """Return the followers' rates (b, k, n) by those of the joints that drive."""
        driven, scale, Z = self._partition.actuated, self._partition.column_scale, found.norm
        rates = -self.krawczyk.square(found.jacobian, self._kept, driven).after(found.inverse)
        with np.errstate(divide="ignore", invalid="ignore"):
            more = upwards(np.where(Z < 1.0, Z / (1.0 - Z), np.inf))
        off = upwards(more[:, None] * rates.magnitude.max(axis=1))
        own = rates[:, self._followers].widened(off[:, None, :])
        columns = self._partition.passive[self._followers]
        return own * Intervals.exact(scale[columns][:, None]) / Intervals.exact(scale[driven])


def _regular(ratio: Intervals) -> Mask:
    """Tell which intervals of matrices (b, n, n) hold no singular one; n is 1 or 2."""
    if ratio.shape[-1] == 1:
        found = ratio[:, 0, 0]
    else:
        found = ratio[:, 0, 0] * ratio[:, 1, 1] - ratio[:, 0, 1] * ratio[:, 1, 0]
    return np.asarray((found.lower > 0.0) | (found.upper < 0.0))
