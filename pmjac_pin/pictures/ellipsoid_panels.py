"""An ellipsoid in space, and its section and shadow in a coordinate plane, one panel each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pmjac_pin.errors import ArgumentError
from pmjac_pin.pictures.figures import matplotlib_package
from pmjac_pin.pictures.solid_panels import draw_solid_in_plane, draw_solid_in_space
from pmjac_pin.rates.ellipse import Ellipse
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.rates.solid import Solid
from pmjac_pin.values.arrays import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PLANES = ("zy", "zx", "xy")
"""The lecture's three planes: the horizontal axis first."""

# Okabe and Ito's palette, which colour-blind readers can tell apart.
_SURFACE, _SECTION, _SHADOW = "#56B4E9", "#0072B2", "#D55E00"
_AXIS_COLOURS = ("#000000", "#009E73", "#CC79A7")
_GRID = "#D9D9D9"
_AXES = ("axis 1", "axis 2", "axis 3")

_EYE_ELEVATION = 30.0  # degrees, of the eye above the x-y plane

# By unit: the symbol and the words for what the ellipsoid bounds.
QUANTITIES = {
    "m/s": ("v", "Linear velocity of the tool, |motor rates| = 1"),
    "rad/s": ("ω", "Angular velocity of the tool, |motor rates| = 1"),
    "N": ("f", "Force at the tool, |motor efforts| = 1"),
    "N m": ("m", "Moment at the tool, |motor efforts| = 1"),
}


def bounded(ellipsoid: Ellipsoid) -> str:
    """Return what an ellipsoid bounds, and in what its motors are counted where that is known.

    Examples
    --------
    >>> bounded(Ellipsoid(np.ones(3), np.eye(3), "m/s", "rad/s"))
    'Linear velocity of the tool, |motor rates| = 1 in rad/s'
    """
    words = QUANTITIES.get(ellipsoid.unit, ("v", ""))[1]
    return f"{words} in {ellipsoid.motor_unit}" if words and ellipsoid.motor_unit else words


def draw_ellipsoid(
    panels: Any,
    ellipsoid: Ellipsoid,
    planes: Mapping[str, Any],
    space: Any = None,
    *,
    symbol: str | None = None,
    solid: Solid | None = None,
) -> Any:
    """Draw an ellipsoid into places of a figure; return the axes in space, None without a place.

    Parameters
    ----------
    panels : matplotlib.figure.SubFigure
    ellipsoid : Ellipsoid
    planes : mapping of str to SubplotSpec
        One at least, by the planes.
    space : SubplotSpec, optional
    symbol : str, optional
        Letter of the axis labels; by default read off the ellipsoid's unit.
    solid : Solid, optional
        A polytope in the same unit, drawn about it.
    """
    reach = 0.0 if solid is None else solid.reach
    factor, scaled = _rescaled(ellipsoid, reach)
    limit = 1.15 * max(factor * reach, float(scaled.radii[0])) or 1.0
    labels = _axis_labels(symbol or QUANTITIES.get(ellipsoid.unit, ("v", ""))[0], scaled.unit)
    in_space = None
    if space is not None:
        in_space = panels.add_subplot(space, projection="3d", computed_zorder=False)
        _draw_space(in_space, scaled, labels, limit)
        if solid is not None:
            draw_solid_in_space(in_space, solid.scaled(factor))
    for plane, place in planes.items():
        axes = panels.add_subplot(place)
        _draw_plane(axes, scaled, plane, labels, limit)
        if solid is not None:
            draw_solid_in_plane(axes, solid.scaled(factor), plane)
    _show_radii(panels.figure, axes, ellipsoid)
    return in_space


def check_bounded(ellipsoid: Ellipsoid) -> None:
    """Raise ArgumentError for what is no ellipsoid, or cannot be drawn."""
    if not isinstance(ellipsoid, Ellipsoid):
        raise ArgumentError(
            f"an Ellipsoid is needed, such as jacobian.velocity_ellipsoid(); "
            f"got {type(ellipsoid).__name__}"
        )
    if ellipsoid.radii[0] == math.inf:
        raise ArgumentError(
            f"an unbounded ellipsoid cannot be drawn; got {ellipsoid!r}: its infinite radii are "
            f"the directions that the structure bears without motor effort"
        )


def _rescaled(ellipsoid: Ellipsoid, reach: float) -> tuple[float, Ellipsoid]:
    """Move very large and small radii into a power of ten in the unit, for short tick labels.

    Returns the factor of what is drawn, too; `reach` is that of what is drawn beside it.
    """
    largest = max(float(ellipsoid.radii[0]), reach)
    if largest == 0 or 1e-2 <= largest < 1e3:
        return 1.0, ellipsoid
    exponent = max(3 * math.floor(math.log10(largest) / 3), -306)
    unit = f"$10^{{{exponent}}}$ {ellipsoid.unit}".rstrip()
    return 10.0**-exponent, Ellipsoid(ellipsoid.radii / 10.0**exponent, ellipsoid.axes, unit)


def _axis_labels(symbol: str, unit: str) -> dict[str, str]:
    return {axis: f"${symbol}_{axis}$" + (f" [{unit}]" if unit else "") for axis in "xyz"}


