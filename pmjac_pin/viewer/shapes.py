"""What a picture is made of: unit shapes, and where each of them stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Colour = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Box:
    """A cube of side 1 about the origin."""

    round_axes = 0
    half_extents = (0.5, 0.5, 0.5)


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder of radius 1 along z, from z = −1/2 to 1/2."""

    round_axes = 2
    half_extents = (1.0, 1.0, 0.5)


@dataclass(frozen=True, slots=True)
class Cone:
    """A cone of radius 1 along z, its base at z = −1/2 and its apex at z = 1/2."""

    round_axes = 2
    half_extents = (1.0, 1.0, 0.5)


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere of radius 1 about the origin."""

    round_axes = 3
    half_extents = (1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Text:
    """One line of text whose letters are 1 high, its middle at the origin.

    Its transform is a translation and one scale, the height of the letters in m; how the text
    is turned towards the eye is left to the drawing.
    """

    text: str
    round_axes = 0
    half_extents = (0.0, 0.0, 0.0)  # its size depends on the font, its place is what counts


Shape = Box | Cylinder | Cone | Sphere | Text


@dataclass(frozen=True, eq=False, slots=True)
class Item:
    """One shape of the picture.

    Attributes
    ----------
    name : str
        A path such as "links/crank/crank_bar": unique, and never the beginning of another's.
    shape : Shape
        Of unit size. From pose to pose only a Text changes.
    colour : tuple of four float
        Red, green, blue and opacity, 0 to 1.
    transform : ndarray, shape (4, 4)
        From the shape to the world, its scale included: translation times rotation times three
        positive scales. Read-only.
    visible : bool
        Whether there is anything to see. What is hidden has a transform too, so small that it
        cannot be seen, and regular.
    on_top : bool
        Whether it is seen through what is before it.
    """

    name: str
    shape: Shape
    colour: Colour
    transform: Array
    visible: bool = True
    on_top: bool = False


@dataclass(frozen=True, slots=True)
class Part:
    """What of an item never changes."""

    name: str
    shape: Shape
    colour: Colour
    on_top: bool = False


def between(
    starts: Array, ends: Array, radii: Array, smallest: float
) -> tuple[Array, NDArray[np.bool_]]:
    """Return transforms that stretch a unit cylinder or cone from start to end.

    Parameters
    ----------
    starts, ends : ndarray, shape (k, 3)
    radii : ndarray, shape (k,)
    smallest : float
        What is shorter than this is hidden: it becomes a speck of this size.

    Returns
    -------
    transforms : ndarray, shape (k, 4, 4)
        z runs from start to end; x and y are any that make it right-handed.
    visible : ndarray of bool, shape (k,)
    """
    along = ends - starts
    lengths = np.sqrt((along * along).sum(axis=1))
    visible = lengths > smallest
    directions = along / np.where(visible, lengths, 1.0)[:, None]
    z = np.where(visible[:, None], directions, (0.0, 0.0, 1.0))
    lengths = np.where(visible, lengths, smallest)
    widths = np.where(visible, radii, smallest)[:, None]
    x, y = _perpendicular(z)
    transforms = np.zeros((len(starts), 4, 4))
    transforms[:, :3, 0], transforms[:, :3, 1] = widths * x, widths * y
    transforms[:, :3, 2] = lengths[:, None] * z
    transforms[:, :3, 3] = 0.5 * (starts + ends)
    transforms[:, 3, 3] = 1.0
    return transforms, visible


def scaled(scale: float | tuple[float, float, float] | Array) -> Array:
    """Return the transform (4, 4) that only scales."""
    transform = np.eye(4)
    transform[:3, :3] *= scale
    return transform


def translation(position: Array) -> Array:
    """Return the transform (4, 4) that only moves."""
    transform = np.eye(4)
    transform[:3, 3] = position
    return transform


def _perpendicular(z: Array) -> tuple[Array, Array]:
    """Return x and y with x × y = z, for unit vectors z, shape (k, 3).

    Duff et al., *Building an Orthonormal Basis, Revisited* (2017): no branch, exact everywhere.
    """
    sign = np.copysign(1.0, z[:, 2])
    a = -1.0 / (sign + z[:, 2])
    b = z[:, 0] * z[:, 1] * a
    x = np.stack([1.0 + sign * z[:, 0] ** 2 * a, sign * b, -sign * z[:, 0]], axis=1)
    y = np.stack([b, sign + z[:, 1] ** 2 * a, -z[:, 1]], axis=1)
    return x, y
