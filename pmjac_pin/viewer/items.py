"""What a picture is made of: items, each a unit shape with its colour and where it stands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pmjac_pin.files.shapes import Colour, Shape
from pmjac_pin.values.arrays import Array
from pmjac_pin.viewer.facets import Facets


@dataclass(frozen=True, eq=False, slots=True)
class Item:
    """One shape of the picture.

    Attributes
    ----------
    name : str
        A path such as "links/crank/crank_bar": unique, and never the beginning of another's.
    shape : Shape or Facets
        Of unit size. From pose to pose only a Text and Facets change.
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
    shape: Shape | Facets
    colour: Colour
    transform: Array
    visible: bool = True
    on_top: bool = False


@dataclass(frozen=True, slots=True)
class Part:
    """What of an item never changes."""

    name: str
    shape: Shape | Facets
    colour: Colour
    on_top: bool = False


#: A part, the body that carries it, and its transform (4, 4) there.
Carried = tuple[Part, int, Array]


def stretched_between(
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
