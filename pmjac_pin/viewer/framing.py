"""Framing: from where to look at a picture first, and how much of it there is to see."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import msgspec
import numpy as np
from numpy.typing import NDArray

from pmjac_pin.viewer.shapes import Item, Text

Array = NDArray[np.float64]

_OBLIQUE = (0.62, -0.66, 0.42)
# A mechanism that is flat is looked at from where it is not: two axes of the world then lie
# nearly as they do on paper.
_FLAT = 0.2
_FACING = {0: (0.93, -0.25, 0.27), 1: (0.16, -0.95, 0.27), 2: (0.0, -0.42, 0.91)}

_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
_LETTER = 0.3  # half the width of a letter, relative to its height


class Framing(msgspec.Struct, frozen=True):
    """What a camera has to see.

    Attributes
    ----------
    centre : tuple of float
        In the world, m.
    eye : tuple of float
        Unit direction from the centre to the eye, in the world.
    width, height, depth : float
        Half the size of the picture as seen from there, m.
    field_of_view : float
        Degrees, vertical.
    """

    centre: tuple[float, ...]
    eye: tuple[float, ...]
    width: float
    height: float
    depth: float
    field_of_view: float = 40.0


def frame(items: Iterable[Item]) -> Framing:
    """Return the framing of all visible items."""
    visible = [item for item in items if item.visible]
    boxes = [_corners(item) for item in visible]
    points = np.concatenate(boxes) if boxes else np.zeros((1, 3))
    spread = np.ptp(points, axis=0)
    thinnest = int(np.argmin(spread))
    flat = spread[thinnest] < _FLAT * np.sort(spread)[1]
    eye = np.array(_FACING[thinnest] if flat else _OBLIQUE)
    eye /= np.linalg.norm(eye)
    right = np.cross((0.0, 0.0, 1.0), eye)
    right /= np.linalg.norm(right)
    view = np.array([right, np.cross(eye, right), eye])
    seen = points @ view.T
    margins = np.zeros_like(seen)
    margins[:, :2] = np.concatenate([_margins(item) for item in visible] or [np.zeros((1, 2))])
    low, high = (seen - margins).min(axis=0), (seen + margins).max(axis=0)
    smallest = 1e-6 + 1e-3 * float(np.abs(points).max())
    width, height, depth = np.maximum(0.5 * (high - low), smallest).tolist()
    centre = view.T @ (0.5 * (low + high))
    return Framing(tuple(centre.tolist()), tuple(eye.tolist()), width, height, depth)


def _corners(item: Item) -> Array:
    corners: Array = (_CORNERS * item.shape.half_extents) @ item.transform[:3, :3].T
    return corners + item.transform[:3, 3]


def _margins(item: Item) -> Array:
    """Return half the width and height of a text at its place; of all else nothing."""
    margins = np.zeros((8, 2))
    if isinstance(item.shape, Text):
        letter = float(np.linalg.norm(item.transform[:3, 0]))
        margins[:] = (letter * _LETTER * len(item.shape.text), 0.7 * letter)
    return margins
