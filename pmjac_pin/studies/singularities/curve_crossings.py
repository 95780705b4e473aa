"""Where curves of a slice cross or touch in its plane: by cubics, then by Newton's method.

Curves may lie on each other for a while, as those of mirror images do. A pair of chords that cross
is looked at further only where the ends of the one are off the other's cubics.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from pmjac_pin.studies.singularities.cubic_chain import unit_ways, wedge
from pmjac_pin.studies.singularities.curve_equations import SingularPoint
from pmjac_pin.studies.singularities.curve_tracing import OnCurve
from pmjac_pin.studies.singularities.plane_curve import CurveChord, PlaneCurve, pairs_of_curves
from pmjac_pin.values.arrays import Array, Mask

_NEWTON = 12
_AT_ONE_PLACE = 1e-11  # of the window
_WHERE_BRANCHES_MEET = 1e-7  # of the window: by Newton's method, whose equations are singular there
_PARALLEL = 1e-4  # rad, in the window's proportions: curves that lie on each other do not cross
_ONE_POINT = 1e-5  # lengths or rad: where branches meet, Newton tells poses no better
_ON_A_CUBIC = 1e-3  # of a chord: what cubics over smooth chords tell no better
_NEAR_CHORDS = 0.3  # of a chord: between curves that may touch
_TOUCHING = 1e-8  # of the window: between places where curves touch
_ALONGSIDE = 0.3  # rad: between chords that may touch
_PARALLEL_AT_TOUCH = 1e-9  # rad, and of the window
_ABOUT = 6  # chords to both sides of one
_OVER_THE_END = 0.5  # of a chord: where Newton still counts as on it


class Crossing(NamedTuple):
    """Where two curves, or one and itself, are at one place of the plane."""

    first: SingularPoint
    second: SingularPoint
    curves: tuple[int, int]
    meets: bool


def curve_crossings(curves: Sequence[PlaneCurve]) -> Iterator[Crossing]:
    """Yield where curves cross in the plane; `meets` where they do in joint space as well."""
    for (i, one), (j, other) in pairs_of_curves(curves):
        for k, m, shares in _crossing_chords(one.places, other.places, same=i == j):
            if not _lies_along(one, k, other, m):
                found = _refined(CurveChord(one, k), CurveChord(other, m), shares)
                yield from _told_crossing(found, (i, j))


def curve_touchings(curves: Sequence[PlaneCurve]) -> Iterator[Crossing]:
    """Yield where curves touch in the plane: with one tangent, bent differently."""
    for (i, one), (j, other) in pairs_of_curves(curves):
        for k, m, shares in _chords_side_by_side(one, other):
            found = _touching(CurveChord(one, k), CurveChord(other, m), shares)
            yield from _told_crossing(found, (i, j))


def _told_crossing(
    found: tuple[SingularPoint, SingularPoint, float] | None, curves: tuple[int, int]
) -> Iterator[Crossing]:
    if found is not None:
        first, second, apart = found
        yield Crossing(first, second, curves, apart <= _ONE_POINT)


def _crossing_chords(
    first: Array, second: Array, *, same: bool
) -> Iterator[tuple[int, int, Array]]:
    """Yield the numbers of chords of two polylines that cross, each pair once, and where."""
    b, d = first[1:] - first[:-1], second[1:] - second[:-1]
    low, high = (f(second[:-1], second[1:]) for f in (np.minimum, np.maximum))
    for k in range(len(b)):
        ends = np.sort(first[k : k + 2], axis=0)
        near = ((low <= ends[1]) & (high >= ends[0])).all(axis=1)
        if same:
            near[: k + 2] = False
            near[-1] &= not (k == 0 and np.array_equal(first[0], first[-1]))
        which = np.flatnonzero(near)
        cross = b[k, 0] * d[which, 1] - b[k, 1] * d[which, 0]
        away = second[which] - first[k]
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (away[:, 0] * d[which, 1] - away[:, 1] * d[which, 0]) / cross
            t = (away[:, 0] * b[k, 1] - away[:, 1] * b[k, 0]) / cross
        hit = (s >= 0.0) & (s < 1.0) & (t >= 0.0) & (t < 1.0)
        for m in np.flatnonzero(hit):
            yield k, int(which[m]), np.array([s[m], t[m]])


def _lies_along(one: PlaneCurve, k: int, other: PlaneCurve, m: int) -> bool:
    """Tell whether a chord's ends are on the other curve about a chord, as far as cubics tell.

    Beside a cusp these tell nothing: then the ends of the smooth chords next to it do.
    """
    return all(_is_on(one, n, other, m) for n in one.smooth_about(k))


def _is_on(one: PlaneCurve, n: int, other: PlaneCurve, m: int) -> bool:
    """Tell whether a point is on the other curve about a chord, as far as cubics tell."""
    off = _ON_A_CUBIC * one.lengths[min(n, len(one.lengths) - 1)]
    return bool(other.distance(one.places[n], other.chords_about(m, _ABOUT)) <= off)


def _refined(
    mine: CurveChord, theirs: CurveChord, shares: Array
) -> tuple[SingularPoint, SingularPoint, float] | None:
    """Return the two poses at which two curves are at one place, by Newton along both.

    Where branches meet in one pose tangents are whatever rounding makes of them, and steps come no
    nearer than what Newton tells there: the nearest that they came to is taken for it, if the
    curves are across each other by their chords, too.
    """
    across = _are_across(mine, theirs)
    nearest, least = None, _WHERE_BRANCHES_MEET
    for _ in range(_NEWTON):
        one, other = mine.at(shares[0]), theirs.at(shares[1])
        if one is None or other is None:
            break
        away = theirs.place(other) - mine.place(one)
        along = np.column_stack([mine.rate(one), -theirs.rate(other)])
        parallel = abs(wedge(*unit_ways(along.T))) <= _PARALLEL
        if parallel and not across:
            return None
        if (gap := float(np.abs(away).max())) <= _AT_ONE_PLACE:
            return _both(mine, one, other)
        if gap <= least:
            nearest, least = _both(mine, one, other), gap
        if parallel:
            along = np.column_stack([mine.way(), -theirs.way()])
        shares = np.clip(shares + np.linalg.solve(along, away), -_OVER_THE_END, 1.0 + _OVER_THE_END)
    return nearest if across and nearest is not None and nearest[2] <= _ONE_POINT else None


def _are_across(mine: CurveChord, theirs: CurveChord) -> bool:
    """Tell whether two chords cross at more than both curves bend: these share no tangent."""
    sine = abs(wedge(*unit_ways(np.array([mine.way(), theirs.way()]))))
    return math.asin(min(1.0, sine)) > abs(mine.bend()) + abs(theirs.bend()) + _PARALLEL


def _both(
    mine: CurveChord, one: OnCurve, other: OnCurve
) -> tuple[SingularPoint, SingularPoint, float]:
    return one.point, other.point, mine.curve.tracer.area.apart(one.point.q, other.point.q)


def _chords_side_by_side(one: PlaneCurve, other: PlaneCurve) -> Iterator[tuple[int, int, Array]]:
    """Yield chords where two curves come near each other along one way, and shares of them."""
    away = np.stack([other.from_chords(place)[1] for place in one.places])
    if one is other:
        for k, row in enumerate(away):
            row[one.chords_about(k, _ABOUT)] = np.inf
            row[k:] = np.inf
    near = _least_around(away) & (away[:-1] <= _NEAR_CHORDS * one.lengths[:, None])
    for k, m in np.argwhere(near).tolist():
        if (
            one.is_smooth(k)
            and other.is_smooth(m)
            and abs(wedge(one.ways[k], other.ways[m])) <= _ALONGSIDE
            and not any(_is_on(one, n, other, m) for n in (k - 1, k + 1) if n >= 0)
        ):
            yield k, m, np.array([0.0, other.from_chords(one.places[k])[0][m]])


def _least_around(values: Array) -> Mask:
    """Tell which values (a, b), but those of the last row, are no more than the eight around."""
    padded = np.pad(values, 1, constant_values=np.inf)
    rows, columns = values.shape
    around = [
        padded[1 + i : 1 + i + rows, 1 + j : 1 + j + columns]
        for i in (-1, 0, 1)
        for j in (-1, 0, 1)
    ]
    return np.asarray(values <= np.min(around, axis=0))[:-1]


def _touching(
    mine: CurveChord, theirs: CurveChord, shares: Array
) -> tuple[SingularPoint, SingularPoint, float] | None:
    """Return the two poses at one place where two curves have one tangent.

    Newton's method on (tangents across each other, way from one to the other along them) with the
    bends of both chords; the distance between the curves is least there, to second order.
    """
    for _ in range(_NEWTON):
        one, other = mine.at(shares[0]), theirs.at(shares[1])
        if one is None or other is None:
            return None
        along = [mine.rate(one), theirs.rate(other)]
        (a, b), sizes = unit_ways(np.array(along)), np.linalg.norm(along, axis=1)
        b, turned = (b, 1.0) if a @ b > 0.0 else (-b, -1.0)
        gap = theirs.place(other) - mine.place(one)
        if abs(wedge(gap, a)) > _NEAR_CHORDS * sizes[0]:
            return None
        missing = np.array([wedge(a, b), gap @ a])
        if np.abs(missing).max() <= _PARALLEL_AT_TOUCH:
            return _both(mine, one, other) if abs(wedge(gap, a)) <= _TOUCHING else None
        bends = [mine.bend(), theirs.bend()]
        slopes = np.array([[-bends[0], bends[1]], [-sizes[0], turned * sizes[1]]])
        if abs(np.linalg.det(slopes)) <= _PARALLEL * float(np.max(sizes)):
            return None
        shares = shares - np.linalg.solve(slopes, missing)
        if np.abs(shares - 0.5).max() > 2.0:
            return None
    return None
