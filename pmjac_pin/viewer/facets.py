"""Facets: a shape of triangles, for what has another form at every pose."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pmjac_pin.values.arrays import Array

_ROD_SIDES = 6  # of a rod


@dataclass(frozen=True, slots=True)
class Facets:
    """Triangles about the origin; the farthest corner is at 1, so that a transform has the size.

    Attributes
    ----------
    corners, normals : bytes
        Of numbers of four bytes: x, y, z of each triangle's corners, and of the normal there.
    half_extents : tuple of float
        Along x, y and z.
    """

    corners: bytes
    normals: bytes
    half_extents: tuple[float, float, float]
    round_axes: ClassVar[int] = 0

    @classmethod
    def of(cls, triangles: Array) -> Facets:
        """Return the shape of triangles (k, 3, 3): the other way than a clock from outside."""
        arms = triangles[:, 1:] - triangles[:, :1]
        normals = np.cross(arms[:, 0], arms[:, 1])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        x, y, z = np.abs(triangles).max(axis=(0, 1)).tolist()
        written = triangles.astype("<f4").tobytes()
        return cls(written, normals.repeat(3, axis=0).astype("<f4").tobytes(), (x, y, z))


NO_FACETS = Facets(b"", b"", (0.0, 0.0, 0.0))


def fans(corners: Array, faces: Iterable[tuple[int, ...]]) -> Array:
    """Return triangles (k, 3, 3) of convex faces, each by its corners once around."""
    found = [(face[0], *pair) for face in faces for pair in itertools.pairwise(face[1:])]
    return corners[np.array(found, dtype=np.intp).reshape(-1, 3)]


def rods(starts: Array, ends: Array, radius: float) -> Array:
    """Return triangles (k, 3, 3) of prisms about lines from starts to ends, (j, 3)."""
    along = ends - starts
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    least = np.eye(3)[np.abs(along).argmin(axis=1)]
    across = np.cross(along, least)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    angles = np.linspace(0.0, 2.0 * np.pi, _ROD_SIDES, endpoint=False)[:, None, None]
    around = radius * (np.cos(angles) * across + np.sin(angles) * np.cross(along, across))
    low, high = starts + around, ends + around  # (sides, j, 3)
    low_next, high_next = (np.roll(each, -1, axis=0) for each in (low, high))
    sides = [np.stack([low, low_next, high_next], 2), np.stack([low, high_next, high], 2)]
    return np.concatenate(sides).reshape(-1, 3, 3)
