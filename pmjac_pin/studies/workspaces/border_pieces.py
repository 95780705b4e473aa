"""Pieces of curves between their corners and crossings, and the area that they enclose."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pmjac_pin.studies.singularities.curve_crossings import curve_crossings
from pmjac_pin.studies.singularities.curve_tracing import OnCurve, Traced, Tracer
from pmjac_pin.studies.singularities.plane_curve import (
    arc_length,
    cubic_at,
    from_cubics,
    place_rate,
    unit_ways,
    wedge,
)
from pmjac_pin.studies.workspaces.slanting_crossings import slanting_crossings
from pmjac_pin.values.arrays import Array

_TURNING_STEPS = 80
_NO_LENGTH = 1e-9  # of the window
_ONE_PLACE = 1e-6  # of the window: places that are one
_AS_LONG = 1e-2  # of a piece's length: by how much those differ that lie on each other
_SAMPLED = 12  # places of a piece, to see whether it lies on another
_OF_A_CUBIC = 1.0 / 192.0  # R θ⁴, twice what a cubic over an arc is off by
_TO_BOTH_SIDES = 2e-3  # of the window: to both sides of a piece
_ON_IT = 1e-8  # of the window: places on a curve, but for what cubics over it are off by
_OF_WHAT_IS_CLEAR = 0.3  # of what is between it and the next one


@dataclass(frozen=True, slots=True, eq=False)
class SmoothPiece:
    """A smooth piece of a curve in the plane.

    Attributes
    ----------
    places, directions : ndarray, shape (N, 2)
        Directions of unit length; at corners those of the piece's other end of the same chord.
    what : str
        What keeps the tool within.
    """

    places: Array
    directions: Array
    what: str

    @property
    def backwards(self) -> SmoothPiece:
        """The same, from its end to its beginning."""
        return replace(self, places=self.places[::-1], directions=-self.directions[::-1])

    @property
    def middle(self) -> tuple[Array, Array]:
        """A place within and the direction there."""
        k = (len(self.places) - 1) // 2
        place, rate = cubic_at(self.places[k : k + 2], self.directions[k : k + 2], 0.5)
        return place, rate / np.linalg.norm(rate)

    def area(self) -> float:
        """Return ½ ∮ (x dy − y dx) along it, by a cubic over each chord."""
        total = 0.0
        for k in range(len(self.places) - 1):
            total += _swept(*self.places[k : k + 2], *self.directions[k : k + 2])
        return total


def pieces(
    tracers: Sequence[Tracer], curves: Sequence[Traced], names: Sequence[str]
) -> Iterator[SmoothPiece]:
    """Yield the curves cut at their corners and where they cross.

    A corner is where the place turns back: two reasons to stop meet there.

    Parameters
    ----------
    tracers, curves : sequences
        Of each curve.
    names : sequence of str
        What each is.
    """
    cuts = [list(_corner_cuts(*pair)) for pair in zip(tracers, curves, strict=True)]
    both = curve_crossings(tracers, curves), slanting_crossings(tracers, curves)
    for one in itertools.chain(*both):
        for number, point in zip(one.curves, (one.first, one.second), strict=True):
            found = _placed(tracers[number], curves[number], point.q)
            if found is not None:
                cuts[number].append(found)
    for tracer, curve, where, name in zip(tracers, curves, cuts, names, strict=True):
        yield from _pieces_of(tracer, curve, where, name)


@dataclass(frozen=True, slots=True, eq=False)
class _CutPlace:
    """Where a curve is cut: after a point, at a share of the way to the next."""

    after: int
    share: float
    place: Array


def _corner_cuts(tracer: Tracer, curve: Traced) -> Iterator[_CutPlace]:
    """Yield where the place turns back."""
    ways = [place_rate(tracer, one) for one in curve.points]
    for k, (first, second) in enumerate(zip(curve.points, curve.points[1:], strict=False)):
        if ways[k] @ ways[k + 1] < 0.0:
            found = _turning(tracer, first, second, ways[k])
            if found is not None:
                yield _CutPlace(k, *found)


def _turning(
    tracer: Tracer, first: OnCurve, second: OnCurve, way: Array
) -> tuple[float, Array] | None:
    """Return the share of the chord at which the place turns back, and the place there."""
    low, high, found = 0.0, 1.0, None
    for _ in range(_TURNING_STEPS):
        share = 0.5 * (low + high)
        point = tracer.between(first, second, share)
        here = None if point is None else tracer.on_curve(point, first.tangent)
        if here is None or point is None:
            return found
        found = share, tracer.area.places(point.q)
        low, high = (share, high) if place_rate(tracer, here) @ way > 0.0 else (low, share)
        if high - low < 1e-9:
            break
    return found


def _placed(tracer: Tracer, curve: Traced, q: Array) -> _CutPlace | None:
    """Return where on a curve a pose of it is."""
    apart = [tracer.area.apart(other, q) for other in curve.q]
    nearest = int(np.argmin(apart))
    place = tracer.area.places(q)
    best: _CutPlace | None = None
    for k in (nearest - 1, nearest):
        if 0 <= k < len(curve.points) - 1:
            ends = tracer.area.places(curve.q[k : k + 2])
            chord = ends[1] - ends[0]
            share = float((place - ends[0]) @ chord / max(chord @ chord, 1e-300))
            if -1e-6 <= share <= 1.0 + 1e-6:
                best = _CutPlace(k, min(max(share, 0.0), 1.0), place)
    return best


def _pieces_of(
    tracer: Tracer, curve: Traced, cuts: list[_CutPlace], name: str
) -> Iterator[SmoothPiece]:
    """Yield the pieces of a curve; those of a closed one begin at its first cut."""
    places = tracer.area.places(curve.q)
    ways = unit_ways(np.array([place_rate(tracer, one) for one in curve.points]))
    order = sorted(cuts, key=lambda one: (one.after, one.share))
    last = len(places) - 1
    if curve.is_closed and order:
        spans = [*itertools.pairwise(order), (order[-1], order[0])]
    else:
        ends = [_CutPlace(0, 0.0, places[0]), *order, _CutPlace(last - 1, 1.0, places[-1])]
        spans = list(itertools.pairwise(ends))
    for number, (begin, end) in enumerate(spans):
        inner = np.arange(begin.after + 1, end.after + 1)
        if curve.is_closed and order and number == len(spans) - 1:  # over its start, once
            inner = np.concatenate([np.arange(begin.after + 1, last), np.arange(end.after + 1)])
        piece = _between_cuts(begin, end, places[inner], ways[inner], tracer.area.size.max())
        if piece is not None:
            yield SmoothPiece(*piece, name)
        elif not _is_at(end.place, begin.place, tracer.area.size.max()):
            ends_of = slice(begin.after, begin.after + 2)
            yield _within_chord(begin, end, places[ends_of], ways[ends_of], name)


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


def _within_chord(
    begin: _CutPlace, end: _CutPlace, places: Array, ways: Array, name: str
) -> SmoothPiece:
    """Return the piece between two cuts of one chord: on its cubic, where it does not turn back."""
    chord = end.place - begin.place
    straight = chord / np.linalg.norm(chord)
    found = np.array([cubic_at(places, ways, cut.share)[1] for cut in (begin, end)])
    if ways[0] @ ways[1] <= 0.0 or (found @ straight <= 0.0).any():
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
        away = [_from_piece(place, one) for one in single if one is not piece]
        clear = min((one for one in away if one > _ON_IT * size.max()), default=np.inf)
        aside = min(_TO_BOTH_SIDES * float(size.max()), _OF_WHAT_IS_CLEAR * clear)
        left = aside * np.array([-way[1], way[0]])
        on_left, on_right = reached(place + left), reached(place - left)
        if on_left != on_right:
            kept.append(piece if on_left else piece.backwards)
    return tuple(kept)


def _lies_on(piece: SmoothPiece, other: SmoothPiece, size: Array) -> bool:
    """Tell whether two pieces are as long, and the one is all along the other."""
    length, its = (np.linalg.norm(np.diff(p.places, axis=0), axis=1).sum() for p in (piece, other))
    if abs(length - its) > _AS_LONG * max(length, its):
        return False
    along = piece.places[:: max(1, len(piece.places) // _SAMPLED)]
    off = _ONE_PLACE * float(size.max()) + max(_off_by(piece), _off_by(other))
    return all(_from_piece(place, other) <= off for place in along)


def _off_by(piece: SmoothPiece) -> float:
    """Return how far cubics over a piece's chords may be from its curve, as of circles."""
    chords = np.linalg.norm(np.diff(piece.places, axis=0), axis=1)
    cosines = (piece.directions[1:] * piece.directions[:-1]).sum(axis=1)
    return float((chords * np.arccos(np.clip(cosines, -1.0, 1.0)) ** 3).max()) * _OF_A_CUBIC


def _from_piece(place: Array, piece: SmoothPiece) -> float:
    """Return how far a place is from a piece."""
    return from_cubics(place, piece.places, piece.directions)


def _swept(first: Array, second: Array, begin: Array, end: Array) -> float:
    """Return ½ ∫ (x dy − y dx) along a cubic: the chord's, and what is beside it."""
    length = arc_length(first, second, begin, end)
    m0, m1, chord = length * begin, length * end, second - first
    beside = (wedge(m0, chord) + wedge(chord, m1)) / 10.0 - wedge(m0, m1) / 60.0
    return 0.5 * wedge(first, second) + beside
