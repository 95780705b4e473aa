"""The gallery's pictures: a mechanism alone, its map over one or two motors."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

import pmjac_pin as pj
from pmjac_pin.pictures.figures import as_it_is, new_figure
from pmjac_pin.pictures.stick_drawing import draw_figure, frame_of, view_of
from pmjac_pin.pictures.stick_figure import StickFigures
from pmjac_pin.values.arrays import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

CELLS = 81  # along each motor of a map
POINTS = 721  # of a curve over one motor


def portrait(configuration: pj.Configuration) -> Figure:
    """Draw the mechanism alone, for the index."""
    drawn = StickFigures(configuration.mechanism)(configuration)
    view = view_of([drawn])
    low, high = frame_of([drawn], view)
    figure = new_figure("", (3.2, 2.4), 8.0)
    axes = figure.subplots()
    draw_figure(axes, drawn, view)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.set_axis_off()
    return figure  # type: ignore[no-any-return]


def range_of(mechanism: pj.Mechanism, motor: str) -> tuple[float, float]:
    """Return a motor's limits; of an angle at most one turn, about home."""
    low, high = mechanism.limits(motor)
    home = float(mechanism.home.actuated[mechanism.actuated.index(motor)])
    if mechanism.units[motor] == "rad" and high - low > 2.0 * math.pi:
        return home - math.pi, home + math.pi
    return low, high


def draw_map(mechanism: pj.Mechanism) -> Figure:
    """Draw what its first motor, or its first two, reach from home on this assembly mode.

    Its colour, or curve, is how near K* is to singular; where there are no loops, how evenly the
    tool moves.
    """
    motors = mechanism.actuated[:2]
    places = POINTS if len(motors) == 1 else CELLS
    over = {motor: np.linspace(*range_of(mechanism, motor), places) for motor in motors}
    label, values = _measured(mechanism, over)
    figure = new_figure("", (6.0, 4.2), 9.0)
    axes: Axes = figure.subplots()
    if len(motors) == 1:
        axes.plot(over[motors[0]], values, color="#0072B2")
        axes.set(ylabel=label, xlim=range_of(mechanism, motors[0]))
        axes.set_ylim(bottom=0.0)
    else:
        first, second = over.values()
        drawn = axes.pcolormesh(first, second, values.T, cmap="viridis", shading="nearest", vmin=0)
        figure.colorbar(drawn, ax=axes, label=label)
        axes.set(xlim=_reached(values, first, 1), ylim=_reached(values, second, 0))
    _label(axes, mechanism, motors)
    return figure  # type: ignore[no-any-return]


def _label(axes: Axes, mechanism: pj.Mechanism, motors: tuple[str, ...]) -> None:
    """Name the motors at the axes, and mark home."""
    home = mechanism.home
    place = [float(home.actuated[mechanism.actuated.index(motor)]) for motor in motors]
    names = [as_it_is(f"{motor} [{mechanism.units[motor]}]") for motor in motors]
    axes.set_xlabel(names[0])
    if len(motors) == 1:
        place.append(home.singularity().smallest)
    else:
        axes.set_ylabel(names[1])
    axes.plot(*place, "o", mfc="white", mec="black", clip_on=False)


def _reached(values: Array, places: Array, across: int) -> tuple[float, float]:
    """Return from where to where along an axis of a map there is anything, and a cell more."""
    reached = places[np.isfinite(values).any(axis=across)]
    cell = places[1] - places[0]
    return float(reached[0] - cell), float(reached[-1] + cell)


def _measured(mechanism: pj.Mechanism, over: dict[str, Array]) -> tuple[str, Array]:
    """Return what is measured all over a grid of motors, and its values: NaN where none is reached.

    Each cell is closed from one beside it, so that what is behind a singularity is left out.
    """
    many = pj.batch(mechanism)
    grid = many.grid(over)
    values = np.full(grid.status.shape, np.nan)
    closed = grid.status == pj.Status.CLOSED
    measures = many.measures(grid.q[closed])
    if mechanism.spec.loops:
        values[closed] = measures.smallest
        return "smallest singular value of K*, relative", values
    values[closed] = _evenness(measures.velocity_radii)
    return "least by largest speed of the tool", values


def _evenness(radii: Array) -> Array:
    ways = int((radii > 1e-9 * radii.max()).any(axis=0).sum())  # two of a planar arm
    return np.asarray(radii[:, ways - 1] / radii[:, 0])
