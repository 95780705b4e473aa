"""Kantorovich: radii within which n equations in n unknowns have a solution, and only one.

Around a point, with an approximate inverse A of the derivative and the largest norm of a group of
unknowns as norm |·|, let

    Y ≥ |A F|,    Z₁ ≥ ‖I − A DF‖,    Z₂(r) ≥ ‖A D²F‖ up to r from the point.

Where p(r) = Y − (1 − Z₁) r + Z₂(r) r²/2 is not positive and Z₁ + Z₂(r) r < 1, x − A F(x) maps the
ball of radius r into itself and contracts there: it holds exactly one solution. Any other
solution at a distance s has p(s) ≥ 0. `docs/certificates.md` has the proof.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from pmjac_pin.algebra.balls import (
    OUTWARDS,
    BallArray,
    exactly,
    middles,
    norm,
    upper,
    uppers,
)

Array = NDArray[np.float64]
Index = NDArray[np.intp]

_BISECTIONS = 40
_FAR = 1e9  # a radius beyond which nothing is asked


@dataclass(frozen=True, slots=True, eq=False)
class System:
    """Equations in unknowns at a point.

    Attributes
    ----------
    residual, jacobian : BallArray, shapes (p,) and (p, n)
        F and DF.
    groups : sequence of sequence of int
        The unknowns of each group, whose Euclidean norms make the norm of all.
    blocks : ndarray of int, shape (p,)
        Which equations are bounded together.
    bends : sequence of Polynomial
        For each block, a bound on its second derivative over all unit steps, in the distance.
    """

    residual: BallArray
    jacobian: BallArray
    groups: Sequence[Sequence[int]]
    blocks: NDArray[np.intp]
    bends: Sequence[Polynomial]

    def part(self, rows: Index, columns: Index) -> System:
        """Return some of the equations in some of the unknowns, the others held."""
        place = {column: k for k, column in enumerate(columns.tolist())}
        return System(
            self.residual[rows],
            self.jacobian[np.ix_(rows, columns)],
            [[place[column] for column in group if column in place] for group in self.groups],
            self.blocks[rows],
            self.bends,
        )


@dataclass(frozen=True, slots=True)
class Radii:
    """What is proven of a system; `failed` names the inequality that did not hold."""

    existence: float
    uniqueness: float
    number: float
    failed: str = ""


def radii(system: System) -> Radii:
    """Return what Newton's method at the point proves of as many equations as unknowns."""
    if not system.residual.size:
        return Radii(0.0, math.inf, 0.0)
    try:
        A = np.asarray(np.linalg.inv(middles(system.jacobian)), dtype=np.float64)
    except np.linalg.LinAlgError:
        return _nothing("K* has no inverse: its determinant is zero")
    inverse = exactly(A)
    correction = inverse @ system.residual
    Y = max(upper(norm(correction[list(group)])) for group in system.groups if group)
    defect = exactly(np.eye(len(A))) - inverse @ system.jacobian
    Z1 = OUTWARDS * float(group_norms(uppers(defect), system.groups).sum(axis=1).max())
    if not Z1 < 1.0:
        return _nothing(f"‖I − A K*‖ < 1 does not hold: it may be up to {Z1:.3g}")
    return _solved(Y, Z1, _curvature(A, system))


def group_norms(sizes: Array, groups: Sequence[Sequence[int]]) -> Array:
    """Return Frobenius norms of the groups' blocks of a square matrix, rounded up."""
    marks = _marks(groups, len(sizes))
    norms: Array = OUTWARDS * np.sqrt(marks @ sizes**2 @ marks.T)
    return norms


def _marks(groups: Sequence[Sequence[int]], count: int) -> Array:
    """Return 1 where an unknown is in a group, shape (groups, count)."""
    marks = np.zeros((len(groups), count))
    for row, group in zip(marks, groups, strict=True):
        row[list(group)] = 1.0
    return marks


def _curvature(A: Array, system: System) -> Array:
    """Return the coefficients of Z₂ for each group of unknowns, shape (groups, degree + 1)."""
    used = np.unique(system.blocks).tolist()
    degree = max(system.bends[block].degree() for block in used)
    bends = np.zeros((len(used), degree + 1))
    for row, block in zip(bends, used, strict=True):
        row[: system.bends[block].degree() + 1] = system.bends[block].coef
    groups = _marks([group for group in system.groups if group], len(A))
    blocks = (system.blocks[:, None] == np.array(used)).astype(float)
    weights = np.sqrt(groups @ A**2 @ blocks)
    curvature: Array = OUTWARDS**2 * (weights @ bends)
    return curvature


def _solved(Y: float, Z1: float, curvature: Array) -> Radii:
    def Z2(radius: float) -> float:
        return OUTWARDS * float(np.polynomial.polynomial.polyval(radius, curvature.T).max())

    def p(radius: float) -> float:
        """Return Y + Z₁ r + Z₂(r) r²/2, which is to be at most r."""
        return OUTWARDS * (Y + Z1 * radius + 0.5 * Z2(radius) * radius**2)

    slope = 1.0 - Z1
    widest = 2.0 * Y / slope
    number = OUTWARDS**3 * 2.0 * Y * Z2(widest) / slope**2
    if not number < 1.0:
        return _nothing(
            f"h = 2 Y Z₂ / (1 − Z₁)² < 1 does not hold: h = {number:.3g} with Newton's step "
            f"Y = {Y:.3g}, the curvature Z₂ = {Z2(widest):.3g} per rad and Z₁ = {Z1:.3g}",
            number,
        )
    existence = (1.0 + 1e-6) * widest / (1.0 + math.sqrt(1.0 - number))
    if not (p(existence) <= existence and Z1 + Z2(existence) * existence < 1.0):
        return _nothing(
            f"Y + Z₁ r + Z₂ r²/2 ≤ r does not hold beyond rounding at r = {existence:.6g} "
            f"(h = {number:.6g})",
            number,
        )
    return Radii(existence, _uniqueness(p, existence), number)


def _uniqueness(p: Callable[[float], float], existence: float) -> float:
    """Return how far p(r) < r holds beyond the existence radius."""
    low, high = existence, max(2.0 * existence, 1e-12)
    while p(high) < high:
        low, high = high, 2.0 * high
        if high > _FAR:
            return math.inf
    for _ in range(_BISECTIONS):
        middle = math.sqrt(low * high) if low > 0.0 else 0.5 * high
        low, high = (middle, high) if p(middle) < middle else (low, middle)
    return low


def _nothing(failed: str, number: float = math.nan) -> Radii:
    return Radii(math.inf, 0.0, number, failed)
