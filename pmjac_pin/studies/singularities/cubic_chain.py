"""CubicChain: places in a plane with the ways on from there, and a cubic over each chord."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pmjac_pin.values.arrays import Array, Index

_FEET = 3  # Newton steps to the foot of a place on a cubic


def unit_ways(rows: Array) -> Array:
    """Return rows of unit length, those of zero as they are."""
    sizes = np.linalg.norm(rows, axis=-1, keepdims=True)
    return np.asarray(rows / np.where(sizes > 0.0, sizes, 1.0))


def wedge(first: Array, second: Array) -> float:
    """Return the area that two vectors of the plane span, positive to the left of the first."""
    return float(first[0] * second[1] - first[1] * second[0])


@dataclass(frozen=True, eq=False)
class CubicChain:
    """Places that follow each other.

    Attributes
    ----------
    places : ndarray, shape (N, 2)
    ways : ndarray, shape (N, 2)
        The directions on from there, of unit length.
    """

    places: Array
    ways: Array

    @cached_property
    def lengths(self) -> Array:
        """Of all chords, shape (N − 1,)."""
        return np.asarray(np.linalg.norm(np.diff(self.places, axis=0), axis=1))

    def rates(self, k: int) -> tuple[Array, Array]:
        """Return the rates by the share with which the cubic over a chord leaves and arrives.

        They are as long as the arc of a circle with these directions.
        """
        begin, end = self.ways[k : k + 2]
        half, length = 0.5 * np.arccos(np.clip(begin @ end, -1.0, 1.0)), float(self.lengths[k])
        if half > 1e-9:
            length *= float(half / np.sin(half))
        return length * begin, length * end

    def cubic(self, k: int, share: float) -> tuple[Array, Array]:
        """Return place and rate at a share of a chord."""
        first, second = self.places[k : k + 2]
        (m, n), chord, s = self.rates(k), second - first, share
        bend, turn = 3.0 * chord - 2.0 * m - n, m + n - 2.0 * chord
        place = first + s * (m + s * (bend + s * turn))
        return place, m + s * (2.0 * bend + 3.0 * s * turn)

    def from_chords(self, place: Array) -> tuple[Array, Array]:
        """Return shares of all chords that are nearest to a place, and how far, (N − 1,)."""
        first, chord = self.places[:-1], np.diff(self.places, axis=0)
        along = ((place - first) * chord).sum(axis=1) / np.maximum((chord**2).sum(axis=1), 1e-300)
        shares = np.clip(along, 0.0, 1.0)
        return shares, np.linalg.norm(first + shares[:, None] * chord - place, axis=1)

    def distance(self, place: Array, chords: Index | None = None) -> float:
        """Return how far a place is from the cubic over the nearest of some chords, or of all."""
        shares, away = self.from_chords(place)
        k = int(np.argmin(away) if chords is None else chords[np.argmin(away[chords])])
        share = float(shares[k])
        for _ in range(_FEET):
            there, rate = self.cubic(k, share)
            ahead = float((place - there) @ rate) / max(float(rate @ rate), 1e-300)
            share = float(np.clip(share + ahead, 0.0, 1.0))
        return float(np.linalg.norm(self.cubic(k, share)[0] - place))
