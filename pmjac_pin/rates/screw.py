"""Screws: a twist or a wrench as an axis in space with a pitch, and the principal ones of a system.

A twist (v, ω) turns about an axis and slides along it by the pitch; a wrench (f, m) is a force
along an axis and a moment about it. Both are a resultant (ω or f) and a moment (v or m), which
changes with the point where it is taken: m(a) = m(b) + (b − a) × resultant.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from pmjac_pin.rates.factorisation import RANK_TOLERANCE, factorise
from pmjac_pin.values.arrays import Array, ReadOnlyArrays, norm
from pmjac_pin.values.ties import LIKE, first_largest, pivots


@dataclass(frozen=True, eq=False)
class Screw(ReadOnlyArrays):
    """An axis in space with a pitch: what a twist or a wrench is but for its size.

    Attributes
    ----------
    direction : ndarray, shape (3,)
        Unit vector along the axis, world axes; its largest component is positive.
    point : ndarray, shape (3,)
        The point on the axis that is nearest to the tool's origin, m, in the world: the tool's
        origin itself where there is no axis.
    pitch : float
        m/rad of a twist, N m/N of a wrench; infinite for a translation or a pure moment.

    Examples
    --------
    A turn about the vertical through (1, 0, 0), seen from the world's origin:

    >>> import numpy as np
    >>> screw = Screw.of(np.array([0, 0, 1.0]), np.array([0, -1.0, 0]), np.zeros(3), 1.0)
    >>> screw.point.tolist(), screw.direction.tolist(), screw.pitch
    ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.0)
    """

    direction: Array
    point: Array
    pitch: float

    @classmethod
    def of(cls, resultant: Array, moment: Array, at: Array, length: float) -> Screw:
        """Return the screw of a resultant and its moment about a point.

        Parameters
        ----------
        resultant, moment, at : ndarray, shape (3,)
            ω and the velocity of `at`, or f and the moment about it; world axes.
        length : float
            Of the machine, m: a moment beside which resultant times this is nothing has no axis.
        """
        size = norm(resultant)
        if size * length <= RANK_TOLERANCE * norm(moment):
            return cls(_signed(moment / norm(moment)), at, np.inf)
        pitch = float(resultant @ moment) / size**2
        if abs(pitch) <= RANK_TOLERANCE * length:
            pitch = 0.0
        return cls(_signed(resultant / size), at + np.cross(resultant, moment) / size**2, pitch)

    def about(self, point: Array) -> tuple[Array, Array]:
        """Return resultant and moment about a point: of a twist ω (1 rad/s) and v of that point."""
        if np.isinf(self.pitch):
            return np.zeros(3), self.direction
        arm = np.cross(self.point - point, self.direction)
        return self.direction, self.pitch * self.direction + arm

    def twist(self, point: Array) -> Array:
        """Return (v, ω), shape (6,), linear rows first: v of the point that is at `point`."""
        omega, velocity = self.about(point)
        return np.concatenate([velocity, omega])

    def wrench(self, point: Array) -> Array:
        """Return (f, m), shape (6,), force first: the moment about `point`."""
        return np.concatenate(self.about(point))


def principal_screws(
    resultants: Array, moments: Array, at: Array, length: float
) -> tuple[Screw, ...]:
    """Return the principal screws of the system that some screws span.

    Those without an axis first, then those whose pitch is extremal: their axes are at right angles
    to each other. They depend on nothing but the system, and where pitches are equal, or there
    is more than one translation, on the axes of the world as well.

    Parameters
    ----------
    resultants, moments : ndarray, shape (3, k)
        Of k independent screws, about the point `at`.
    at : ndarray, shape (3,)
    length : float
        Of the machine, m.

    References
    ----------
    Ball, *A Treatise on the Theory of Screws*, 1900; Hunt, *Kinematic Geometry of Mechanisms*,
    1978, chapter 12.
    """
    factors = factorise(resultants * length, norm(np.vstack([resultants * length, moments])))
    rank = factors.rank
    free = settled_basis(moments @ factors.right[rank:].T)
    screws = [Screw.of(np.zeros(3), moment, at, length) for moment in free.T]
    axes = factors.left[:, :rank]
    about = moments @ factors.inverse(rank) * length @ axes
    about -= free @ (free.T @ about)
    pitches, turns = np.linalg.eigh(0.5 * (axes.T @ about + about.T @ axes))
    for alike in _equal_pitches(pitches, length):
        directions = settled_basis(axes @ turns[:, alike])
        screws += [Screw.of(d, about @ (axes.T @ d), at, length) for d in directions.T]
    return tuple(screws)


def settled_basis(columns: Array) -> Array:
    """Return an orthonormal basis of what independent columns span that rounding does not choose.

    Of projections of the axes, those that are longest: the same for each basis of the span.
    """
    if not columns.shape[1]:
        return columns
    span = np.linalg.qr(columns)[0]
    projections = span @ span.T
    basis = np.linalg.qr(projections[:, pivots(projections, span.shape[1])])[0]
    return np.column_stack([_signed(column) for column in basis.T])


def _equal_pitches(pitches: Array, length: float) -> list[slice]:
    """Return which pitches, ascending, are equal."""
    gap = (1.0 - LIKE) * length
    steps = np.flatnonzero(np.diff(pitches) > gap) + 1
    ends = [0, *steps.tolist(), pitches.size] if pitches.size else []
    return [slice(*pair) for pair in itertools.pairwise(ends)]


def _signed(vector: Array) -> Array:
    signed: Array = vector * np.sign(vector[first_largest(vector)]) + 0.0
    return signed
