"""Where curves cross that almost lie on each other: by the side of the one on which the other is.

Their chords cross anywhere, and Newton's method along both is led astray. How far the one is from
the other, to the left of it, changes its sign where they cross.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.optimize import brentq

from pmjac_pin.studies.singularities.cubic_chain import wedge
from pmjac_pin.studies.singularities.curve_crossings import Crossing
from pmjac_pin.studies.singularities.curve_tracing import OnCurve
from pmjac_pin.studies.singularities.plane_curve import CurveChord, PlaneCurve, pairs_of_curves
from pmjac_pin.values.arrays import Array, norm

_ALMOST_ON = 0.05  # of a chord: chords tell well enough where those cross that are farther apart
_BEYOND_CHORD = 0.5  # of a chord: cubics tell sides no better
_NEWTON_TO_FOOT = 4  # Newton steps to the foot of a place on a curve
_CLOSE = 1e-13  # of a chord
_SIDES_APART = 1e-9  # of the window: what is nearer all along lies on each other, but for rounding


def slanting_crossings(curves: Sequence[PlaneCurve]) -> Iterator[Crossing]:
    """Yield where two curves cross at a small angle."""
    for (i, one), (j, other) in pairs_of_curves(curves):
        if i == j:
            continue
        for k, m in _changing_sides(one, other):
            found = _crossing(CurveChord(one, k), CurveChord(other, m))
            if found is not None:
                first, second = (point.point for point in found)
                apart = one.tracer.area.apart(first.q, second.q)
                yield Crossing(first, second, (i, j), meets=apart == 0.0)


def _changing_sides(one: PlaneCurve, other: PlaneCurve) -> Iterator[tuple[int, int]]:
    """Yield chords of one curve from one side of the other to its other side, and of that."""
    sides = [_side(place, other) for place in one.places]
    for k in range(len(one.lengths)):
        (here, m), (there, _) = sides[k : k + 2]
        if max(abs(here), abs(there)) <= _ALMOST_ON * one.lengths[k] and here * there <= 0.0:
            yield k, m


def _side(place: Array, curve: PlaneCurve) -> tuple[float, int]:
    """Return how far a place is to the left of a curve, and which of its chords is nearest."""
    shares, away = curve.from_chords(place)
    m = int(np.argmin(away))
    if away[m] > curve.lengths[m]:
        return np.inf, m
    there, rate = curve.cubic(m, float(shares[m]))
    return wedge(rate, place - there) / norm(rate), m


def _crossing(mine: CurveChord, theirs: CurveChord) -> tuple[OnCurve, OnCurve] | None:
    """Return the points of two curves where the one comes to the other side of the other."""

    def side(share: float) -> float:
        found = _foot(mine, theirs, share)
        return np.nan if found is None else found[2]

    ends = -_BEYOND_CHORD, 1.0 + _BEYOND_CHORD
    before, after = (side(share) for share in ends)
    if not (before * after < 0.0 and min(abs(before), abs(after)) > _SIDES_APART):
        return None
    try:
        found = _foot(mine, theirs, brentq(side, *ends, xtol=_CLOSE))
    except ValueError:  # between there is no such point of the one curve or of the other
        return None
    return None if found is None else found[:2]


def _foot(
    mine: CurveChord, theirs: CurveChord, share: float
) -> tuple[OnCurve, OnCurve, float] | None:
    """Return a point of one curve, its foot on the other, and how far to the left of that it is."""
    one, other, along = mine.at(share), theirs.at(0.5), 0.5
    for _ in range(_NEWTON_TO_FOOT):
        if one is None or other is None:
            return None
        rate = theirs.rate(other)
        along += float((mine.place(one) - theirs.place(other)) @ rate / (rate @ rate))
        other = theirs.at(along)
    if one is None or other is None:
        return None
    rate = theirs.rate(other)
    return one, other, wedge(rate, mine.place(one) - theirs.place(other)) / norm(rate)
