"""The machine at a pose beside what its tool can do there: one figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from pmjac_pin.configuration import Configuration
from pmjac_pin.errors import ArgumentError, did_you_mean, quoted
from pmjac_pin.pictures.ellipsoid_panels import PLANES, bounded, check_bounded, draw_ellipsoid
from pmjac_pin.pictures.figures import as_it_is, new_figure
from pmjac_pin.pictures.pose_figure import headings
from pmjac_pin.pictures.stick_drawing import draw_figure, frame_of, view_of
from pmjac_pin.pictures.stick_figure import StickFigure, StickFigures
from pmjac_pin.pictures.within_limits import (
    ToolQuantity,
    ellipsoid_of,
    where_it_moves,
    within_limits,
)
from pmjac_pin.rates.ellipsoid import Ellipsoid
from pmjac_pin.rates.motor_limits import Limits
from pmjac_pin.rates.solid import Solid
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import as_names, as_numbers, check_kind
from pmjac_pin.words.report import report

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# By quantity: the words for what is drawn within limits.
WITHIN: dict[ToolQuantity, str] = {
    "linear": "Linear velocity of the tool within the motors' rate limits",
    "angular": "Angular velocity of the tool within the motors' rate limits",
    "force": "Force at the tool, where it moves, within the motors' effort limits",
}

_PANEL, _REST = 4.0, 1.2  # inches: a panel, and what stands above and below all
_GRIDS = {1: (1, 2), 2: (1, 4), 3: (2, 3)}  # rows and columns, by how many planes are shown
_FIGURE_SIZES = (1.0, 100.0)  # inches, of a figure
_ACROSS = 1e-6  # sine of the angle between a plane and a coordinate plane


def plot(
    configuration: Configuration,
    quantity: str = "linear",
    *,
    limits: Limits | None = None,
    frame: str | pin.ReferenceFrame = "LOCAL_WORLD_ALIGNED",
    planes: Sequence[str] | None = None,
    size: tuple[float, float] | None = None,
) -> Figure:
    """Draw the machine at a pose beside an ellipsoid of its tool.

    Parameters
    ----------
    configuration : Configuration
    quantity : {"linear", "angular", "force"}
        The tool's velocities for motor rates |θ̇| = 1, its angular velocities, or the forces that
        motor efforts |τ| = 1 balance; of a planar machine those in its plane, which alone have
        bounds.
    limits : array_like, shape (n,), or "model", optional
        Of each motor's rate or effort, or those that the model states. The polytope of all that is
        within them is drawn, and in it the ellipsoid for rates, or efforts, in units of their
        limits; of forces those along which the tool moves.
    frame : {"LOCAL_WORLD_ALIGNED", "LOCAL", "WORLD"} or pin.ReferenceFrame
        Of the ellipsoid.
    planes : sequence of {"xy", "zx", "zy"}, optional
        Coordinate planes in which its section and shadow are drawn, the horizontal axis first. By
        default that in which the machine moves, or all three with the view in space.
    size : (float, float), optional
        Width and height, inches.

    Returns
    -------
    matplotlib.figure.Figure
        Notebooks show it; its `savefig` takes a path and dots per inch.

    Raises
    ------
    NoJacobianError
        There is no J_eq here.
    ArgumentError
        No such quantity, plane or size; an ellipsoid without bounds; limits that are none, or that
        the model does not state.
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> figure = pj.plot(pj.load("five_bar").home)
    >>> [axes.get_title() for axes in figure.axes][1:]
    ['X–Y plane']
    """
    solid, ellipsoid = _shown(configuration, quantity, frame, limits)
    wanted = _checked_planes(planes)
    drawn = StickFigures(configuration.mechanism)(configuration)
    view = view_of([drawn])
    across = _across(view[2])
    if across is not None and "xyz"[across] not in "".join(wanted or ()):
        ellipsoid = _forces_in_plane(ellipsoid, across)
    check_bounded(ellipsoid)
    shown = wanted or _usual_planes(across, ellipsoid)
    rows, columns = _GRIDS[len(shown)]
    usual = (_PANEL * columns, _PANEL * rows + _REST)
    heading, lines = headings(report(configuration, frame))
    figure: Any = new_figure(heading, usual if size is None else _inches(size), fontsize=13)
    figure.get_layout_engine().set(wspace=0.1, hspace=0.06)
    panels = figure.subfigures(1, 1)
    about = bounded(ellipsoid) if solid is None else WITHIN[quantity]  # type: ignore[index]
    panels.suptitle(as_it_is(f"{about}\n{lines}"), fontsize=10)
    grid = panels.add_gridspec(rows, columns)
    _draw_machine(panels.add_subplot(grid[:, 0]), drawn, view)
    places = [grid[row, column] for row in range(rows) for column in range(1, columns)]
    space = places.pop(0) if len(shown) > 1 else None
    draw_ellipsoid(panels, ellipsoid, dict(zip(shown, places, strict=True)), space, solid=solid)
    return figure  # type: ignore[no-any-return]


def _shown(
    configuration: Configuration,
    quantity: str,
    frame: str | pin.ReferenceFrame,
    limits: Limits | None,
) -> tuple[Solid | None, Ellipsoid]:
    check_kind(configuration, Configuration)
    jacobian = configuration.jacobian(frame)
    if not isinstance(quantity, str) or quantity not in WITHIN:
        raise ArgumentError(f"no quantity {quoted(quantity)}{did_you_mean(quantity, WITHIN)}")
    if limits is None:
        return None, ellipsoid_of(jacobian, quantity)
    return within_limits(jacobian, quantity, limits)


def _checked_planes(given: Sequence[str] | None) -> Sequence[str] | None:
    if given is None:
        return None
    told = f"planes are some of {', '.join(PLANES)}, each once"
    wanted = (given,) if isinstance(given, str) else as_names(given, told)
    if not wanted or len({*wanted} & {*PLANES}) < len(wanted):
        raise ArgumentError(f"{told}; got {quoted(given)}")
    return wanted


def _across(eye: Array) -> int | None:
    """Return which of x, y and z is looked along, None of a direction between them."""
    across = int(np.argmax(np.abs(eye)))
    return across if abs(eye[across]) > 1.0 - _ACROSS else None


def _forces_in_plane(ellipsoid: Ellipsoid, across: int) -> Ellipsoid:
    """Return what a planar machine bears in its plane, where it bears anything across it."""
    unbounded = np.isinf(ellipsoid.radii).tolist() == [True, False, False]
    if not (unbounded and abs(ellipsoid.axes[across, 0]) > 1.0 - _ACROSS):
        return ellipsoid
    return where_it_moves(ellipsoid)


def _usual_planes(across: int | None, ellipsoid: Ellipsoid) -> Sequence[str]:
    """Return the plane of a machine that is drawn, and moves, in one; all three of others."""
    if across is None:
        return PLANES
    moves = ellipsoid.radii * np.abs(ellipsoid.axes[across])
    in_plane = moves.max() <= _ACROSS * ellipsoid.radii[0]
    return [plane for plane in PLANES if "xyz"[across] not in plane] if in_plane else PLANES


def _inches(given: object) -> tuple[float, float]:
    size, (low, high) = as_numbers(given, "size"), _FIGURE_SIZES
    if size.shape != (2,) or size.min() < low or size.max() > high:
        wanted = f"size is width and height, {low:g} to {high:g} inches"
        raise ArgumentError(f"{wanted}; got {quoted(given)}")
    width, height = size.tolist()
    return width, height


def _draw_machine(axes: Any, drawn: StickFigure, view: Array) -> None:
    low, high = frame_of([drawn], view)
    draw_figure(axes, drawn, view)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_axis_off()
