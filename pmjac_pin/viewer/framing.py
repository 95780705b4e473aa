"""Framing: from where to look at a picture first, and how much of it there is to see."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import msgspec
import numpy as np

from pmjac_pin.values.arrays import Array
from pmjac_pin.values.ties import first_smallest
from pmjac_pin.viewer.items import Item

_OBLIQUE = (0.62, -0.66, 0.42)
# A mechanism that is flat is looked at from where it is not: two axes of the world then lie
# nearly as they do on paper.
_FLAT_SHARE = 0.2
_FACING = {0: (0.93, -0.25, 0.27), 1: (0.16, -0.95, 0.27), 2: (0.0, -0.42, 0.91)}

_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
_ANGLES = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
_RIM = np.stack([np.cos(_ANGLES), np.sin(_ANGLES), np.ones(16)], axis=1)
_CYLINDER_ENDS = np.concatenate([_RIM, _RIM * (1.0, 1.0, -1.0)])
# Of a ball: three great circles.
_CIRCLES = np.concatenate([np.roll(_RIM * (1.0, 1.0, 0.0), turn, axis=1) for turn in range(3)])
_HULLS = {0: _CORNERS, 2: _CYLINDER_ENDS, 3: _CIRCLES}  # by the number of round axes


class Framing(msgspec.Struct, frozen=True):
    """What a camera has to see.

    Attributes
    ----------
    centre : tuple of float
        In the world, m: what the camera looks at.
    eye : tuple of float
        Unit direction from the centre to the eye, in the world.
    extremes : tuple of tuple of float
        Points that have to be in the picture, m from the centre: how far to the side, how far
        up or down, how far towards the eye. All others are seen if these are.
    field_of_view : float
        Degrees, vertical.
    """

    centre: tuple[float, ...]
    eye: tuple[float, ...]
    extremes: tuple[tuple[float, ...], ...]
    field_of_view: float = 40.0


def frame(items: Iterable[Item]) -> Framing:
    """Return the framing of all visible items."""
    hulls = [_hull_of(item) for item in items if item.visible]
    points = np.concatenate(hulls) if hulls else np.zeros((1, 3))
    eye = _direction(points)
    right = np.cross((0.0, 0.0, 1.0), eye)
    right /= np.linalg.norm(right)
    view = np.array([right, np.cross(eye, right), eye])
    seen = points @ view.T
    middle = 0.5 * (seen.min(axis=0) + seen.max(axis=0))
    extremes = _extremes(seen - middle, 1e-9 + 1e-3 * float(np.ptp(points, axis=0).max()))
    return Framing(
        centre=tuple((view.T @ middle).tolist()),
        eye=tuple(eye.tolist()),
        extremes=tuple(map(tuple, extremes.tolist())),
    )


def _direction(points: Array) -> Array:
    spread = np.ptp(points, axis=0)
    thinnest = first_smallest(spread)
    flat = spread[thinnest] < _FLAT_SHARE * np.sort(spread)[1]
    eye = np.array(_FACING[thinnest] if flat else _OBLIQUE)
    unit: Array = eye / np.linalg.norm(eye)
    return unit


def _extremes(seen: Array, smallest: float) -> Array:
    """Return the points that no other one exceeds in width, height and depth at once."""
    reach = np.column_stack([np.maximum(np.abs(seen[:, :2]), smallest), seen[:, 2]])
    found = np.zeros((0, 3))
    # What exceeds a point has the larger sum, and is met before it.
    for point in reach[np.argsort(-reach.sum(axis=1), kind="stable")]:
        if not (found >= point).all(axis=1).any():
            found = np.vstack([found, point])
    return found


def _hull_of(item: Item) -> Array:
    """Return points about an item in the world, shape (k, 3); of a text its place."""
    hull = _HULLS[item.shape.round_axes] * item.shape.half_extents
    points: Array = hull @ item.transform[:3, :3].T + item.transform[:3, 3]
    return points
