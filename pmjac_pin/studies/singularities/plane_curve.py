"""PlaneCurve: a traced curve in its plane, a cubic over each chord between its points."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pmjac_pin.studies.singularities.curve_tracing import OnCurve, Traced, Tracer
from pmjac_pin.values.arrays import Array, Index

_FEET = 3  # Newton steps to the foot of a place on a cubic


def place_rate(tracer: Tracer, one: OnCurve) -> Array:
    """Return how the place changes along a curve, m or rad."""
    area, partition = tracer.area, tracer.equations.partition
    scale = partition.length * partition.column_scale[area.columns]
    return np.asarray(scale * one.tangent[area.columns])


def unit_ways(rows: Array) -> Array:
    """Return rows of unit length, those of zero as they are."""
    sizes = np.linalg.norm(rows, axis=-1, keepdims=True)
    return np.asarray(rows / np.where(sizes > 0.0, sizes, 1.0))


def wedge(first: Array, second: Array) -> float:
    """Return the area that two vectors of the plane span, positive to the left of the first."""
    return float(first[0] * second[1] - first[1] * second[0])


def arc_length(first: Array, second: Array, begin: Array, end: Array) -> float:
    """Return the length of the arc over a chord, as of a circle with these directions."""
    chord = float(np.linalg.norm(second - first))
    half = 0.5 * np.arccos(np.clip(begin @ end, -1.0, 1.0))
    return chord * float(half / np.sin(half)) if half > 1e-9 else chord


def cubic_at(ends: Array, ways: Array, share: float) -> tuple[Array, Array]:
    """Return place and rate at a share of a chord, of the cubic with these directions."""
    length, chord, s = arc_length(*ends, *ways), ends[1] - ends[0], share
    m, n = length * ways[0], length * ways[1]
    bend, turn = 3.0 * chord - 2.0 * m - n, m + n - 2.0 * chord
    place = ends[0] + s * (m + s * (bend + s * turn))
    return place, m + s * (2.0 * bend + 3.0 * s * turn)


def from_cubics(place: Array, places: Array, ways: Array, chords: Index | None = None) -> float:
    """Return how far a place is from the cubic over the nearest of some chords, or of all."""
    shares, away = _from_chords(place, places)
    k = int(np.argmin(away) if chords is None else chords[np.argmin(away[chords])])
    ends, its, share = places[k : k + 2], ways[k : k + 2], float(shares[k])
    for _ in range(_FEET):
        there, rate = cubic_at(ends, its, share)
        ahead = float((place - there) @ rate) / max(float(rate @ rate), 1e-300)
        share = float(np.clip(share + ahead, 0.0, 1.0))
    return float(np.linalg.norm(cubic_at(ends, its, share)[0] - place))


def _from_chords(place: Array, places: Array) -> tuple[Array, Array]:
    """Return shares of all chords that are nearest to a place, and how far, (N − 1,)."""
    first, chord = places[:-1], np.diff(places, axis=0)
    along = ((place - first) * chord).sum(axis=1) / np.maximum((chord**2).sum(axis=1), 1e-300)
    shares = np.clip(along, 0.0, 1.0)
    return shares, np.linalg.norm(first + shares[:, None] * chord - place, axis=1)


@dataclass(frozen=True, eq=False)
class PlaneCurve:
    """Where a curve is in the plane, in shares of the window.

    Attributes
    ----------
    tracer : Tracer
    traced : Traced
    """

    tracer: Tracer
    traced: Traced

    @cached_property
    def places(self) -> Array:
        """Of all points, shape (N, 2)."""
        area = self.tracer.area
        return np.asarray(area.places(self.traced.q) / area.size)

    @cached_property
    def ways(self) -> Array:
        """How the places change along the curve, of unit length, shape (N, 2)."""
        rates = [place_rate(self.tracer, one) for one in self.traced.points]
        return unit_ways(np.array(rates) / self.tracer.area.size)

    @cached_property
    def lengths(self) -> Array:
        """Of all chords, shape (N − 1,)."""
        return np.asarray(np.linalg.norm(np.diff(self.places, axis=0), axis=1))

    def is_smooth(self, k: int) -> bool:
        """Tell whether a chord has no turning back between its ends, and little bend."""
        chord = self.places[k + 1] - self.places[k]
        return bool(min(self.ways[k] @ chord, self.ways[k + 1] @ chord) > 0.8 * self.lengths[k])

    def smooth_about(self, k: int) -> tuple[int, int]:
        """Return the points before and after a chord at which smooth ones begin, or it itself."""
        last = len(self.lengths) - 1
        before = after = k
        while before > 0 and not self.is_smooth(before):
            before -= 1
        while after < last and not self.is_smooth(after):
            after += 1
        return before, after + 1

    def cubic(self, k: int, share: float) -> tuple[Array, Array]:
        """Return place and rate at a share of a chord."""
        return cubic_at(self.places[k : k + 2], self.ways[k : k + 2], share)

    def chords_about(self, k: int, count: int) -> Index:
        """Return the numbers of so many chords to both sides of one, over a closed curve's end."""
        near, last = np.arange(k - count, k + count + 1), len(self.lengths)
        return near % last if self.traced.is_closed else near[(near >= 0) & (near < last)]

    def from_chords(self, place: Array) -> tuple[Array, Array]:
        """Return shares of all chords that are nearest to a place, and how far, (N − 1,)."""
        return _from_chords(place, self.places)

    def distance(self, place: Array, chords: Index) -> float:
        """Return how far a place is from the cubic over the nearest of some chords."""
        return from_cubics(place, self.places, self.ways, chords)


