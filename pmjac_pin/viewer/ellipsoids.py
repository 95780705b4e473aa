"""The ellipsoids at the tool: surface, principal axes, values."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ClosureError
from pmjac_pin.files.shapes import Cone, Cylinder, Sphere, Text
from pmjac_pin.pictures.anatomy import Anatomy
from pmjac_pin.pictures.within_limits import ToolQuantity, ellipsoid_of
from pmjac_pin.rates.ellipse import ties, turned_into_plane
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.values.arrays import Array, read_only
from pmjac_pin.viewer.equivalent import equivalent
from pmjac_pin.viewer.items import Part, stretched_between
from pmjac_pin.viewer.layers import SPECK, Drawing, DrawnPose, lettering, specks, words
from pmjac_pin.viewer.palette import PRINCIPAL, SURFACE

# Shares of the mechanism's size.
AUTOMATIC = 0.35  # the largest semi-axis at home
LIMIT = 1.2  # no semi-axis is drawn longer
THINNEST = 0.012  # nor shorter: a disc and a needle stay visible, and the transform regular
LETTERS = 0.06
_HEAD = 0.07
_SHAFT_RADIUS = 0.008


class EllipsoidLayer:
    """One ellipsoid about the tool.

    Its parts are the surface, and for each principal axis in the order of the radii a shaft, a
    head and a label. All are hidden where no J_eq exists, and so are axes of zero length.

    Parameters
    ----------
    anatomy : Anatomy
    kind : {"linear", "angular", "force"}

    Attributes
    ----------
    automatic : float
        Metres in the picture per unit of the ellipsoid.
    """

    def __init__(self, anatomy: Anatomy, kind: ToolQuantity) -> None:
        self._kind: ToolQuantity = kind
        self._size = anatomy.size
        self.automatic = _automatic_scale(anatomy, kind)
        path = f"ellipsoids/{kind}"
        axes = [1, 2, 3]
        self.parts: Sequence[Part] = (
            Part(f"{path}/surface", Sphere(), SURFACE[kind]),
            *(Part(f"{path}/axis{n}/shaft", Cylinder(), PRINCIPAL[kind]) for n in axes),
            *(Part(f"{path}/axis{n}/head", Cone(), PRINCIPAL[kind]) for n in axes),
            *(words(f"{path}/axis{n}/label", "", PRINCIPAL[kind]) for n in axes),
        )

    def draw(self, pose: DrawnPose) -> Drawing:
        """Return surface, axes and labels."""
        ellipsoid = pose.ellipsoids.get(self._kind)
        transforms, visible = np.zeros((10, 4, 4)), np.zeros(10, dtype=bool)
        texts = {number: Text("") for number in (7, 8, 9)}
        if ellipsoid is not None:
            drawn = self.drawn_radii(ellipsoid, pose.scale)
            transforms[0] = _surface(pose.tool, ellipsoid.axes, drawn)
            vectors = pose.directions[self._kind] * drawn
            transforms[1:4], transforms[4:7], tips = self._arrows(pose.tool, vectors)
            transforms[7:] = lettering(tips, LETTERS * self._size)
            visible[:] = [True, *(3 * [n < ellipsoid.rank for n in range(3)])]
            for n, radius in enumerate(ellipsoid.radii[: ellipsoid.rank].tolist()):
                cut = radius * self.automatic * pose.scale > LIMIT * self._size
                texts[7 + n] = Text(radius_label(radius, ellipsoid.unit) + ", cut" * cut)
        specks(transforms, visible, pose.tool, SPECK * self._size)
        return Drawing(transforms, visible, texts)

    def drawn_radii(self, ellipsoid: Ellipsoid, scale: float = 1.0) -> Array:
        """Return the semi-axes of the picture in m: scaled, and within what can be drawn."""
        with np.errstate(over="ignore"):
            radii = ellipsoid.radii * (self.automatic * scale)
        return np.clip(radii, THINNEST * self._size, LIMIT * self._size)

    def _arrows(self, tool: Array, vectors: Array) -> tuple[Array, Array, Array]:
        """Return shafts, heads and the places of labels for arrows along columns (3, 3)."""
        vectors = vectors.T
        lengths = np.linalg.norm(vectors, axis=1)
        heads = np.minimum(_HEAD * self._size, 0.5 * lengths)
        necks = tool + vectors * (1.0 - heads / lengths)[:, None]
        radii = np.minimum(_SHAFT_RADIUS * self._size, 0.15 * lengths)
        start = np.broadcast_to(tool, vectors.shape)
        shafts, _ = stretched_between(start, necks, radii, 0.0)
        cones, _ = stretched_between(necks, tool + vectors, 0.35 * heads, 0.0)
        words_at = tool + vectors * (1.0 + LETTERS * self._size / lengths)[:, None]
        return shafts, cones, words_at


def find_ellipsoids(
    configuration: Configuration, kinds: Iterable[ToolQuantity]
) -> dict[ToolQuantity, Ellipsoid]:
    """Return the ellipsoids of these kinds, or nothing where no equivalent Jacobian exists."""
    kinds = tuple(kinds)
    jacobian, _ = equivalent(configuration) if kinds else (None, "")
    if jacobian is None:
        return {}
    return {kind: ellipsoid_of(jacobian, kind) for kind in kinds}


def directions_after(
    before: Mapping[ToolQuantity, Array], ellipsoids: Mapping[ToolQuantity, Ellipsoid]
) -> dict[ToolQuantity, Array]:
    """Return the axes of ellipsoids, each with the sign of the earlier one that it is most like.

    The earlier one need not be of the same number: where two radii cross, their axes change
    places. Where radii are equal, their axes are any of their span: those that were drawn before,
    turned as little as it takes. Earlier directions of what is not among the ellipsoids are kept.
    """
    directions = dict(before)
    for kind, ellipsoid in ellipsoids.items():
        axes = ellipsoid.axes
        if kind in before:
            axes = _kept_axes(before[kind], axes, ties(ellipsoid.radii))
        directions[kind] = read_only(axes)
    return directions


def _kept_axes(before: Array, axes: Array, tied: list[bool]) -> Array:
    if all(tied):
        return before
    likeness = before.T @ axes
    nearest = np.abs(likeness).argmax(axis=0)
    axes = axes * np.where(likeness[nearest, range(3)] < 0.0, -1.0, 1.0)
    for first in (first for first in range(2) if tied[first]):
        normal = axes[:, 2 - 2 * first].tolist()
        axes[:, first : first + 2] = np.transpose(turned_into_plane(normal, before.T.tolist()))
    return axes


def radius_label(radius: float, unit: str) -> str:
    """Return what an axis is labelled with: always four digits, so that it keeps its width.

    Examples
    --------
    >>> radius_label(2.34, "m/s"), radius_label(float("inf"), "N")
    ('2.340 m/s', '∞ N')
    """
    number = "∞" if math.isinf(radius) else f"{radius:#.4g}".rstrip(".")
    return f"{number} {unit}"


def _surface(position: Array, axes: Array, radii: Array) -> Array:
    transform = np.eye(4)
    transform[:3, :3] = axes * radii
    transform[:3, 3] = position
    return transform


def _automatic_scale(anatomy: Anatomy, kind: ToolQuantity) -> float:
    """Return m per unit that make the largest finite semi-axis at home `AUTOMATIC` long.

    From home or, where nothing can be told there, from another pose: not from the one that is
    drawn, or dragging through a singularity would make everything else breathe.
    """
    for name in ("home", *anatomy.mechanism.poses):
        try:
            ellipsoid = find_ellipsoids(anatomy.mechanism.pose(name), [kind]).get(kind)
        except ClosureError:
            continue
        radii = [] if ellipsoid is None else ellipsoid.radii.tolist()
        largest = max((r for r in radii if math.isfinite(r)), default=0.0)
        if largest > 0.0:
            return AUTOMATIC * anatomy.size / largest
    return AUTOMATIC * anatomy.size
