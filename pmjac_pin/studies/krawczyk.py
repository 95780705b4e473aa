"""Krawczyk's test: where equations have exactly one solution, over boxes or over balls.

With an approximate inverse A of the derivative J, of which nothing is asked, all solutions in X are

    in K(X) = m − A F(m) + (I − A J(X)) (X − m),    m ∈ X,

and where K(X) is in the interior of X, there is exactly one. For boxes that is asked of each
unknown. For balls about m = 0 it is asked in the largest norm of groups of unknowns: let

    Y ≥ |A F(0)|,    Z(r) ≥ ‖I − A J(x)‖ for all |x| ≤ r,    N(r) ≥ ‖A J(x)‖ there,

and M(r) the mean of Z from 0 to r. Where Y + M(r) r ≤ r, x − A F(x) maps the ball of radius r into
itself, so that it holds a solution; where moreover Z(r) + N(r) r/2 < 1, only one. All solutions
up to u away are within Y / (1 − M(u)).
`docs/certificates.md` has the proof.

Source: R. Krawczyk, Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken,
Computing 4 (1969); R. E. Moore, A test for existence of solutions, SIAM J. Numer. Anal. 14 (1977).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pmjac_pin.algebra.balls import OUTWARDS, BallArray, euclidean_norm, exactly, upper
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.values.arrays import Array, Index

#: The point itself, and the radii that are tried, rad: a factor of 4 apart, then of √2.
RADII = np.concatenate(
    [[0.0], 4.0 ** np.arange(-22.0, -5.0), 2.0 ** np.arange(-10.0, 2.0, 0.5), [np.inf]]
)


def contraction(inverse: Array, jacobian: Intervals) -> Intervals:
    """Return I − A J(X), shape (..., n, n): its size bounds by how much x − A F(x) contracts.

    Parameters
    ----------
    inverse : ndarray, shape (..., n, n)
        A.
    jacobian : Intervals, shape (..., n, n)
        ∂F/∂x over X.
    """
    return Intervals.exact(np.eye(jacobian.shape[-1])) - jacobian.after(inverse)


def image_of_boxes(
    inverse: Array, residual: Intervals, jacobian: Intervals, at: Array, boxes: Intervals
) -> Intervals:
    """Return K(X) of each box (..., n) about a point m in it; infinite where the point is not.

    Parameters
    ----------
    inverse : ndarray, shape (..., n, n)
        A.
    residual : Intervals, shape (..., n)
        F(m).
    jacobian : Intervals, shape (..., n, n)
        ∂F/∂x over X.
    at : ndarray, shape (..., n)
        m.
    boxes : Intervals, shape (..., n)
        X.
    """
    middle = Intervals.exact(at)
    spread = (contraction(inverse, jacobian) * (boxes - middle)[..., None, :]).sum(axis=-1)
    image = middle - residual[..., None].after(inverse)[..., 0] + spread
    inside = np.asarray(boxes.holds(at).all(axis=-1, keepdims=True))
    return Intervals(np.where(inside, image.lower, -np.inf), np.where(inside, image.upper, np.inf))


@dataclass(frozen=True, slots=True)
class Radii:
    """What is proven of a system; `failed` says which inequality did not hold.

    Attributes
    ----------
    existence, uniqueness : float
    ball : int
        Which of the tried radii holds the solution.
    """

    existence: float
    uniqueness: float
    ball: int = 0
    failed: str = ""


def radii(
    residual: BallArray,
    jacobian: Intervals,
    columns: Index,
    groups: Array,
    tried: Array = RADII,
) -> Radii:
    """Return what Krawczyk's test proves of as many equations as unknowns.

    Parameters
    ----------
    residual : BallArray, shape (n,)
        F at the point.
    jacobian : Intervals, shape (b, n, m)
        J, by all unknowns, up to each radius.
    columns : ndarray of int, shape (n,)
        The unknowns; the others are held.
    groups : ndarray, shape (g, m)
        1 for each unknown of a group, whose Euclidean norms make the norm of all.
    tried : ndarray, shape (b,)
        Radii, the first of them 0.
    """
    if not residual.size:
        return Radii(0.0, math.inf)
    own = jacobian[:, :, columns]
    try:
        inverse = np.asarray(np.linalg.inv(own.middle[0]), dtype=np.float64)
    except np.linalg.LinAlgError:
        return _nothing("K* has no inverse: its determinant is zero")
    some = groups[:, columns]
    correction = exactly(inverse) @ residual
    Y = max(upper(euclidean_norm(correction[row > 0.0])) for row in some if row.any())
    Z = norms_of(contraction(inverse, own), some, some)
    N = norms_of(jacobian.after(inverse), some, groups)
    return _tested(Y, Z, N, tried)


def _tested(Y: float, Z: Array, N: Array, tried: Array) -> Radii:
    if not Z[0] < 1.0:
        return _nothing(f"‖I − A K*‖ < 1 does not hold: it may be up to {Z[0]:.3g}")
    M = _means(Z, tried)
    # Where M is not a number, nothing holds.
    reach = OUTWARDS * Y / np.where(M < 1.0, (1.0 - M) / OUTWARDS, np.nan)
    holds = (reach <= tried) & (OUTWARDS * (Z + 0.5 * N * np.where(N > 0.0, tried, 0.0)) < 1.0)
    holds[0] = False
    if not holds.any():
        return _nothing(_why(Y, M, tried))
    inner = np.flatnonzero(holds)
    # Up to the uniqueness radius, all solutions are in a ball that holds only one.
    outer = int(np.flatnonzero(reach <= tried[inner[-1]])[-1])
    largest = _between(float(Y / tried[inner[-1]]), Z, M, tried, outer)
    return Radii(float(reach[inner[0]]), largest, int(inner[0]))


def _means(Z: Array, tried: Array) -> Array:
    """Return bounds on the means of Z from 0 to each radius: it does not decrease."""
    finite = np.isfinite(tried) & (tried > 0.0)
    ends = np.where(finite, tried, 0.0)
    sums = np.cumsum(Z[1:] * np.maximum(np.diff(ends), 0.0))
    means = Z.copy()
    means[finite] = OUTWARDS * sums[finite[1:]] / tried[finite]
    return means


def _between(share: float, Z: Array, M: Array, tried: Array, outer: int) -> float:
    """Return the largest radius, up to the next that was tried, of which M + share < 1 holds."""
    here = float(tried[outer])
    if outer + 1 == len(tried) or not np.isfinite(Z[outer + 1]):
        return here
    slope, sum_here = float(Z[outer + 1]), float(M[outer]) * here
    least = 1.0 - OUTWARDS * share
    if slope <= least:
        return here
    # The mean up to r is at most (M(here) here + Z(next) (r − here)) / r.
    found = (slope * here - sum_here) / (slope - least) / OUTWARDS**10
    proven = OUTWARDS * (sum_here + slope * (found - here)) <= least * found
    return found if proven and here < found < tried[outer + 1] else here


def _why(Y: float, M: Array, tried: Array) -> str:
    """Return the inequality, with its numbers where it fails by least."""
    lack = np.where((M < 1.0) & np.isfinite(tried), Y - (1.0 - M) * tried, np.inf)
    best = 1 + int(lack[1:].argmin())
    return (
        f"Y + M r < r does not hold for any r: Newton's step is Y = {Y:.3g} rad, and ‖I − A K*‖ "
        f"up to r = {tried[best]:.3g} rad from the pose may be M = {M[best]:.3g} in the mean"
    )


def norms_of(matrices: Intervals, rows: Array, columns: Array) -> Array:
    """Return norms of (b, n, m), rounded up: the largest row of its blocks'."""
    blocks = block_norms(matrices.magnitude, rows, columns)
    norms: Array = OUTWARDS * blocks.sum(axis=2).max(axis=1)
    return norms


def block_norms(sizes: Array, rows: Array, columns: Array) -> Array:
    """Return the Frobenius norms of the blocks of groups, rounded up, shape (..., rows, columns).

    Parameters
    ----------
    sizes : ndarray, shape (..., n, m)
        Not below the absolute values of a matrix.
    rows, columns : ndarray, shapes (rows, n) and (columns, m)
        1 for each member of a group.
    """
    blocks: Array = OUTWARDS * np.sqrt(rows @ sizes**2 @ columns.T)
    return blocks


def _nothing(failed: str) -> Radii:
    return Radii(math.inf, 0.0, 0, failed)
