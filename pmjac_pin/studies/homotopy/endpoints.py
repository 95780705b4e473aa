"""Endpoints: a proof, one by one, that a computed complex solution is near an exact one.

Krawczyk's operator K(X) = m − C F(m) + (I − C J(X)) (X − m) over a box X of complex balls about
m: where K(X) lies inside X, there is exactly one solution in X, and it is in K(X). A box about a
real m contains with each point its conjugate, so the one solution in it is real.

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

from typing import Any

import numpy as np
from flint import acb, arb
from numpy.typing import NDArray

from pmjac_pin.algebra.balls import precise
from pmjac_pin.studies.homotopy.polynomial_loops import PolynomialLoops
from pmjac_pin.values.arrays import Complex, Mask

Balls = NDArray[Any]

_REAL = 1e-7  # imaginary part of a solution that may be real
_RADII = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


def proven(loops: PolynomialLoops, driven: Balls, x: Complex) -> Mask:
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
    with precise():
        boxes = [_box(loops, driven, one) for one in x]
        certain = np.array([_told(box, one) for box, one in zip(boxes, x, strict=True)], bool)
        for index, box in enumerate(boxes):
            for other in boxes[:index]:
                if box is not None and other is not None and _overlap(loops, box, other):
                    certain[index] = False
    return certain


def told_real(loops: PolynomialLoops, driven: Balls, x: Complex) -> Complex:
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


def _box(loops: PolynomialLoops, driven: Balls, x: Complex) -> Balls | None:
    """Return a box near x that contains exactly one solution, None where none is proven."""
    middle = _balls(x, 0.0)
    value, jacobian = loops.in_balls(middle, driven)
    slope = np.array([complex(entry) for entry in jacobian.ravel()]).reshape(jacobian.shape)
    try:
        inverse = np.linalg.inv(slope)
    except np.linalg.LinAlgError:
        return None
    move = -(_exact(inverse) @ value)
    for radius in _RADII:
        box = _balls(x, radius * (1.0 + float(np.abs(x).max(initial=0.0))))
        _, slopes = loops.in_balls(box, driven)
        rest = _exact(np.eye(len(x))) - _exact(inverse) @ slopes
        image: Balls = middle + move + rest @ (box - middle)
        if all(_inside(one, other) for one, other in zip(image, box, strict=True)):
            return image
    return None


def _told(box: Balls | None, x: Complex) -> bool:
    """Tell whether a box proves a solution that is real where x is, and only there."""
    if box is None:
        return False
    return bool((x.imag == 0.0).all()) or not all(entry.imag.contains(0) for entry in box)


def _balls(numbers: Complex, radius: float) -> Balls:
    found = [acb(arb(z.real, radius), arb(z.imag, radius)) for z in numbers.tolist()]
    return np.array(found, dtype=object)


def _exact(matrix: NDArray[Any]) -> Balls:
    entries = [acb(z.real, z.imag) for z in matrix.astype(complex).ravel().tolist()]
    return np.array(entries, dtype=object).reshape(matrix.shape)


def _inside(one: acb, other: acb) -> bool:
    real = bool(other.real.contains_interior(one.real))
    return real and bool(other.imag.contains_interior(one.imag))


def _overlap(loops: PolynomialLoops, one: Balls, other: Balls) -> bool:
    """Tell whether two boxes, or one and the other's quaternions with other signs, meet."""
    return any(
        all(bool(a.overlaps(b)) for a, b in zip(one, twin, strict=True))
        for twin in loops.twins(other)
    )
