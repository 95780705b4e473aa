"""A polytope in space, and its section and shadow in a coordinate plane, beside an ellipsoid."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pmjac_pin.rates.solid import Solid
from pmjac_pin.values.arrays import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SECTION, SHADOW = "polytope, section", "polytope, projection"
_COLOUR, _EDGE = "#E69F00", "#8A5A00"  # of Okabe and Ito's palette, and a darker shade


def draw_solid_in_space(axes: Any, solid: Solid) -> None:
    """Draw faces that can be looked through, and edges."""
    from mpl_toolkits.mplot3d import art3d  # type: ignore[import-untyped]  # noqa: PLC0415

    faces = [solid.corners[list(face)] for face in solid.faces]
    axes.add_collection3d(art3d.Poly3DCollection(faces, facecolor=_COLOUR, alpha=0.12, linewidth=0))
    edges = [solid.corners[list(edge)] for edge in solid.edges]
    axes.add_collection3d(art3d.Line3DCollection(edges, color=_EDGE, linewidth=0.9))


def draw_solid_in_plane(axes: Axes, solid: Solid, plane: str) -> None:
    """Draw section and shadow; what is a point or a segment is drawn as it is."""
    section, shadow = (_closed(each) for each in (solid.section(plane), solid.shadow(plane)))
    axes.fill(*section.T, color=_COLOUR, alpha=0.15, linewidth=0, zorder=0.5)
    axes.plot(*section.T, color=_EDGE, linewidth=1.8, label=SECTION)
    axes.plot(*shadow.T, color=_EDGE, linewidth=1.1, linestyle=(0, (2, 2)), label=SHADOW)
    if len(section) == 1:
        axes.plot(*section.T, "s", color=_EDGE, markersize=4)


def _closed(outline: Array) -> Array:
    """Return an outline back to where it begins; a segment only once."""
    return np.vstack([outline, outline[:1]]) if len(outline) > 2 else outline
