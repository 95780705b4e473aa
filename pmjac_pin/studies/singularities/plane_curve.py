"""PlaneCurve: a traced curve in its plane."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pmjac_pin.studies.singularities.cubic_chain import CubicChain, unit_ways, wedge
from pmjac_pin.studies.singularities.curve_tracing import OnCurve, Traced, Tracer
from pmjac_pin.values.arrays import Array, Index


def place_rate(tracer: Tracer, one: OnCurve) -> Array:
    """Return how the place changes along a curve, m or rad."""
    area, partition = tracer.area, tracer.equations.partition
    scale = partition.length * partition.column_scale[area.columns]
    return np.asarray(scale * one.tangent[area.columns])


@dataclass(frozen=True, eq=False)
class PlaneCurve(CubicChain):
    """Where a curve is in the plane, in shares of the window.

    Attributes
    ----------
    tracer : Tracer
    traced : Traced
    """

    tracer: Tracer
    traced: Traced

    @classmethod
    def of(cls, tracer: Tracer, traced: Traced) -> PlaneCurve:
        """Return that of a curve, as it was traced."""
        rates = np.array([place_rate(tracer, one) for one in traced.points])
        size = tracer.area.size
        return cls(tracer.area.places(traced.q) / size, unit_ways(rates / size), tracer, traced)

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

    def chords_about(self, k: int, count: int) -> Index:
        """Return the numbers of so many chords to both sides of one, over a closed curve's end."""
        near, last = np.arange(k - count, k + count + 1), len(self.lengths)
        return near % last if self.traced.is_closed else near[(near >= 0) & (near < last)]


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
    curves: Sequence[PlaneCurve],
) -> Iterator[tuple[tuple[int, PlaneCurve], tuple[int, PlaneCurve]]]:
    """Yield each two curves with their indices, and each curve with itself."""
    yield from itertools.combinations_with_replacement(enumerate(curves), 2)
