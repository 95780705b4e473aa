"""Solid: a polytope of tool velocities or forces as it lies in space, for drawings.

A tool that moves in a plane or along a line only reaches a polygon or a segment there; and of the
forces those along which it moves are the ones that its motors hold, the others the structure bears.
So the polytope is taken within the span of the ellipsoid's axes, and put into space by them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from pmjac_pin.errors import ArgumentError
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.rates.polytope import Polytope, hull_of, image_of_box, within_box
from pmjac_pin.values.arrays import Array, ReadOnlyArrays
from pmjac_pin.values.checks import as_limits

_IN_PLANE = 1e-9  # of the largest corner: how far the corners of a face may be from its plane
_FLAT = 1e-9  # of the largest: what is no width


@dataclass(frozen=True, eq=False, repr=False)
class Solid(ReadOnlyArrays):
    """A convex body about the origin of space: a solid, a polygon, a segment.

    Attributes
    ----------
    corners : ndarray, shape (k, 3)
    faces : tuple of tuple of int
        Corners of each, once around; of a polygon one, of a segment none.
    unit : str

    Examples
    --------
    >>> corners = np.stack(np.meshgrid(*3 * [[-1.0, 1.0]])).reshape(3, -1).T
    >>> cube = solid_of(hull_of(corners, "N"))
    >>> len(cube.corners), len(cube.faces), len(cube.edges)
    (8, 6, 12)
    """

    corners: Array
    faces: tuple[tuple[int, ...], ...]
    unit: str

    @cached_property
    def edges(self) -> tuple[tuple[int, int], ...]:
        """Pairs of corners, the smaller number first."""
        if not self.faces:
            return ((0, 1),)
        around = (zip(face, face[1:] + face[:1], strict=True) for face in self.faces)
        return tuple(sorted({(min(a, b), max(a, b)) for face in around for a, b in face}))

    @property
    def reach(self) -> float:
        """How far the farthest corner is, in `unit`."""
        return float(np.linalg.norm(self.corners, axis=1).max())

    def scaled(self, factor: float) -> Solid:
        """Return it with its corners so many times as far: in another unit."""
        return Solid(factor * self.corners, self.faces, self.unit)

    def shadow(self, plane: str) -> Array:
        """Return the outline (k, 2) of the projection on a plane such as "zy": z, then y."""
        return outline(self.corners[:, ["xyz".index(letter) for letter in plane]], self.reach)

    def section(self, plane: str) -> Array:
        """Return the outline (k, 2) of the section with such a plane: one point where that is 0."""
        [normal] = {0, 1, 2} - {"xyz".index(letter) for letter in plane}
        heights, size = self.corners[:, normal], self.reach
        within = np.abs(heights) <= _IN_PLANE * size
        points = [self.corners[within]]
        # What lies between any two corners is in the body, and the outline is between some.
        above, below = heights > _IN_PLANE * size, heights < -_IN_PLANE * size
        high, low = self.corners[above][:, None], self.corners[below][None]
        share = heights[above][:, None] / (heights[above][:, None] - heights[below][None])
        points.append((high + share[:, :, None] * (low - high)).reshape(-1, 3))
        flat = np.concatenate(points)[:, ["xyz".index(letter) for letter in plane]]
        return outline(flat, size)


def velocity_solid(block: Array, moves: Ellipsoid, limits: ArrayLike) -> Solid:
    """Return the tool velocities that motor rates |θ̇ᵢ| ≤ limit reach.

    Parameters
    ----------
    block : ndarray, shape (3, n)
        The linear or the angular rows of J_eq.
    moves : Ellipsoid
        Their ellipsoid for |θ̇| ≤ 1, which says in which directions there is any motion.
    limits : array_like, shape (n,)
        m/s or rad/s.

    Raises
    ------
    ArgumentError
        Limits that are none; rows that never move.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> jacobian = pj.load("five_bar").home.jacobian()
    >>> reach = velocity_solid(jacobian.Jv_eq, jacobian.velocity_ellipsoid(), [10.0, 10.0])
    >>> reach.corners.shape, reach.unit
    ((4, 3), 'm/s')
    """
    rows, bounds = _unit_rows(block, moves), as_limits(limits, block.shape[1])
    return solid_of(image_of_box(rows, bounds, moves.unit), moved(moves) * _radii(moves))


def force_solid(block: Array, moves: Ellipsoid, limits: ArrayLike) -> Solid:
    """Return the forces, or moments, that efforts |τᵢ| ≤ limit hold, along which the tool moves.

    Parameters
    ----------
    block, moves
        As of `velocity_solid`.
    limits : array_like, shape (n,)
        N or N m.

    Raises
    ------
    ArgumentError
        As `velocity_solid`.
    """
    rows, bounds = _unit_rows(block, moves), as_limits(limits, block.shape[1])
    unit = "N" if moves.unit == "m/s" else "N m"
    return solid_of(within_box(rows, bounds, unit), moved(moves) / _radii(moves))


def _unit_rows(block: Array, moves: Ellipsoid) -> Array:
    """Return the rows (d, n) of J_eq along its axes over its radii: orthonormal.

    Corners and faces of what is long and thin are found where it is neither.
    """
    return np.asarray(moved(moves).T @ block / _radii(moves)[:, None])


def _radii(moves: Ellipsoid) -> Array:
    return moves.radii[: moves.rank]


def moved(moves: Ellipsoid) -> Array:
    """Return orthonormal columns (3, d) that span the directions of an ellipsoid.

    Raises
    ------
    ArgumentError
        It is a point.
    """
    if not moves.rank:
        raise ArgumentError("the tool does not move so: there is no polytope of it")
    return moves.axes[:, : moves.rank]


def solid_of(polytope: Polytope, span: Array | None = None) -> Solid:
    """Return a polytope of d dimensions in space, by the columns (3, d) that it is mapped by.

    They are right-handed where there are three.
    """
    axes = np.eye(3)[:, : polytope.vertices.shape[1]] if span is None else span
    corners = polytope.vertices @ axes.T
    count, dimension = polytope.vertices.shape
    if dimension == 1:
        return Solid(corners, (), polytope.unit)
    if dimension == 2:
        return Solid(corners, (tuple(range(count)),), polytope.unit)
    near = _IN_PLANE * float(np.abs(polytope.vertices).max())
    heights = polytope.vertices @ polytope.normals.T - polytope.offsets
    found = {
        tuple(np.flatnonzero(np.abs(height) <= near).tolist()): normal
        for height, normal in zip(heights.T, polytope.normals, strict=True)
    }
    faces = (_around(polytope.vertices, face, normal) for face, normal in found.items())
    return Solid(corners, tuple(faces), polytope.unit)


def _around(corners: Array, face: tuple[int, ...], normal: Array) -> tuple[int, ...]:
    """Return the corners of a face once around, seen from outside the other way than a clock."""
    arms = corners[list(face)] - corners[list(face)].mean(axis=0)
    across = arms[0] - (arms[0] @ normal) * normal
    angles = np.arctan2(arms @ np.cross(normal, across), arms @ across)
    return tuple(face[k] for k in np.argsort(angles, kind="stable").tolist())


def outline(points: Array, size: float) -> Array:
    """Return the hull (j, 2) of points (k, 2) once around; two ends of a segment, or one point.

    `size` is what a width is compared with.

    Examples
    --------
    >>> outline(np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]), 2.0).tolist()
    [[0.0, 0.0], [2.0, 2.0]]
    """
    arms = points - points.mean(axis=0)
    _, widths, axes = np.linalg.svd(arms, full_matrices=False)
    wide = int(np.count_nonzero(widths > _FLAT * size))
    if wide == 2:
        return hull_of(points, "").vertices
    if wide == 0:
        return points[:1]
    along = arms @ axes[0]
    return points[sorted((int(along.argmin()), int(along.argmax())))]
