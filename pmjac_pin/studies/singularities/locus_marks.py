"""What is special on curves of singular poses: cusps, and where curves cross in the plane."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from pmjac_pin.studies.singularities.curve_equations import SingularPoint
from pmjac_pin.studies.singularities.curve_tracing import OnCurve, Traced, Tracer
from pmjac_pin.studies.singularities.singular_equations import SingularEquations
from pmjac_pin.values.arrays import Array

_FALSE_POSITIONS = 60
_NEWTON_TO_CROSSING = 12  # of Newton, to where curves cross
_AT_ONE_PLACE = 1e-11  # of the window
_PARALLEL = 1e-4  # rad, in the window's proportions: curves that lie on each other do not cross
_ONE_POINT = 1e-5  # lengths or rad: where branches meet, Newton tells poses no better


class Crossing(NamedTuple):
    """Where two curves, or one and itself, are at one place of the plane."""

    first: SingularPoint
    second: SingularPoint
    curves: tuple[int, int]
    meets: bool


def cusps(tracer: Tracer, equations: SingularEquations, curve: Traced) -> Iterator[SingularPoint]:
    """Yield the poses of a curve of gain at which its image in motor space has a cusp."""
    curvatures, left = [], None
    for one in curve.points:
        curvature, left = _curvature(equations, one.point, left)
        curvatures.append(curvature)
    pairs = zip(curve.points, curve.points[1:], strict=False)
    for k, (first, second) in enumerate(pairs):
        if curvatures[k] * curvatures[k + 1] < 0.0:
            found = _cusp_between(tracer, equations, first, second)
            if found is not None:
                yield found


def _curvature(
    equations: SingularEquations, point: SingularPoint, left: Array | None
) -> tuple[float, Array]:
    """Return the fold's curvature, its w on the side of another's, and that w."""
    fold = equations.fold(point)
    turned = 1.0 if left is None or fold.left @ left >= 0.0 else -1.0
    return turned * fold.curvature, turned * fold.left


def _cusp_between(
    tracer: Tracer, equations: SingularEquations, first: OnCurve, second: OnCurve
) -> SingularPoint | None:
    """Return where the curvature passes zero, by the rule of false position (Illinois)."""
    start, left = _curvature(equations, first.point, None)
    low, high = (0.0, start), (1.0, _curvature(equations, second.point, left)[0])
    found, kept = None, 0
    for _ in range(_FALSE_POSITIONS):
        share = (low[0] * high[1] - high[0] * low[1]) / (high[1] - low[1])
        found = tracer.between(first, second, share)
        if found is None:
            return None
        value, _ = _curvature(equations, found, left)
        if abs(value) <= 1e-14 or high[0] - low[0] <= 1e-14:
            return found
        if value * low[1] < 0.0:
            high, kept, low = (share, value), 1, (low[0], low[1] * (0.5 if kept == 1 else 1.0))
        else:
            low, kept, high = (share, value), -1, (high[0], high[1] * (0.5 if kept == -1 else 1.0))
    return found


def curve_crossings(tracers: Sequence[Tracer], curves: Sequence[Traced]) -> Iterator[Crossing]:
    """Yield where curves cross in the plane; `meets` where they do in joint space as well.

    Not where they touch or lie on each other, as those of mirror images do.

    Parameters
    ----------
    tracers : sequence of Tracer
        Of each curve.
    curves : sequence of Traced
    """
    area = tracers[0].area if tracers else None
    if area is None:
        return
    places = [area.places(curve.q) for curve in curves]
    for i in range(len(curves)):
        for j in range(i, len(curves)):
            for k, m in _crossing_chords(places[i], places[j], same=i == j):
                ends = curves[i].points[k : k + 2], curves[j].points[m : m + 2]
                found = _refined(tracers[i], tracers[j], *ends)
                if found is not None:
                    first, second = found
                    meets = area.apart(first.q, second.q) <= _ONE_POINT
                    yield Crossing(first, second, (i, j), meets)


def _crossing_chords(first: Array, second: Array, *, same: bool) -> Iterator[tuple[int, int]]:
    """Yield the numbers of chords of two polylines that cross, each pair once."""
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
        yield from ((k, int(m)) for m in which[hit])


def _refined(
    mine: Tracer, theirs: Tracer, a: Sequence[OnCurve], b: Sequence[OnCurve]
) -> tuple[SingularPoint, SingularPoint] | None:
    """Return the two poses at which two curves are at one place, by Newton along both."""
    area, shares = mine.area, np.full(2, 0.5)
    for _ in range(_NEWTON_TO_CROSSING):
        one, other = (
            tracer.between(ends[0], ends[1], share)
            for tracer, ends, share in ((mine, a, shares[0]), (theirs, b, shares[1]))
        )
        if one is None or other is None:
            return None
        away = area.places(other.q) - area.places(one.q)
        if (np.abs(away) <= _AT_ONE_PLACE * area.size).all():
            return one, other
        along = np.column_stack([_place_rate(mine, a, one), -_place_rate(theirs, b, other)])
        sizes = np.linalg.norm(along / area.size[:, None], axis=0)
        if abs(np.linalg.det(along / area.size[:, None])) <= _PARALLEL * sizes[0] * sizes[1]:
            return None
        shares = np.clip(shares + np.linalg.solve(along, away), -0.5, 1.5)
    return None


def _place_rate(tracer: Tracer, ends: Sequence[OnCurve], here: SingularPoint) -> Array:
    """Return how the place changes with the share of the way between two points."""
    area, chord = tracer.area, tracer.chord(ends[0].point, ends[1].point)
    there = tracer.on_curve(here, chord)
    tangent = chord if there is None else there.tangent * (chord @ chord) / (there.tangent @ chord)
    partition = tracer.equations.partition
    return np.asarray(
        partition.length * partition.column_scale[area.columns] * tangent[area.columns]
    )
