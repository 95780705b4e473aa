"""Polytopes: what a tool can do within the limits of each motor.

|θ̇ᵢ| ≤ limitᵢ is a box of motor rates, and B θ̇ fills its image, a zonotope: the tool velocities
that motors reach. Forces f that efforts |τᵢ| ≤ limitᵢ hold are where |Bᵀ f|ᵢ ≤ limitᵢ. An ellipsoid
asks for |θ̇| ≤ 1 of all motors together, in units that need not be alike; limits have units.

Both by hulls of points, SciPy's (Qhull's).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError
from pmjac_pin.values.arrays import Array, ReadOnlyArrays, norm
from pmjac_pin.values.checks import as_vector

_MOST_MOTORS = 16  # motors: 65,536 corners of a box
_NOT_REACHED = 1e-9  # of the largest singular value: a direction that is not reached


@dataclass(frozen=True, eq=False, repr=False)
class Polytope(ReadOnlyArrays):
    """A convex body by its corners and by its faces: {x : normals x ≤ offsets}.

    Attributes
    ----------
    vertices : ndarray, shape (k, d)
        Of two dimensions once around, the other way than a clock's hands; of one, the ends.
    normals : ndarray, shape (f, d)
        Of length 1, outwards.
    offsets : ndarray, shape (f,)
        How far the faces are from the origin.
    unit : str
        Such as "m/s" or "N".

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> jacobian = pj.load("three_rps").home.jacobian()
    >>> reach = jacobian.velocity_polytope([0.1, 0.1, 0.1], rows=["vz"])
    >>> reach.vertices.round(4).tolist(), reach.contains([0.05])
    ([[-0.1155], [0.1155]], True)
    """

    vertices: Array
    normals: Array
    offsets: Array
    unit: str

    def contains(self, point: ArrayLike) -> bool:
        """Tell whether a point (d,) is in it."""
        given = as_vector(point, self.vertices.shape[1], "a point")
        return bool((self.normals @ given <= self.offsets).all())

    def along(self, direction: ArrayLike) -> float:
        """Return how far it reaches from the origin in a direction (d,), of any length.

        Raises
        ------
        ArgumentError
            A direction that is none; the origin is not in the polytope.

        Examples
        --------
        >>> import pmjac_pin as pj
        >>> jacobian = pj.load("three_rps").home.jacobian()
        >>> held = jacobian.force_polytope([100.0] * 3, rows=["vz"])
        >>> round(held.along([-1.0]), 6)  # N: three legs that lean by 30°
        259.807621
        """
        way = as_vector(direction, self.vertices.shape[1], "a direction")
        if not way.any():
            raise ArgumentError("a direction is not zero")
        if (self.offsets < 0.0).any():
            raise ArgumentError("directions lead from the origin, which is not in the polytope")
        rates = self.normals @ (way / norm(way))
        ahead = rates > 0.0
        return float((self.offsets[ahead] / rates[ahead]).min())

    def __add__(self, other: Polytope) -> Polytope:
        """Return all sums of a point of each: what two tools that push together can do."""
        if not isinstance(other, Polytope):
            return NotImplemented
        if (self.unit, self.vertices.shape[1]) != (other.unit, other.vertices.shape[1]):
            raise ArgumentError(f"polytopes in {self.unit} and in {other.unit} have no sum")
        sums = self.vertices[:, None] + other.vertices[None]
        return hull_of(sums.reshape(-1, self.vertices.shape[1]), self.unit)

    def __repr__(self) -> str:
        faces, corners = len(self.normals), len(self.vertices)
        return f"Polytope({corners} vertices, {faces} faces, {self.unit})"


def image_of_box(map_: Array, limits: Array, unit: str) -> Polytope:
    """Return {A u : |uᵢ| ≤ limitᵢ}.

    Parameters
    ----------
    map_ : ndarray, shape (d, n)
    limits : ndarray, shape (n,)
    unit : str

    Raises
    ------
    ArgumentError
        Some direction is not reached; more motors than have corners that can be counted.
    """
    _check_full(map_ * limits, "is not reached: the polytope is flat there")
    if limits.size > _MOST_MOTORS:
        raise ArgumentError(f"polytopes of at most {_MOST_MOTORS} motors, got {limits.size}")
    box = np.array(list(product((-1.0, 1.0), repeat=limits.size))) * limits
    return hull_of(box @ map_.T, unit)


def within_box(map_: Array, limits: Array, unit: str) -> Polytope:
    """Return {x : |Aᵀ x|ᵢ ≤ limitᵢ}, shapes as of `image_of_box`.

    Raises
    ------
    ArgumentError
        Some direction is held at no effort, without bound.
    """
    faces = np.hstack([map_ / limits, -map_ / limits]).T
    _check_full(faces.T, "is held at no effort: the polytope has no bound there")
    # Corners of the polar body are the faces, and the other way round; 0 is in both.
    polar = hull_of(faces, "")
    return hull_of(polar.normals / polar.offsets[:, None], unit)


def hull_of(points: Array, unit: str) -> Polytope:
    """Return the hull of points (k, d) that are not all in one plane."""
    if points.shape[1] == 1:
        ends = np.array([points.min(axis=0), points.max(axis=0)])
        return Polytope(ends, np.array([[-1.0], [1.0]]), ends[:, 0] * [-1.0, 1.0], unit)
    # Qhull is imported with the first hull.
    from scipy.spatial import ConvexHull  # noqa: PLC0415

    size = np.abs(points).max()
    hull = ConvexHull(points / size)
    faces = np.unique(hull.equations.round(12), axis=0)
    corners = points[hull.vertices]
    return Polytope(corners, faces[:, :-1].copy(), -faces[:, -1] * size, unit)


def _check_full(map_: Array, what: str) -> None:
    """Raise where the columns (d, k) do not span all directions."""
    values = np.linalg.svd(map_, compute_uv=False)
    if values.size < len(map_) or not values[-1] > _NOT_REACHED * values[0]:
        raise ArgumentError(f"some direction {what}; choose `rows` without it")
