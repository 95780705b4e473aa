"""Contact sheet: all assembly modes drawn side by side, to one scale and from one side."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Any

from pmjac_pin.errors import ArgumentError
from pmjac_pin.pictures.figures import as_it_is, new_figure
from pmjac_pin.pictures.pose_figure import wrapped
from pmjac_pin.pictures.stick_drawing import DARK, draw_figure, frame_of, view_of
from pmjac_pin.pictures.stick_figure import StickFigures
from pmjac_pin.studies.modes.assembly_modes import AssemblyModes
from pmjac_pin.values.brief import brief
from pmjac_pin.words.modes_report import ModeReport, ModesReport, make_modes_report
from pmjac_pin.words.modes_tables import no_more
from pmjac_pin.words.tables import motor_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# Inches: the width of a drawing where there is room, the height of what stands above it, and
# the widest sheet.
_PANEL, _CAPTION, _WIDEST_SHEET = 2.6, 0.5, 10.4
_SMALL_PANEL = 0.8  # of that width: drawings with smaller letters
_PAGE = 0.75  # height over width
_MOST_COLUMNS = 8

_SIGNS_IN_WORDS = {1: "det K* > 0", -1: "det K* < 0", 0: "det K* = 0"}


def plot_modes(modes: AssemblyModes) -> Figure:
    r"""Draw assembly modes side by side, each with its number and what tells it apart.

    Blue are the links, vermilion the motors, grey the ground; rings are pins, black dots ball
    joints, yellow ones the anchors of loops. The tool's axes are red, green and blue.

    Parameters
    ----------
    modes : AssemblyModes
        One at least.

    Returns
    -------
    matplotlib.figure.Figure
        Save it with `plotting.save_figure`.

    Raises
    ------
    ArgumentError
        There are no modes to draw.
    MissingDependencyError
        If matplotlib is not installed.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> figure = plot_modes(pj.assembly_modes(pj.load("four_bar"), [0.9], rng=0))
    >>> [axes.get_title() for axes in figure.axes]
    ['1\nσ = 0.457, det K* < 0', '2 (home)\nσ = 0.392, det K* > 0']
    """
    if not len(modes):
        raise ArgumentError("there are no assembly modes to draw")
    mechanism, motors = modes[0].mechanism, modes[0].actuated
    return modes_figure(make_modes_report(mechanism, motors, modes))


def modes_figure(report: ModesReport) -> Figure:
    """Draw the assembly modes of a report under what it says of them; see `plot_modes`."""
    modes = report.modes
    if not modes:
        raise ArgumentError("there are no assembly modes to draw")
    make = StickFigures(report.mechanism)
    figures = [make(mode.configuration) for mode in modes]
    view = view_of(figures)
    low, high = frame_of(figures, view)
    height = float((high - low)[1] / (high - low)[0])
    columns = _sheet_columns(len(modes), min(max(height, 0.3), 2.0))
    sheet, panels = _new_sheet(report, columns, min(max(height, 0.3), 2.0))
    scale = min(1.0, _WIDEST_SHEET / columns / _PANEL)
    for axes, figure, mode in zip(panels, figures, modes, strict=True):
        draw_figure(axes, figure, view, scale)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.set_axis_off()
        small = scale < _SMALL_PANEL
        caption = _caption(mode, "\n" if small else ", ")
        axes.set_title(as_it_is(caption), fontsize=7.0 if small else 8.5, linespacing=1.3)
    return sheet


def _sheet_columns(count: int, height: float) -> int:
    """Return in how many columns drawings of this height in widths make a page, not a ribbon."""

    def cost(columns: int) -> float:
        rows = -(-count // columns)
        page = rows * (height + _CAPTION / _PANEL) / columns
        return abs(math.log(page / _PAGE)) + (rows * columns - count) / count

    return min(range(min(count, 2), min(count, _MOST_COLUMNS) + 1), key=cost)


def _new_sheet(report: ModesReport, columns: int, height: float) -> tuple[Figure, list[Axes]]:
    """Return a figure and one panel a mode, as high over wide as said."""
    rows = -(-len(report.modes) // columns)
    width = min(max(columns * _PANEL, 2 * _PANEL), _WIDEST_SHEET)
    # Of a title in bold and a footer in a smaller type: characters to the inch.
    title = [f"Assembly modes of {report.name}"]
    title += wrapped(motor_line(report.motors), round(11.0 * width)).split("\n")
    footer = textwrap.wrap(no_more(report.found.evidence), round(17.0 * width))
    room = 0.22 * len(title) + 0.14 * len(footer) + 0.2
    size = (width, rows * (height * width / columns + _CAPTION) + room)
    figure: Any = new_figure("\n".join(title), size, fontsize=11)
    figure.supxlabel(as_it_is("\n".join(footer)), fontsize=7.5, color=DARK)
    count = len(report.modes)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels[count:]:
        axes.remove()
    return figure, list(panels[:count])


def _caption(mode: ModeReport, between: str) -> str:
    names = f" ({', '.join(mode.poses)})" if mode.poses else ""
    mirror = f", mirror image of {mode.mirror_image}" if mode.mirror_image else ""
    smallest = mode.singularity.smallest
    facts = [f"σ = {brief(smallest)}"] if math.isfinite(smallest) else []
    facts += [_SIGNS_IN_WORDS[mode.sign]] if mode.sign is not None else []
    return f"{mode.number}{names}{mirror}\n{between.join(facts)}"
