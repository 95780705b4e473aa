"""Drawing an ellipsoid as the lecture does: in space, and in the Z-Y, Z-X and X-Y planes.

The one module that needs matplotlib, imported only when something is drawn. Figures are built
without pyplot: no global state, no display, and any thread may draw.
"""

from __future__ import annotations

import io
import math
import os
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from pmjac_pin.errors import ArgumentError, MissingDependencyError, quoted
from pmjac_pin.files.output_file import check_place, write_file
from pmjac_pin.files.user_path import output_path
from pmjac_pin.rates.ellipse import Ellipse
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PLANES = ("zy", "zx", "xy")
"""The lecture's three planes: the horizontal axis first."""

# Okabe and Ito's palette, which colour-blind readers can tell apart.
_SURFACE, _SECTION, _SHADOW = "#56B4E9", "#0072B2", "#D55E00"
_AXIS_COLOURS = ("#000000", "#009E73", "#CC79A7")
_GRID = "#D9D9D9"

_FEWEST_DOTS, _MOST_DOTS = 1, 2400  # per inch: of more, the picture would not fit in memory

_EYE_ELEVATION = 30.0  # degrees, of the eye above the x-y plane

# By unit: the symbol and the words for what the ellipsoid bounds.
_QUANTITIES = {
    "m/s": ("v", "Linear velocity of the tool, |motor rates| = 1"),
    "rad/s": ("ω", "Angular velocity of the tool, |motor rates| = 1"),
    "N": ("f", "Force at the tool, |motor efforts| = 1"),
    "N m": ("m", "Moment at the tool, |motor efforts| = 1"),
}


def plot_ellipsoid(
    ellipsoid: Ellipsoid,
    *,
    title: str,
    subtitle: str = "",
    quantity: str | None = None,
    symbol: str | None = None,
) -> Figure:
    """Draw an ellipsoid in space and its sections and shadows in the coordinate planes.

    The figure of Ghosal, *Parallel Manipulator Jacobian Matrix*, to equation (33): the surface
    with its three principal axes, and the Z-Y, Z-X and X-Y planes (horizontal axis first). All
    four panels have the same limits.

    Parameters
    ----------
    ellipsoid : Ellipsoid
        May be flat, a needle or a point, but not unbounded.
    title : str
        What is shown, such as mechanism and pose.
    subtitle : str
        A second, smaller line, such as the motor values.
    quantity : str, optional
        Heading of the view in space. By default read off the ellipsoid's unit: "Linear
        velocity of the tool" for "m/s".
    symbol : str, optional
        Letter of the axis labels, which get x, y and z as an index. By default read off the
        unit: v for "m/s", ω for "rad/s", f for "N".

    Returns
    -------
    matplotlib.figure.Figure
        Save it with `save_figure`.

    Raises
    ------
    ArgumentError
        If `ellipsoid` is no `Ellipsoid` or is unbounded.
    MissingDependencyError
        If matplotlib is not installed.

    Examples
    --------
    >>> from pmjac_pin.rates.ellipsoid import velocity_ellipsoid
    >>> figure = plot_ellipsoid(velocity_ellipsoid([[2, 0], [0, 1], [0, 0]]), title="A disc")
    >>> [axes.get_title() for axes in figure.axes][1:]
    ['Z–Y plane', 'Z–X plane', 'X–Y plane']
    """
    _check_bounded(ellipsoid)
    if not isinstance(title, str):
        raise ArgumentError(f"title must be a string, got {quoted(title)}")
    usual_symbol, usual_quantity = _QUANTITIES.get(ellipsoid.unit, ("v", ""))
    scaled = _rescaled(ellipsoid)
    labels = _axis_labels(symbol or usual_symbol, scaled.unit)
    figure: Figure = new_figure(title, (8.4, 8.8), fontsize=13)
    figure.get_layout_engine().set(wspace=0.1, hspace=0.06)  # type: ignore[union-attr, call-arg]
    panels: Any = figure.subfigures(1, 1)
    if subtitle:
        panels.suptitle(as_it_is(subtitle), fontsize=10)
    space = panels.add_subplot(2, 2, 1, projection="3d", computed_zorder=False)
    space.set_title(usual_quantity if quantity is None else quantity, fontsize=10)
    _draw_space(space, scaled, labels)
    for index, plane in enumerate(PLANES, start=2):
        axes = panels.add_subplot(2, 2, index)
        axes.set_title("–".join(plane.upper()) + " plane", fontsize=10)
        _draw_plane(axes, scaled, plane, labels)
    radii, unit = ellipsoid.radii.tolist(), ellipsoid.unit
    handles, names = axes.get_legend_handles_labels()
    names[2:] = [f"{name}: {r:.4g} {unit}" for name, r in zip(names[2:], radii, strict=False)]
    figure.legend(handles, names, loc="outside lower center", ncols=5, fontsize=8.5, frameon=False)
    return figure


