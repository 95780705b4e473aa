"""Monodromy: all points of a curve in a plane, which of them hang together, and the trace test.

Moved round closed paths of planes, points change places with others of the same component of the
curve, and so lead to points not known yet. The sum of all points of a component, and of no smaller
part of it, moves along a straight line when the plane is shifted parallel to itself.

References
----------
.. [1] A. J. Sommese, J. Verschelde, C. W. Wampler: Symmetric functions applied to decomposing
   solution sets of polynomial systems. SIAM J. Numer. Anal. 40 (2002).
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from pmjac_pin.studies.homotopy.curve import Curve, distinct, place_of, same_plane
from pmjac_pin.studies.homotopy.machines import complex_normal
from pmjac_pin.values.arrays import Complex, Index

_log = logging.getLogger(__name__)

STRAIGHT = 1e-8  # what is left of the trace's bend, relative to its terms
_WALKERS_AT_ONCE = 64  # points that walk together: small sets go round several paths at a time
_MOST_PATHS = 8


@dataclass(frozen=True, slots=True, eq=False)
class PlaneSection:
    """Points of a curve in one plane.

    Attributes
    ----------
    curve : Curve
    plane : ndarray, shape (n + 1,)
        Normal and offset.
    points : ndarray, shape (m, n)
    links : ndarray, shape (k, 2)
        Pairs of points that a closed path led from one to the other.
    """

    curve: Curve
    plane: Complex
    points: Complex
    links: Index

    @classmethod
    def through(cls, curve: Curve, point: Complex, rng: np.random.Generator) -> PlaneSection:
        """Return the section with a random plane through one point."""
        normal = complex_normal(rng, curve.size)
        plane = np.append(normal, normal @ point)
        return cls(curve, plane, point[None], np.zeros((0, 2), int))

    def planes(self, shift: complex = 0.0, count: int | None = None) -> Complex:
        """Return the plane, or one parallel to it, for each of the points."""
        count = len(self.points) if count is None else count
        return same_plane(np.append(self.plane[:-1], self.plane[-1] + shift), count)

    def with_points(self, points: Complex) -> PlaneSection:
        """Return the section with further points of the curve in its plane."""
        return replace(self, points=distinct(points, self.points))

    def grown(self, rng: np.random.Generator) -> PlaneSection:
        """Lead the points round closed paths of planes; return them with those they became."""
        count = len(self.points)
        paths = max(1, min(_MOST_PATHS, _WALKERS_AT_ONCE // count))
        origin = np.tile(np.arange(count), paths)
        here = self.planes(count=origin.size)
        away, back = _closed_path(here, count, rng)
        moved, left = self.curve.walk(self.points[origin], here, away)
        moved, returned = self.curve.walk(moved[left], away[left], back[left])
        return self._linked(moved[returned], origin[left][returned])

    def components(self) -> Index:
        """Return for each point the number of the set of linked points it is in."""
        count = len(self.points)
        pairs = (np.ones(len(self.links)), (self.links[:, 0], self.links[:, 1]))
        _, labels = connected_components(coo_array(pairs, shape=(count, count)), directed=False)
        return np.asarray(labels, dtype=np.intp)

    def bends(self, labels: Index, shift: complex = 1.0) -> list[float]:
        """Return, of each set, the trace's second difference over planes one and two shifts off.

        It is relative to the trace's terms; infinite where a path was lost.
        """
        count = len(self.points)
        starts = np.vstack([self.points, self.points])
        ends = np.vstack([self.planes(steps * shift) for steps in (1.0, 2.0)])
        moved, arrived = self.curve.walk(starts, self.planes(count=2 * count), ends)
        second = self.points - 2.0 * moved[:count] + moved[count:]
        lost = ~(arrived[:count] & arrived[count:])
        bends = []
        for label in range(labels.max(initial=-1) + 1):
            own = labels == label
            terms = np.abs(self.points[own]).sum(axis=0).max() or 1.0
            bend = np.abs(second[own].sum(axis=0)).max() / terms
            bends.append(np.inf if lost[own].any() else float(bend))
        return bends

    def _linked(self, moved: Complex, origin: Index) -> PlaneSection:
        points = distinct(moved, self.points)
        links = [self.links]
        for point, first in zip(moved, origin, strict=True):
            if (place := place_of(point, points)) is not None:
                links.append(np.array([[first, place]]))
        return replace(self, points=points, links=np.unique(np.vstack(links), axis=0))


def all_points(
    curve: Curve, point: Complex, rng: np.random.Generator, most_rounds: int
) -> tuple[PlaneSection, float]:
    """Return all points of an irreducible curve in a plane through one, and the trace's bend."""

    def one_set(section: PlaneSection) -> Index:
        return np.zeros(len(section.points), dtype=np.intp)

    first = PlaneSection.through(curve, point, rng)
    section, _, bends = grown_whole(first, one_set, rng, most_rounds)
    return section, bends[0]


def grown_whole(
    section: PlaneSection,
    sets: Callable[[PlaneSection], Index],
    rng: np.random.Generator,
    most_rounds: int,
) -> tuple[PlaneSection, Index, list[float]]:
    """Return a section that grows until its sets stay and their traces are straight.

    With it for each point the number of its set, and of each set the trace's bend.
    """
    labels = sets(section)
    bends = [np.inf] * len(labels)
    for _ in range(most_rounds):
        before = len(section.points), labels.max(initial=0)
        section = section.grown(rng)
        labels = sets(section)
        _log.info("monodromy: %d points", len(section.points))
        if (len(section.points), labels.max(initial=0)) == before:
            bends = section.bends(labels, random_turn(rng))
            if max(bends) < STRAIGHT:
                break
    return section, labels, bends


def random_turn(rng: np.random.Generator) -> complex:
    """Return a random complex number of size 1."""
    return complex(np.exp(2j * np.pi * rng.uniform()))


def _closed_path(here: Complex, count: int, rng: np.random.Generator) -> tuple[Complex, Complex]:
    """Return a random plane for each path of `count` points, and the first plane again.

    Its numbers come back times a complex factor, which makes the way back another one.
    """
    paths, size = len(here) // count, here.shape[1] - 1
    factor, normals, offsets = (
        np.repeat(complex_normal(rng, paths, numbers), count, axis=0) for numbers in (1, size, 1)
    )
    return np.hstack([normals, offsets]), factor * here