def _show_radii(figure: Any, axes: Any, ellipsoid: Ellipsoid) -> None:
    """Put a legend below a figure: the lines of a plane's panel, with the radii."""
    radii, unit = ellipsoid.radii.tolist(), ellipsoid.unit
    handles, names = axes.get_legend_handles_labels()
    values = dict(zip(_AXES, radii, strict=True))
    names = [f"{name}: {values[name]:.4g} {unit}" if name in values else name for name in names]
    figure.legend(handles, names, loc="outside lower center", ncols=5, fontsize=8.5, frameon=False)


def _draw_space(axes: Any, ellipsoid: Ellipsoid, labels: dict[str, str], limit: float) -> None:
    x, y, z = np.moveaxis(ellipsoid.points(), -1, 0)
    axes.plot_surface(x, y, z, color=_SURFACE, alpha=0.2, linewidth=0, rstride=1, cstride=1)
    axes.plot_wireframe(x, y, z, color=_SECTION, alpha=0.3, linewidth=0.4, rcount=12, ccount=8)
    halo = [matplotlib_package().patheffects.withStroke(linewidth=2.5, foreground="white")]
    for index in range(ellipsoid.rank):
        radius, axis, color = ellipsoid.radii[index], ellipsoid.axes[:, index], _AXIS_COLOURS[index]
        axes.quiver(0, 0, 0, *(radius * axis), color=color, linewidth=2, arrow_length_ratio=0.12)
        # Labels of short axes would overlap at the centre: they stand off, at the end of a line.
        end = max(radius, 0.55 * limit) * axis
        axes.plot(*np.column_stack([radius * axis, end]), color=color, linewidth=0.7)
        style = {"fontsize": 9, "ha": "center", "va": "center", "path_effects": halo, "zorder": 10}
        axes.text(*(1.18 * end), f"{radius:.4g}", **style)
    if ellipsoid.rank == 0:
        axes.plot(0, 0, 0, "o", color=_SECTION, markersize=4)
    for letter, label in labels.items():
        getattr(axes, f"set_{letter}lim")(-limit, limit)
        getattr(axes, f"set_{letter}label")(label, fontsize=9, labelpad=-2)
    axes.set_aspect("equal")
    axes.set_box_aspect((1, 1, 1), zoom=1.05)
    axes.set_proj_type("ortho")
    axes.view_init(elev=_EYE_ELEVATION, azim=_azimuth(ellipsoid))
    axes.tick_params(labelsize=7, pad=0)
    axes.locator_params(nbins=5)


def _azimuth(ellipsoid: Ellipsoid) -> float:
    """Return matplotlib's usual azimuth unless it shows principal axes on top of each other.

    Axes i and j coincide in the picture where the third of them has no component along the
    line of sight; then the next azimuth is tried.
    """
    best = (-1.0, 0.0)
    for azimuth in (-60.0, -30.0, 30.0, 60.0):
        a, e = math.radians(azimuth), math.radians(_EYE_ELEVATION)
        sight = np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)])
        seen = np.abs(sight @ ellipsoid.axes)
        needle, flat = float(np.hypot(seen[1], seen[2])), float(seen[2])
        clarity = {3: float(seen.min()), 2: flat, 1: needle}.get(ellipsoid.rank, 1.0)
        if clarity > 0.25:
            return azimuth
        best = max(best, (clarity, azimuth))
    return best[1]


def _draw_plane(
    axes: Axes, ellipsoid: Ellipsoid, plane: str, labels: dict[str, str], limit: float
) -> None:
    axes.set_title("–".join(plane.upper()) + " plane", fontsize=10)
    axes.axhline(0, color=_GRID, linewidth=0.8, zorder=0)
    axes.axvline(0, color=_GRID, linewidth=0.8, zorder=0)
    section = ellipsoid.section(plane)
    axes.fill(*_outline(section).T, color=_SURFACE, alpha=0.3, linewidth=0, zorder=1)
    axes.plot(*_outline(section).T, color=_SECTION, linewidth=2.2, label="section")
    if section.radii[0] <= 1e-3 * limit:
        axes.plot(0, 0, "o", color=_SECTION, markersize=5)
    shadow = _outline(ellipsoid.projection(plane))
    axes.plot(*shadow.T, color=_SHADOW, linewidth=1.3, linestyle=(0, (5, 4)), label="projection")
    rows = ["xyz".index(letter) for letter in plane]
    for index in range(ellipsoid.rank):
        x, y = ellipsoid.radii[index] * ellipsoid.axes[rows, index]
        color, name = _AXIS_COLOURS[index], _AXES[index]
        axes.plot([0, x], [0, y], color=color, linewidth=1.4, zorder=1.5, label=name)
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
    axes.set_xlabel(labels[plane[0]], fontsize=9)
    axes.set_ylabel(labels[plane[1]], fontsize=9)
    axes.tick_params(labelsize=8)
    axes.locator_params(nbins=7)


def _outline(ellipse: Ellipse) -> Array:
    """Return the outline, of a flat ellipse only once: going back would fill the dashes' gaps."""
    points = ellipse.points()
    flat = ellipse.radii[1] <= 1e-9 * ellipse.radii[0]
    return points[: len(points) // 2 + 1] if flat else points