def save_figure(figure: Figure, path: str | os.PathLike[str], dpi: float = 150) -> None:
    """Write a figure to a file; a failure leaves a file that is already there untouched.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    path : str or path-like
        The suffix tells the format: .png, .pdf, .svg and what else matplotlib can write.
    dpi : float
        Dots per inch, for formats made of dots.

    Raises
    ------
    ArgumentError
        If the suffix is unknown, or `dpi` is not positive.
    OutputError
        If the file cannot be written: no such folder, no right to, no space, or no file there
        but a folder, a device or a pipe.
    """
    suffix = check_figure_file(path)
    if not _FEWEST_DOTS <= as_number(dpi, "dpi") <= _MOST_DOTS:
        raise ArgumentError(f"dpi must be {_FEWEST_DOTS} to {_MOST_DOTS}; got {quoted(dpi)}")
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=dpi, format=suffix)
    write_file(path, drawn.getvalue())


def check_figure_file(path: str | os.PathLike[str]) -> str:
    """Return the suffix of a figure's file; refuse, before anything is drawn, what cannot be one.

    Raises
    ------
    ArgumentError, OutputError, MissingDependencyError
        As `save_figure`.
    """
    check_place(path)
    suffix = output_path(path).suffix.lower().removeprefix(".")
    formats = sorted(_matplotlib().backends.backend_agg.FigureCanvasAgg.get_supported_filetypes())
    if suffix not in formats:
        known = f"its suffix must be one of .{', .'.join(formats)}"
        raise ArgumentError(f"cannot save {quoted(os.fspath(path))}: {known}")
    return suffix


def _check_bounded(ellipsoid: Ellipsoid) -> None:
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


def _matplotlib() -> ModuleType:
    try:
        # The plain form also looks up the package itself, not only its cached submodules.
        import matplotlib.backends.backend_agg  # noqa: PLC0415
        import matplotlib.figure  # noqa: PLC0415
        import matplotlib.patheffects  # noqa: PLC0415
    except ImportError as error:
        raise MissingDependencyError(
            f"plotting needs matplotlib: pip install 'pmjac_pin[plot]' ({error})"
        ) from error
    return matplotlib


def new_figure(title: str, size: tuple[float, float], fontsize: float) -> Any:
    """Return an empty figure of this size in inches, without pyplot."""
    mpl = _matplotlib()
    figure = mpl.figure.Figure(figsize=size, layout="constrained")
    mpl.backends.backend_agg.FigureCanvasAgg(figure)
    figure.suptitle(as_it_is(title), fontsize=fontsize, fontweight="bold")
    return figure


def as_it_is(text: str) -> str:
    """Escape the dollar signs, between which matplotlib would look for a formula."""
    return text.replace("$", r"\$")


def _rescaled(ellipsoid: Ellipsoid) -> Ellipsoid:
    """Move very large and small radii into a power of ten in the unit, for short tick labels."""
    largest = float(ellipsoid.radii[0])
    if largest == 0 or 1e-2 <= largest < 1e3:
        return ellipsoid
    exponent = max(3 * math.floor(math.log10(largest) / 3), -306)
    unit = f"$10^{{{exponent}}}$ {ellipsoid.unit}".rstrip()
    return Ellipsoid(ellipsoid.radii / 10.0**exponent, ellipsoid.axes, unit)


def _axis_labels(symbol: str, unit: str) -> dict[str, str]:
    return {axis: f"${symbol}_{axis}$" + (f" [{unit}]" if unit else "") for axis in "xyz"}


def _limit(ellipsoid: Ellipsoid) -> float:
    return 1.15 * float(ellipsoid.radii[0]) or 1.0


def _draw_space(axes: Any, ellipsoid: Ellipsoid, labels: dict[str, str]) -> None:
    limit = _limit(ellipsoid)
    x, y, z = np.moveaxis(ellipsoid.points(), -1, 0)
    axes.plot_surface(x, y, z, color=_SURFACE, alpha=0.2, linewidth=0, rstride=1, cstride=1)
    axes.plot_wireframe(x, y, z, color=_SECTION, alpha=0.3, linewidth=0.4, rcount=12, ccount=8)
    halo = [_matplotlib().patheffects.withStroke(linewidth=2.5, foreground="white")]
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


def _draw_plane(axes: Axes, ellipsoid: Ellipsoid, plane: str, labels: dict[str, str]) -> None:
    limit = _limit(ellipsoid)
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
        color, name = _AXIS_COLOURS[index], f"axis {index + 1}"
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
