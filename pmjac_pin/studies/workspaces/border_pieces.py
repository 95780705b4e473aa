"""Pieces of curves between their corners and crossings, and the area that they enclose."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from pmjac_pin.studies.singularities.cubic_chain import CubicChain, unit_ways, wedge
from pmjac_pin.studies.singularities.curve_crossings import curve_crossings
from pmjac_pin.studies.singularities.curve_equations import SingularPoint
from pmjac_pin.studies.singularities.curve_tracing import OnCurve, Tracer
from pmjac_pin.studies.singularities.plane_curve import PlaneCurve, place_rate
from pmjac_pin.studies.workspaces.slanting_crossings import slanting_crossings
from pmjac_pin.values.arrays import Array

_NO_LENGTH = 1e-9  # of the window
_ONE_PLACE = 1e-6  # of the window: places that are one
_AS_LONG = 1e-2  # of a piece's length: by how much those differ that lie on each other
_SAMPLED = 12  # places of a piece, to see whether it lies on another
_OF_A_CUBIC = 1.0 / 192.0  # R θ⁴, twice what a cubic over an arc is off by
_TO_BOTH_SIDES = 2e-3  # of the window: to both sides of a piece
_ON_IT = 1e-8  # of the window: places on a curve, but for what cubics over it are off by
_OF_WHAT_IS_CLEAR = 0.3  # of what is between it and the next one


@dataclass(frozen=True, eq=False)
class SmoothPiece(CubicChain):
    """A smooth piece of a curve in the plane.

    At corners the ways are those of the piece's other end of the same chord.

    Attributes
    ----------
    what : str
        What keeps the tool within.
    """

    what: str

    @property
    def backwards(self) -> SmoothPiece:
        """The same, from its end to its beginning."""
        return replace(self, places=self.places[::-1], ways=-self.ways[::-1])

    @property
    def middle(self) -> tuple[Array, Array]:
        """A place within and the direction there."""
        place, rate = self.cubic((len(self.places) - 1) // 2, 0.5)
        return place, rate / np.linalg.norm(rate)

    def area(self) -> float:
        """Return ½ ∮ (x dy − y dx) along it: of each chord, and of what is beside it."""
        total = 0.0
        for k in range(len(self.places) - 1):
            (first, second), (m, n) = self.places[k : k + 2], self.rates(k)
            chord = second - first
            beside = (wedge(m, chord) + wedge(chord, n)) / 10.0 - wedge(m, n) / 60.0
            total += 0.5 * wedge(first, second) + beside
        return total


def pieces(curves: Sequence[PlaneCurve], names: Sequence[str]) -> Iterator[SmoothPiece]:
    """Yield the curves cut at their corners and where they cross.

    A corner is where the place turns back: two reasons to stop meet there.

    Parameters
    ----------
    curves : sequence of PlaneCurve
    names : sequence of str
        What each is.
    """
    cuts = [list(_corner_cuts(curve)) for curve in curves]
    for one in itertools.chain(curve_crossings(curves), slanting_crossings(curves)):
        for number, point in zip(one.curves, (one.first, one.second), strict=True):
            found = _placed(curves[number], point.q)
            if found is not None:
                cuts[number].append(found)
    for curve, where, name in zip(curves, cuts, names, strict=True):
        yield from _pieces_of(curve, where, name)


@dataclass(frozen=True, slots=True, eq=False)
class _CutPlace:
    """Where a curve is cut: after a point, at a share of the way to the next."""

    after: int
    share: float
    place: Array


def _corner_cuts(curve: PlaneCurve) -> Iterator[_CutPlace]:
    """Yield where the place turns back."""
    tracer, points = curve.tracer, curve.traced.points
    ways = [place_rate(tracer, one) for one in points]
    for k, (first, second) in enumerate(itertools.pairwise(points)):
        if ways[k] @ ways[k + 1] < 0.0:
            ahead = partial(_rate_along, tracer, first, ways[k])
            if (found := tracer.zero_between(first, second, ahead)) is not None:
                yield _CutPlace(k, found[0], tracer.area.places(found[1].q))


def _rate_along(tracer: Tracer, first: OnCurve, way: Array, point: SingularPoint) -> float:
    """Return how the place changes along a way, at a point beside another."""
    here = tracer.on_curve(point, first.tangent)
    return np.nan if here is None else float(place_rate(tracer, here) @ way)


def _placed(curve: PlaneCurve, q: Array) -> _CutPlace | None:
    """Return where on a curve a pose of it is."""
    area, poses = curve.tracer.area, curve.traced.q
    nearest = int(np.argmin([area.apart(other, q) for other in poses]))
    place = area.places(q)
    best: _CutPlace | None = None
    for k in (nearest - 1, nearest):
        if 0 <= k < len(poses) - 1:
            ends = area.places(poses[k : k + 2])
            chord = ends[1] - ends[0]
            share = float((place - ends[0]) @ chord / max(chord @ chord, 1e-300))
            if -1e-6 <= share <= 1.0 + 1e-6:
                best = _CutPlace(k, min(max(share, 0.0), 1.0), place)
    return best


def _pieces_of(curve: PlaneCurve, cuts: list[_CutPlace], name: str) -> Iterator[SmoothPiece]:
    """Yield the pieces of a curve; those of a closed one begin at its first cut."""
    tracer, traced = curve.tracer, curve.traced
    size = float(tracer.area.size.max())
    rates = np.array([place_rate(tracer, one) for one in traced.points])
    whole = CubicChain(tracer.area.places(traced.q), unit_ways(rates))
    order = sorted(cuts, key=lambda one: (one.after, one.share))
    last = len(whole.places) - 1
    if traced.is_closed and order:
        spans = [*itertools.pairwise(order), (order[-1], order[0])]
    else:
        begin, end = _CutPlace(0, 0.0, whole.places[0]), _CutPlace(last - 1, 1.0, whole.places[-1])
        spans = list(itertools.pairwise([begin, *order, end]))
    for number, (begin, end) in enumerate(spans):
        inner = np.arange(begin.after + 1, end.after + 1)
        if traced.is_closed and order and number == len(spans) - 1:  # over its start, once
            inner = np.concatenate([np.arange(begin.after + 1, last), np.arange(end.after + 1)])
        piece = _between_cuts(begin, end, whole.places[inner], whole.ways[inner], size)
        if piece is not None:
            yield SmoothPiece(*piece, name)
        elif not _is_at(end.place, begin.place, size):
            yield _within_chord(begin, end, whole, name)


def _between_cuts(
    begin: _CutPlace, end: _CutPlace, inner: Array, along: Array, size: float
) -> tuple[Array, Array] | None:
    """Return places and directions from one cut to another; None where no point is between."""
    off = [
        not (_is_at(place, begin.place, size) or _is_at(place, end.place, size)) for place in inner
    ]
    if not any(off):
        return None
    row = np.vstack([begin.place, inner[off], end.place])
    first = _first_way(row[1] - row[0], along[off][0])
    last = _first_way(row[-1] - row[-2], along[off][-1])
    return row, np.vstack([first, along[off], last])


def _is_at(place: Array, other: Array, size: float) -> bool:
    return bool(np.abs(place - other).max() <= _NO_LENGTH * size)


def _within_chord(begin: _CutPlace, end: _CutPlace, whole: CubicChain, name: str) -> SmoothPiece:
    """Return the piece between two cuts of one chord: on its cubic, where it does not turn back."""
    chord, k = end.place - begin.place, begin.after
    straight = chord / np.linalg.norm(chord)
    found = np.array([whole.cubic(k, cut.share)[1] for cut in (begin, end)])
    if whole.ways[k] @ whole.ways[k + 1] <= 0.0 or (found @ straight <= 0.0).any():
        found = np.array([straight, straight])
    return SmoothPiece(np.vstack([begin.place, end.place]), unit_ways(found), name)


def _first_way(chord: Array, way: Array) -> Array:
    """Return the direction at the other end of a chord: that of a circle with the way at this."""
    length = np.linalg.norm(chord)
    if not length > 0.0:
        return way
    chord = chord / length
    return np.asarray(2.0 * (way @ chord) * chord - way)


def border(
    found: Sequence[SmoothPiece], size: Array, reached: Callable[[Array], bool]
) -> tuple[SmoothPiece, ...]:
    """Return the pieces that have what is reached on one side alone, each once, it on their left.

    Parameters
    ----------
    found : sequence of SmoothPiece
    size : ndarray, shape (2,)
        Of the window.
    reached : callable
        place ↦ whether it is.
    """
    single: list[SmoothPiece] = []
    for piece in found:
        if not any(_lies_on(piece, other, size) for other in single):
            single.append(piece)
    kept: list[SmoothPiece] = []
    for piece in single:
        place, way = piece.middle
        # Nothing else is so near, but what lies on it: one side here is so all along the piece.
        away = [one.distance(place) for one in single if one is not piece]
        clear = min((one for one in away if one > _ON_IT * size.max()), default=np.inf)
        aside = min(_TO_BOTH_SIDES * float(size.max()), _OF_WHAT_IS_CLEAR * clear)
        left = aside * np.array([-way[1], way[0]])
        on_left, on_right = reached(place + left), reached(place - left)
        if on_left != on_right:
            kept.append(piece if on_left else piece.backwards)
    return tuple(kept)


def _lies_on(piece: SmoothPiece, other: SmoothPiece, size: Array) -> bool:
    """Tell whether two pieces are as long, and the one is all along the other."""
    length, its = (one.lengths.sum() for one in (piece, other))
    if abs(length - its) > _AS_LONG * max(length, its):
        return False
    along = piece.places[:: max(1, len(piece.places) // _SAMPLED)]
    off = _ONE_PLACE * float(size.max()) + max(_off_by(piece), _off_by(other))
    return all(other.distance(place) <= off for place in along)


def _off_by(piece: SmoothPiece) -> float:
    """Return how far cubics over a piece's chords may be from its curve, as of circles."""
    cosines = (piece.ways[1:] * piece.ways[:-1]).sum(axis=1)
    return float((piece.lengths * np.arccos(np.clip(cosines, -1.0, 1.0)) ** 3).max()) * _OF_A_CUBIC
