"""Paths: points of a curve led all the way, and what became of those that did not arrive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pmjac_pin.studies.homotopy.curve import Curve, machine_plane
from pmjac_pin.values.arrays import Complex, Mask

# A path is followed to a share 1 − 4⁻ᵏ of it, for one k after the other. It goes to infinity if it
# ends far away, or is lost while it grows by more than this from one stop to the next.
_STOPS = (*(1.0 - 0.25**k for k in range(1, 15)), 1.0)
_GROWING = 1.5
_NO_REAL_POSE = 1e4  # numbers of this size are not those of real poses
_EXACT_END = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class PathEnds:
    """Where paths ended.

    Attributes
    ----------
    points : ndarray, shape (m, n)
    arrived, to_infinity : ndarray of bool, shape (m,)
        Beyond 1e4 counts as infinity: no numbers of real poses are that large. All others are
        lost: they ended at a singular point, or tracking failed.
    """

    points: Complex
    arrived: Mask
    to_infinity: Mask

    @property
    def lost(self) -> int:
        """How many are lost."""
        return int((~self.arrived & ~self.to_infinity).sum())


def led(curve: Curve, points: Complex, start: Complex, end: Complex) -> PathEnds:
    """Lead points of a curve from planes to planes."""
    count, points, here = len(points), points.copy(), start
    going, growing = np.ones(count, dtype=bool), np.zeros(count, dtype=bool)
    size = np.abs(points).max(axis=1, initial=1.0)
    for stop in _STOPS:
        there = start + stop * (end - start)
        now = np.flatnonzero(going)
        points[now], arrived = curve.walk(points[now], here[now], there[now])
        before, size, here = size, np.abs(points).max(axis=1, initial=1.0), there
        going[now[~arrived]] = False
        growing[now[arrived]] = (size > _GROWING * before)[now[arrived]]
    infinite = np.where(going, size > _NO_REAL_POSE, growing)
    now = np.flatnonzero(going & ~infinite)
    points[now], last = curve.corrected(points[now], end[now], 3)
    going[now[last > _EXACT_END]] = False
    return PathEnds(points, going & ~infinite, infinite)


def led_to_end(curve: Curve, x: Complex) -> PathEnds:
    """Lead solutions (m, n) of the line's first machine to those of its last."""
    points = np.hstack([x, np.zeros((len(x), 1))])
    start, end = (machine_plane(t, curve.line.count, len(x)) for t in (0.0, 1.0))
    ends = led(curve, points, start, end)
    return PathEnds(ends.points[:, :-1], ends.arrived, ends.to_infinity)
