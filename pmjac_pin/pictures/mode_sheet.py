"""Contact sheets: all assembly modes drawn side by side, to one scale and from one side.

Each is in the middle of its panel: where modes lie far apart, a common frame would be mostly empty.
"""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Any

import numpy as np

from pmjac_pin.errors import ArgumentError
from pmjac_pin.pictures.figures import as_it_is, new_figure
from pmjac_pin.pictures.page_layout import PageLayout
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


_SIGNS_IN_WORDS = {1: "det K* > 0", -1: "det K* < 0", 0: "det K* = 0"}


def plot_modes(modes: AssemblyModes) -> list[Figure]:
    r"""Draw assembly modes side by side, each with its number and what tells it apart.

    Blue are the links, vermilion the motors, grey the ground; rings are pins, black dots ball
    joints, yellow ones the anchors of loops. The tool's axes are red, green and blue.

    Parameters
    ----------
    modes : AssemblyModes
        One at least.

    Returns
    -------
    list of matplotlib.figure.Figure
        The pages: one, or more where they would be too small to read. `figures.save_pages`
        writes them.

    Raises
    ------
    ArgumentError
        There are no modes to draw.
    MissingDependencyError
        If matplotlib is not installed.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> [figure] = plot_modes(pj.assembly_modes(pj.load("four_bar"), [0.9], rng=0))
    >>> [axes.get_title() for axes in figure.axes]
    ['1\nσ = 0.457, det K* < 0', '2 (home)\nσ = 0.392, det K* > 0']
    """
    if not len(modes):
        raise ArgumentError("there are no assembly modes to draw")
    mechanism, motors = modes[0].mechanism, modes[0].actuated
    return modes_figures(make_modes_report(mechanism, motors, modes))


def modes_figures(report: ModesReport) -> list[Figure]:
    """Draw the assembly modes of a report under what it says of them; see `plot_modes`."""
    if not report.modes:
        raise ArgumentError("there are no assembly modes to draw")
    make = StickFigures(report.mechanism)
    drawn = [make(mode.configuration) for mode in report.modes]
    view = view_of(drawn)
    frames = [frame_of([figure], view) for figure in drawn]
    width, height = np.max([high - low for low, high in frames], axis=0).tolist()
    layout = PageLayout.of(len(drawn), height / width)
    sheets = []
    for page in layout.pages(len(drawn)):
        sheet, panels = _new_sheet(report, layout, page)
        for axes, figure, (low, high), mode in zip(
            panels, drawn[page], frames[page], report.modes[page], strict=True
        ):
            draw_figure(axes, figure, view)
            x, y = (0.5 * (low + high)).tolist()
            axes.set(xlim=(x - width / 2, x + width / 2), ylim=(y - height / 2, y + height / 2))
            axes.set_aspect("equal")
            axes.set_axis_off()
            axes.set_title(as_it_is(_caption(mode)), fontsize=8.5, linespacing=1.3)
        sheets.append(sheet)
    return sheets


def _new_sheet(report: ModesReport, layout: PageLayout, page: slice) -> tuple[Figure, list[Axes]]:
    """Return a figure and one panel for each mode of a page."""
    width = layout.size(0.0)[0]
    modes = len(report.modes)
    # Of a title in bold and a footer in a smaller type: characters to the inch.
    title = [f"Assembly modes of {report.name}"]
    if modes > layout.most:
        title[0] += f": {page.start + 1} to {min(page.stop, modes)} of {modes}"
    title += wrapped(motor_line(report.motors), round(11.0 * width)).split("\n")
    footer = textwrap.wrap(no_more(report.found.evidence), round(17.0 * width))
    room = 0.22 * len(title) + 0.14 * len(footer) + 0.2
    figure: Any = new_figure("\n".join(title), layout.size(room), fontsize=11)
    figure.supxlabel(as_it_is("\n".join(footer)), fontsize=7.5, color=DARK)
    panels = figure.subplots(layout.rows, layout.columns, squeeze=False).ravel()
    count = len(report.modes[page])
    for axes in panels[count:]:
        axes.remove()
    return figure, list(panels[:count])


def _caption(mode: ModeReport) -> str:
    names = f" ({', '.join(mode.poses)})" if mode.poses else ""
    mirror = f", mirror image of {mode.mirror_image}" if mode.mirror_image else ""
    smallest = mode.singularity.smallest
    facts = [f"σ = {brief(smallest)}"] if math.isfinite(smallest) else []
    facts += [_SIGNS_IN_WORDS[mode.sign]] if mode.sign is not None else []
    return f"{mode.number}{names}{mirror}\n{', '.join(facts)}"