@dataclass(frozen=True, slots=True, eq=False)
class CurveChord:
    """A chord of a curve.

    Attributes
    ----------
    curve : PlaneCurve
    number : int
    """

    curve: PlaneCurve
    number: int

    @property
    def ends(self) -> Sequence[OnCurve]:
        """The points where it begins and ends."""
        return self.curve.traced.points[self.number : self.number + 2]

    def at(self, share: float) -> OnCurve | None:
        """Return the point of the curve at a share of the chord, its tangent from end to end."""
        tracer, (first, second) = self.curve.tracer, self.ends
        point = tracer.between(first, second, share)
        if point is None:
            return None
        chord = tracer.chord(first.point, second.point)
        # Where curves meet there is more than one way on: that from end to end will do.
        return tracer.on_curve(point, chord) or OnCurve(point, chord, 0.0)

    def bend(self) -> float:
        """Return by how much the curve bends to the left from end to end, rad."""
        first, second = self.curve.ways[self.number : self.number + 2]
        return float(np.arctan2(wedge(first, second), first @ second))

    def place(self, one: OnCurve) -> Array:
        """Return where a point is, in shares of the window."""
        area = self.curve.tracer.area
        return np.asarray(area.places(one.point.q) / area.size)

    def way(self) -> Array:
        """Return the way in the plane from end to end."""
        first, second = self.curve.places[self.number : self.number + 2]
        return np.asarray(second - first)

    def rate(self, one: OnCurve) -> Array:
        """Return how the place changes with the share."""
        tracer = self.curve.tracer
        chord = tracer.chord(self.ends[0].point, self.ends[1].point)
        along = float(chord @ chord / (one.tangent @ chord))
        return place_rate(tracer, one) / tracer.area.size * along


def pairs_of_curves(
    tracers: Sequence[Tracer], curves: Sequence[Traced]
) -> Iterator[tuple[tuple[int, PlaneCurve], tuple[int, PlaneCurve]]]:
    """Yield each two curves with their indices, and each curve with itself."""
    drawn = [PlaneCurve(*pair) for pair in zip(tracers, curves, strict=True)]
    yield from itertools.combinations_with_replacement(enumerate(drawn), 2)
