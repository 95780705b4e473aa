"""Endpoints: a proof, one by one, that a computed complex solution is near an exact one.

Krawczyk's test, by real and imaginary parts, in the largest of these: within some distance of x
there is exactly one solution. The points that near to a real x are so with their conjugates, so
that this one solution is real.

The equations are polynomials with rational coefficients: placements and lengths as doubles, in
characteristic lengths. The motors' values are taken exactly, with enclosures of their cosines and
sines, so that all numbers but the unknowns are real.

References
----------
.. [1] R. Krawczyk: Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken.
   Computing 4 (1969).
.. [2] P. Breiding, K. Rose, S. Timme: Certifying zeros of polynomial systems using interval
   arithmetic. ACM Trans. Math. Softw. 49 (2023).
"""

from __future__ import annotations

import math

import numpy as np
from flint import acb, arb

from pmjac_pin.algebra.balls import OUTWARDS, BallArray, enclosing, precise
from pmjac_pin.algebra.intervals import Intervals
from pmjac_pin.studies.homotopy.polynomial_loops import PolynomialLoops
from pmjac_pin.studies.homotopy.polynomial_table import BallMatrix
from pmjac_pin.studies.krawczyk import Radii, radii
from pmjac_pin.values.arrays import Array, Complex, Mask

_REAL = 1e-7  # imaginary part of a solution that may be real
_ENDPOINT_RADII = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


def proven(loops: PolynomialLoops, driven: BallMatrix, x: Complex) -> Mask:
    """Tell which of the solutions (r, n) are proven to be near exact ones, all different.

    Of a real solution it is proven, too, that it is real; of another that it is not.

    Parameters
    ----------
    loops : PolynomialLoops
    driven : ndarray of acb
        The variables that follow from the motors: real balls.
    x : ndarray, shape (r, n)
        Real where the solution is to be proven real.
    """
    # Where a derivative is beyond all bounds, nothing is proven.
    with precise(), np.errstate(over="ignore", invalid="ignore"):
        found = [_proven_radii(loops, driven, one) for one in x]
    existence = np.array([one.existence for one in found])
    near = np.where(np.isfinite(existence), existence, -np.inf)  # what is not proven is near none
    certain: Mask = np.isfinite(existence) & _proven_real(x, existence)
    for index, one in enumerate(x):
        for twin in loops.twins(one):
            if (_largest_part(x[:index] - twin) <= OUTWARDS * (near[:index] + near[index])).any():
                certain[index] = False
    return certain


def told_real(loops: PolynomialLoops, driven: BallMatrix, x: Complex) -> Complex:
    """Return solutions (r, n), those that are real to 1e-7 without their imaginary parts.

    A pair of complex solutions may be as near to the real ones: what is proven decides, where
    it is not real.
    """
    x = x.copy()
    near = np.flatnonzero(np.abs(x.imag).max(axis=1, initial=0.0) <= _REAL)
    apart = proven(loops, driven, x[near]) & (np.abs(x[near].imag).max(axis=1, initial=0.0) > 0.0)
    real = near[~apart]
    x[real] = x[real].real
    return x


def _proven_radii(loops: PolynomialLoops, driven: BallMatrix, x: Complex) -> Radii:
    """Return what Krawczyk's test proves of the solutions near x."""
    value = loops.values_in_balls(_balls(x, 0.0), driven)
    residual, columns = np.concatenate(_parts(value)), np.arange(2 * len(x))
    found = Radii(math.inf, 0.0)
    for share in _ENDPOINT_RADII:
        radius = share * (1.0 + float(np.abs(x).max(initial=0.0)))
        jacobian = _real(loops.slopes_in_balls(_balls(x, radius), driven))
        nested = Intervals.stack([jacobian, jacobian], axis=0)  # at x, too, if not as sharp
        found = radii(residual, nested, columns, np.eye(columns.size), np.array([0.0, radius]))
        if not found.failed:
            break
    return found


def _largest_part(x: Complex) -> Array:
    """Return the largest part of the unknowns (r, n), real or imaginary."""
    parts = np.maximum(np.abs(x.real), np.abs(x.imag))
    return np.asarray(parts.max(axis=1, initial=0.0))


def _proven_real(x: Complex, existence: Array) -> Mask:
    """Tell which solutions are proven to be real where x is, and only there."""
    imaginary = np.abs(x.imag).max(axis=1, initial=0.0)
    return np.asarray((imaginary == 0.0) | (imaginary > existence))


def _balls(numbers: Complex, radius: float) -> BallMatrix:
    found = [acb(arb(z.real, radius), arb(z.imag, radius)) for z in numbers.tolist()]
    return np.array(found, dtype=object)


def _parts(numbers: BallMatrix) -> tuple[BallArray, BallArray]:
    """Return the real and the imaginary parts."""
    parts = [(entry.real, entry.imag) for entry in numbers.ravel()]
    real, imaginary = np.array(parts, dtype=object).reshape(-1, 2).T
    return real.reshape(numbers.shape), imaginary.reshape(numbers.shape)


def _real(slopes: BallMatrix) -> Intervals:
    """Return derivatives of real and imaginary parts by real and imaginary parts."""
    real, imaginary = map(enclosing, _parts(slopes))
    rows = Intervals.join([real, -imaginary], 1), Intervals.join([imaginary, real], 1)
    return Intervals.join(rows)
