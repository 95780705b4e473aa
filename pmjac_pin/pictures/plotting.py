"""Drawing an ellipsoid as the lecture does: in space, and in the Z-Y, Z-X and X-Y planes."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING, Any

from pmjac_pin.errors import ArgumentError, quoted
from pmjac_pin.pictures.ellipsoid_panels import PLANES, bounded, check_bounded, draw_ellipsoid
from pmjac_pin.pictures.figures import as_it_is, new_figure
from pmjac_pin.rates.ellipsoid import Ellipsoid

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_TITLE_WIDTH = 48  # characters above one panel


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
    check_bounded(ellipsoid)
    if not isinstance(title, str):
        raise ArgumentError(f"title must be a string, got {quoted(title)}")
    figure: Figure = new_figure(title, (8.4, 8.8), fontsize=13)
    figure.get_layout_engine().set(wspace=0.1, hspace=0.06)  # type: ignore[union-attr, call-arg]
    panels: Any = figure.subfigures(1, 1)
    if subtitle:
        panels.suptitle(as_it_is(subtitle), fontsize=10)
    first, *others = panels.add_gridspec(2, 2)
    planes = dict(zip(PLANES, others, strict=True))
    space = draw_ellipsoid(panels, ellipsoid, planes, first, symbol=symbol)
    usual = textwrap.fill(bounded(ellipsoid), _TITLE_WIDTH)
    space.set_title(usual if quantity is None else quantity, fontsize=10)
    return figure
