"""Rows: blocks of loop equations enclosed at a pose, with a bound on their second derivative.

The rows are the polynomial ones, which vanish at the same poses less than half a turn away;
`docs/certificates.md` derives the bound of each.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import assert_never

import numpy as np
from flint import arb
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from pmjac_pin.algebra.balls import ZERO, BallArray, norm, upper
from pmjac_pin.algebra.jets import Jets
from pmjac_pin.model.rows import Equations, Rows
from pmjac_pin.studies.certificates.chains import BALLS, Seen
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
    residual, jacobian : BallArray, shapes (k,) and (k, unknowns)
    bend : Bend
    away : arb
        How far the two frames are from where the rows vanish, as a chord; beyond 2 may be a
        false zero, half a turn away.
    """

    residual: BallArray
    jacobian: BallArray
    bend: Bend
    away: arb = ZERO

    def away_within(self, radius: float) -> float:
        """Return the largest chord up to a radius from the pose."""
        return upper(self.away) + radius * len(self.bend.turns) if self.bend.turns else 0.0


def enclosed_rows(block: Rows, one: Seen, other: Seen, places: Mapping[int, int]) -> Enclosed:
    """Enclose a block of rows between two frames that are seen from one body.

    `places` are those of the columns of v among the unknowns.
    """
    found = block.equations(Jets(BALLS), one.frame, other.frame)
    rows = found.rows
    jacobian = np.full((len(block.names), len(places)), ZERO, dtype=object)
    if rows.columns:
        jacobian[:, [places[column] for column in rows.columns]] = rows.rates[:, :, 0]
    return Enclosed(rows.value[:, 0, 0], jacobian, _bend(block, one, other), _away(found))


def _bend(block: Rows, one: Seen, other: Seen) -> Bend:
    match block.measures:
        case "gap":
            return Bend((one.path(), other.path()))
        case "distance":
            gap = one.points[-1] - other.points[-1]
            return Bend((one.path(), other.path()), gap=upper(norm(gap.ravel())))
        case "gap from second":
            return Bend((one.path_from(other),))
        case "turns":
            return Bend(turns=(*one.turns, *other.turns))
    assert_never(block.measures)


def _away(found: Equations) -> arb:
    """Return the chord 2 sin(α/2) between what the rows want to coincide."""
    if found.cosine is None:
        return ZERO
    square: arb = 2 - 2 * found.cosine.value[0, 0]
    chord: arb = square.nonnegative_part().sqrt()
    return chord


def _linear(at: Callable[[int, float], Array], groups: int, length: float) -> tuple[Array, Array]:
    """Return the value of a function of the reach at 0, and its growth by a unit."""
    here = at(groups, 0.0)
    return here, at(groups, length) - here
