"""The displacement group that a loop's joints move in: planar, spherical, spatial, ...

The twists of a loop's joints, closed under the Lie bracket, span the Lie algebra of the smallest
group that holds every displacement these joints can make, here and at all other poses. A loop
whose joints generate a group of dimension λ < 6 has that many equations at most: the λ = 3 of the
planar Grübler-Kutzbach formula is one case (Hervé, *The Lie group of rigid body displacements*,
Mechanism and Machine Theory 34, 1999).
"""

from __future__ import annotations

import itertools

import numpy as np

from pmjac_pin.rates.factorisation import factorise
from pmjac_pin.values.arrays import Array

# By the ranks of the rotations and of the pure translations among the twists.
_NAMES = {
    (0, 0): "at rest",
    (0, 1): "along a line",
    (0, 2): "translations of a plane",
    (0, 3): "translations",
    (1, 0): "about an axis",
    (1, 1): "cylindrical",
    (1, 2): "planar",
    (1, 3): "Schoenflies",
    (3, 0): "spherical",
    (3, 3): "spatial",
}
_SCREWS = {(1, 0): "along a screw", (1, 2): "along parallel screws"}  # where the turns have a pitch


def generated_algebra(twists: Array, tolerance: float) -> Array:
    """Return an orthonormal basis (6, λ) of the Lie algebra that twists generate.

    Parameters
    ----------
    twists : ndarray, shape (6, k)
        Linear rows first, in units that make a rad and the length unit comparable; one frame.
    tolerance : float
        Directions below it count as none, the twists being made unit vectors.

    Examples
    --------
    Three parallel axes, one of them through the origin: planar motion.

    >>> import numpy as np
    >>> axes = np.array([[0, 0, 0, 0, 0, 1], [0, -1, 0, 0, 0, 1], [1, 0, 0, 0, 0, 1.0]]).T
    >>> generated_algebra(axes, 1e-6).shape
    (6, 3)
    """
    basis = _orthonormal(twists / np.linalg.norm(twists, axis=0), tolerance)
    while True:
        pairs = itertools.combinations(basis.T, 2)
        brackets = [_bracket(one, other) for one, other in pairs]
        grown = _orthonormal(np.column_stack([basis, *brackets]), tolerance)
        if grown.shape[1] == basis.shape[1]:
            return basis
        basis = grown


def group_name(algebra: Array, tolerance: float) -> str:
    """Return the name of the group of an algebra (6, λ)."""
    directions, dimension = _orthonormal(algebra[3:], tolerance), algebra.shape[1]
    ranks = (directions.shape[1], dimension - directions.shape[1])
    if ranks in _SCREWS and np.abs(directions.T @ algebra[:3]).max() > tolerance:
        return _SCREWS[ranks]
    return _NAMES.get(ranks, f"of dimension {dimension}")


def _bracket(one: Array, other: Array) -> Array:
    """Return [(v₁, ω₁), (v₂, ω₂)] = (ω₁ × v₂ + v₁ × ω₂, ω₁ × ω₂)."""
    (v1, w1), (v2, w2) = (one[:3], one[3:]), (other[:3], other[3:])
    return np.concatenate([np.cross(w1, v2) + np.cross(v1, w2), np.cross(w1, w2)])


def _orthonormal(columns: Array, tolerance: float) -> Array:
    factors = factorise(columns, 1.0, tolerance)
    return factors.left[:, : factors.rank]
