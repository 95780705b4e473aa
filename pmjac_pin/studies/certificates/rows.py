"""Rows: blocks of loop equations enclosed at a pose, with a bound on their second derivative.

Where the equations of `loop_rows` hold a logarithm or a root, polynomials in the entries of the
rotations stand here that vanish at the same poses less than half a turn away;
`docs/certificates.md` derives each and its bound.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from flint import arb
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from pmjac_pin.kinematics.rows import Along, Distance, Gap, RightAngle, Rows, Tilt, Turn
from pmjac_pin.studies.certificates.chains import Pose
from pmjac_pin.studies.certificates.intervals import (
    ZERO,
    Intervals,
    cross,
    exactly,
    norm,
    rod_length,
    unit_rows,
    upper,
)
from pmjac_pin.studies.certificates.paths import Path

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Bend:
    """How much a block's rows can bend: |D²η[h, h]| for slides within a reach of the pose.

    Attributes
    ----------
    paths : tuple of Path
        Of the points whose difference the rows measure.
    turns : tuple of int
        Groups of which the rows measure the product of all turns; none for a gap.
    gap : float or None
        For a distance: of its ends, m.
    """

    paths: tuple[Path, ...] = ()
    turns: tuple[int, ...] = ()
    gap: float | None = None

    def bound(self, step: Array, unit: Array, length: float) -> Polynomial:
        """Return a bound on |D²η[h, h]| at all poses up to r units away, as polynomial in r.

        Parameters
        ----------
        step, unit : ndarray, shape (groups,)
            The norm of h in each group, and of one unit: rad or m.
        length : float
            How far a unit slides, m.
        """
        second, first, wide = (Polynomial([0.0]) for _ in range(3))
        for path in self.paths:
            M, c = (_linear(at, step.size, length) for at in (path.second, path.first))
            second += Polynomial([step @ entry @ step for entry in M])
            first += Polynomial([entry @ step for entry in c])
            wide += Polynomial([entry @ unit for entry in c])
        turning = sum(step[turn] for turn in self.turns)
        if self.gap is None:
            bent: Polynomial = second + turning**2
            return bent
        # |ṗ|² ≤ (c·h)², and |p| ≤ gap + r c·unit
        reach = Polynomial([self.gap]) + Polynomial([0.0, 1.0]) * wide
        bound: Polynomial = 2.0 * first**2 + 2.0 * reach * second
        return bound


@dataclass(frozen=True, slots=True, eq=False)
class Enclosed:
    """One block of rows at a pose.

    Attributes
    ----------
    residual, jacobian : Intervals, shapes (k,) and (k, unknowns)
    bend : Bend
    away : arb
        How far the two frames are from where the rows vanish, as a chord; beyond 2 may be a
        false zero, half a turn away.
    """

    residual: Intervals
    jacobian: Intervals
    bend: Bend
    away: arb = ZERO

    def away_within(self, radius: float) -> float:
        """Return the largest chord up to a radius from the pose."""
        return upper(self.away) + radius * len(self.bend.turns) if self.bend.turns else 0.0


def enclosed_rows(block: Rows, one: Pose, other: Pose, unknowns: int) -> Enclosed:
    """Enclose a block of rows between two frames that are seen from one body."""
    gap = one.origin() - other.origin()
    rates = _columns(one.linear, other.linear, unknowns)
    paths = (one.path(), other.path())
    match block:
        case Gap():
            return Enclosed(gap, rates, Bend(paths))
        case Distance():
            rod = rod_length(block.length)
            square = np.array([gap @ gap - rod * rod], dtype=object)
            return Enclosed(square, (2 * (gap @ rates))[None], Bend(paths, gap=upper(norm(gap))))
        case Along():
            turning = _columns({}, other.angular, unknowns)  # minus the second's
            axes = _carried(other, block.directions)
            residual = axes @ gap
            jacobian = axes @ rates + np.array([cross(gap, u) for u in axes]) @ turning
            return Enclosed(residual, jacobian, Bend((one.path_from(other),)))
    return _orientation(block, one, other, unknowns)


def _orientation(block: Rows, one: Pose, other: Pose, unknowns: int) -> Enclosed:
    bend = Bend(turns=(*one.turns, *other.turns))
    turning = _columns(one.angular, other.angular, unknowns)
    match block:
        case Turn():
            return _turn(one, other, unknowns, bend)
        case Tilt():
            axis = _carried(one, block.axis[None])[0]
            across = _carried(other, block.across)
            swing = np.array([cross(axis, u) for u in across], dtype=object)
            away = norm(axis - _carried(other, block.axis[None])[0])
            return Enclosed(across @ axis, swing @ turning, bend, away)
        case RightAngle():
            axis, normal = (
                _carried(pose, given[None])[0]
                for pose, given in ((one, block.first), (other, block.second))
            )
            cosine = np.array([axis @ normal], dtype=object)
            return Enclosed(cosine, (cross(axis, normal) @ turning)[None], bend)
    raise NotImplementedError(type(block).__name__)


def _turn(one: Pose, other: Pose, unknowns: int, bend: Bend) -> Enclosed:
    """Enclose η = ½ vee(Q − Qᵀ) with Q = R₁R₂ᵀ: sin(angle) times the axis.

    Mᵀ[ω] + [ω]M = [(tr M − M) ω] gives its derivative.
    """
    Q = one.axes() @ other.axes().T
    skew = (Q - Q.T) / 2
    residual = np.array([skew[2, 1], skew[0, 2], skew[1, 0]], dtype=object)
    trace = exactly(np.eye(3)) * Q.trace()
    first, second = _columns(one.angular, {}, unknowns), _columns({}, other.angular, unknowns)
    jacobian = np.asarray((trace - Q) @ first + (trace - Q.T) @ second, dtype=np.object_) / 2
    return Enclosed(residual, jacobian, bend, norm((Q - np.eye(3)).ravel()))


def _columns(plus: dict[int, Intervals], minus: dict[int, Intervals], unknowns: int) -> Intervals:
    """Return the rates of first less second, shape (3, unknowns)."""
    rates = np.full((3, unknowns), ZERO, dtype=object)
    for column, rate in plus.items():
        rates[:, column] = rate
    for column, rate in minus.items():
        rates[:, column] = -rate
    return rates


def _carried(pose: Pose, directions: Array) -> Intervals:
    """Return unit vectors that a frame carries, one a row, seen from the base."""
    carried: Intervals = unit_rows(directions) @ pose.axes().T
    return carried


def _linear(at: Callable[[int, float], Array], groups: int, length: float) -> tuple[Array, Array]:
    """Return the value of a function of the reach at 0, and its growth by a unit."""
    here = at(groups, 0.0)
    return here, at(groups, length) - here
