"""Tracing a curve of singular poses in a slice: a step along its tangent, and Newton back to it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from scipy.optimize import brentq

from pmjac_pin.studies.singularities.curve_equations import CurveEquations, SingularPoint
from pmjac_pin.studies.singularities.plane_slice import PlaneSlice
from pmjac_pin.values.arrays import Array, norm

End = Literal["closed", "window", "lost", "long"]

_FIRST_STEP, _LARGEST_STEP, _SMALLEST_STEP = 0.01, 0.1, 1e-6  # lengths or rad
_BEND = 0.12  # rad, between the tangents of two points that follow each other
_MOST_BEND = 0.3  # more may be another curve
_OFF = 0.15  # of a step: how far Newton may lead from its end
_LONGEST_CURVE = 20_000
_FOOT_STEPS = 8
_TURNING_ALONE = 1e-6  # of a tangent: what joints have of it at a pose at which u turns alone
_ZERO_TOLD = 1e-14  # of the way: where a number passes zero
_ON_CURVE = 1e-5  # of the way between two points that follow each other


class OnCurve(NamedTuple):
    """A point of a curve, the way on from there, and how regular it is.

    Attributes
    ----------
    point : SingularPoint
    tangent : ndarray, shape (nv + k,)
        Of unit length.
    regular : float
        The smallest singular value of what has the tangent as its null space: 0 where curves meet.
    """

    point: SingularPoint
    tangent: Array
    regular: float


@dataclass(frozen=True, eq=False)
class Traced:
    """A curve, as it was traced.

    Attributes
    ----------
    points : list of OnCurve
        In order, all tangents forward.
    ends : tuple of two {"closed", "window", "lost", "long"}
        At the first and at the last point.
    """

    points: list[OnCurve]
    ends: tuple[End, End]

    @cached_property
    def q(self) -> Array:
        """The poses of all points, shape (N, nq)."""
        return np.array([one.point.q for one in self.points])

    @property
    def is_closed(self) -> bool:
        """Whether it comes back to where it began."""
        return self.ends[0] == "closed"


class Tracer:
    """Traces curves of singular poses in a slice.

    Parameters
    ----------
    equations : SingularEquations
    area : PlaneSlice
        Of the same machine, whoever drives it.
    """

    def __init__(self, equations: CurveEquations, area: PlaneSlice) -> None:
        self.equations, self.area = equations, area
        self._nv = equations.partition.column_scale.size

    def on_curve(self, point: SingularPoint, forward: Array | None = None) -> OnCurve | None:
        """Return the way on from a singular point, None where more or less than one leads on."""
        _, jacobian = self.equations.bordered(point, self.area.held)
        _, values, right = np.linalg.svd(jacobian)
        rank = jacobian.shape[1] - 1
        if values.size > rank and values[rank] > 1e-6:
            return None
        tangent = right[-1]
        if forward is not None and tangent @ forward < 0.0:
            tangent = -tangent
        return OnCurve(point, tangent, float(values[rank - 1]))

    def corrected(self, point: SingularPoint, most: float) -> SingularPoint | None:
        """Return the singular point of the slice near another."""
        return self.equations.corrected(point, self.area.held, most)

    def between(self, first: OnCurve, second: OnCurve, share: float) -> SingularPoint | None:
        """Return the point of the curve that is such a share of the way from one to the next."""
        chord = self.chord(first.point, second.point)
        ahead = self.equations.moved(first.point, share * chord)
        return self.corrected(ahead, norm(chord))

    def zero_between(
        self, first: OnCurve, second: OnCurve, number: Callable[[SingularPoint], float]
    ) -> tuple[float, SingularPoint] | None:
        """Return the point of the curve, and its share of the way, where a number passes zero.

        None where its signs at the two points do not differ, or a point between is not found.
        """

        def at(share: float) -> float:
            point = self.between(first, second, share)
            return np.nan if point is None else number(point)

        try:
            share: float = brentq(at, 0.0, 1.0, xtol=_ZERO_TOLD)
        except ValueError:
            return None
        point = self.between(first, second, share)
        return None if point is None else (share, point)

    def chord(self, first: SingularPoint, second: SingularPoint) -> Array:
        """Return the step (nv + k,) that leads from one point to another, without full turns."""
        return np.concatenate([self.area.way(first.q, second.q), second.u - first.u])

    def trace(self, seed: SingularPoint) -> Traced | None:
        """Trace the curve through a singular point both ways; None where none leads through it.

        Nor is there one of poses where several motions come free at once, and u turns among them.
        """
        start = self.on_curve(seed)
        if start is None or norm(start.tangent[: self._nv]) <= _TURNING_ALONE:
            return None
        forward, end = self._onward(start)
        if end == "closed":
            return Traced([start, *forward], ("closed", "closed"))
        other = start._replace(tangent=-start.tangent)
        backward, begin = self._onward(other)
        turned = [one._replace(tangent=-one.tangent) for one in reversed(backward)]
        points = [*turned, start, *forward]
        return Traced(points, (begin, end)) if len(points) > 1 else None

    def _onward(self, start: OnCurve) -> tuple[list[OnCurve], End]:
        found: list[OnCurve] = []
        here, step = start, _FIRST_STEP
        while len(found) < _LONGEST_CURVE:
            ahead = self._step(here, step)
            if ahead is None:
                step *= 0.5
                if step < _SMALLEST_STEP:
                    return found, "lost"
                continue
            if not self.area.inside(self.area.places(ahead.point.q)):
                border = self._border(here, ahead)
                return [*found, *border], "window"
            if len(found) > 1 and self._passes(here, ahead, start):
                return [*found, start], "closed"
            found.append(ahead)
            bend = np.arccos(min(1.0, float(ahead.tangent @ here.tangent)))
            step = min(step * float(np.clip(_BEND / max(bend, 1e-9), 0.5, 2.0)), _LARGEST_STEP)
            here = ahead
        return found, "long"

    def _step(self, here: OnCurve, step: float) -> OnCurve | None:
        ahead = self.equations.moved(here.point, step * here.tangent)
        found = self.corrected(ahead, _OFF * step)
        if found is None or norm(self.chord(ahead, found)) > _OFF * step:
            return None
        found = self.equations.turned(found)
        reached = self.on_curve(found, here.tangent)
        if reached is None or reached.tangent @ here.tangent < np.cos(_MOST_BEND):
            return None
        return reached

    def _passes(self, here: OnCurve, ahead: OnCurve, start: OnCurve) -> bool:
        """Tell whether the start lies between two points that follow each other."""
        step = norm(self.chord(here.point, ahead.point)[: self._nv])
        if self.area.apart(here.point.q, start.point.q) > 1.5 * step:
            return False
        way = start.tangent[: self._nv] @ ahead.tangent[: self._nv]
        if way <= 0.0:
            return False
        lies = self.foot(here, ahead, start.point)
        return lies is not None and -1e-6 <= lies <= 1.0 + 1e-6

    def foot(self, first: OnCurve, second: OnCurve, point: SingularPoint) -> float | None:
        """Return at which share of the way between two points another lies, None if it does not."""
        chord = self.chord(first.point, second.point)[: self._nv]
        length, share, here = chord @ chord, 0.0, first.point
        for _ in range(_FOOT_STEPS):
            away = self.chord(here, point)[: self._nv]
            if away @ away <= (_ON_CURVE * _ON_CURVE) * length:
                return share
            share += float(away @ chord / length)
            there = self.between(first, second, share) if -0.5 <= share <= 1.5 else None
            if there is None:
                return None
            here = there
        return None

    def holds(self, curve: Traced, point: SingularPoint) -> bool:
        """Tell whether a singular point lies on a curve."""
        area = self.area
        places, place = area.places(curve.q), area.places(point.q)
        near = np.abs(places - place).max(axis=1) <= self._longest(places)
        apart = {k: area.apart(curve.q[k], point.q) for k in np.flatnonzero(near).tolist()}
        if not apart:
            return False
        nearest = min(apart, key=apart.__getitem__)
        if apart[nearest] <= 1e-9:
            return True
        chords = len(curve.points) - 1
        beside = [nearest - 1, nearest]
        if curve.is_closed:  # where it begins, it ends
            beside = [k % chords for k in beside]
        return any(
            self.foot(curve.points[k], curve.points[k + 1], point) is not None
            for k in beside
            if 0 <= k < chords
        )

    def _longest(self, places: Array) -> float:
        """Return the longest step between points of a curve in the plane, m or rad."""
        return float(np.abs(np.diff(places, axis=0)).max(initial=0.0)) + 1e-9

    def _border(self, here: OnCurve, ahead: OnCurve) -> Iterator[OnCurve]:
        """Yield the point where the curve leaves the window, unless it is there already."""
        area = self.area
        places = area.places(np.array([here.point.q, ahead.point.q]))
        shares = []
        for k in range(2):
            for side in (area.lower[k], area.upper[k]):
                before, after = places[:, k] - side
                leaves = after < 0.0 if side == area.lower[k] else after > 0.0
                if leaves and before != after:
                    share = before / (before - after)
                    if 0.0 <= share <= 1.0:
                        shares.append((share, k, side))
        if not shares:
            return
        share, k, side = min(shares)
        chord = self.chord(here.point, ahead.point)
        near = self.equations.moved(here.point, share * chord)
        column = area.columns[[k]]
        q = area.mechanism.coordinates.with_values(near.q, column, np.array([side]))
        held = np.append(area.held, column)
        found = self.equations.corrected(
            SingularPoint(q, near.u, near.idle), held, max(norm(chord), _FIRST_STEP)
        )
        if found is not None and share > 0.0:
            reached = self.on_curve(found, here.tangent)
            if reached is not None:
                yield reached
