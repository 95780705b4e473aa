"""Contact sheet: all assembly modes drawn side by side, to one scale and from one side.

Drawn in parallel projection with matplotlib's flat axes: what is nearer covers what is behind
it, with a white rim where lines cross. A mechanism that moves in a plane is drawn in that plane.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pmjac_pin.errors import ArgumentError
from pmjac_pin.pictures.plotting import as_it_is, new_figure
from pmjac_pin.pictures.pose_figure import wrapped
from pmjac_pin.pictures.stick_figure import StickFigure, StickFigures, Stroke
from pmjac_pin.studies.modes.assembly_modes import AssemblyModes
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.brief import brief
from pmjac_pin.values.ties import first_largest
from pmjac_pin.words.modes_report import ModeReport, ModesReport, make_modes_report
from pmjac_pin.words.modes_tables import no_more
from pmjac_pin.words.tables import motor_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


_ELEVATION = 25.0  # degrees, of the eye above the x-y plane
_AZIMUTHS = range(-45, 315, 15)  # degrees, where the eye may be: the first is the usual one
_IN_A_PLANE = 1e-6  # of the picture's width
_SHEET_MARGIN = 0.06  # of the picture's width, about the drawing

# Okabe and Ito's palette, which colour-blind readers can tell apart.
_GROUND, _LINK, _MOTOR, _ANCHOR, _DARK = "#8C8C8C", "#0072B2", "#D55E00", "#F0E442", "#262626"
_TOOL_COLOURS = ("#C81919", "#199919", "#1933E0")
_BARS = {  # colour and width in points
    "ground": (_GROUND, 2.0),
    "link": (_LINK, 2.2),
    "rod": (_LINK, 1.4),
    "rail": (_DARK, 1.3),
    "motor rail": (_MOTOR, 2.0),
}
_MARKS = {  # marker, size in points, face and edge
    "joint": ("o", 4.5, "white", _DARK),
    "motor": ("o", 5.5, _MOTOR, _MOTOR),
    "slider": ("s", 3.0, _DARK, _DARK),
    "ball": ("o", 4.0, _DARK, _DARK),
    "anchor": ("o", 4.5, _ANCHOR, _DARK),
}
_LAYERS = {"link": 0, "rod": 0, "rail": 0, "motor rail": 0, "slider": 1, "anchor": 3}

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
    view = _view(figures)
    seen = np.concatenate([figure.points for figure in figures]) @ view[:2].T
    low, high = seen.min(axis=0), seen.max(axis=0)
    margin = _SHEET_MARGIN * float((high - low).max())
    low, high = low - margin, high + margin
    height = float((high - low)[1] / (high - low)[0])
    columns = _sheet_columns(len(modes), min(max(height, 0.3), 2.0))
    sheet, panels = _new_sheet(report, columns, min(max(height, 0.3), 2.0))
    scale = min(1.0, _WIDEST_SHEET / columns / _PANEL)
    for axes, figure, mode in zip(panels, figures, modes, strict=True):
        _draw_figure(axes, figure, view, scale)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        axes.set_axis_off()
        small = scale < _SMALL_PANEL
        caption = _caption(mode, "\n" if small else ", ")
        axes.set_title(as_it_is(caption), fontsize=7.0 if small else 8.5, linespacing=1.3)
    return sheet


def _view(figures: Sequence[StickFigure]) -> Array:
    """Return the axes of the picture, as rows: to the right, upwards, towards the eye."""
    eye = _across(figures)
    if eye is None:
        eye = _round_about(figures)
    up = np.array([0.0, 0.0, 1.0]) if abs(eye[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    right = np.cross(up, eye)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(eye, right), eye])


def _across(figures: Sequence[StickFigure]) -> Array | None:
    """Return the normal of the plane in which all is: with z or x positive, or y negative."""
    points = np.concatenate([stroke.points for figure in figures for stroke in figure.strokes])
    sizes, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[1:]
    if sizes[2] > _IN_A_PLANE * sizes[0]:
        return None
    largest = int(first_largest(axes[2]))
    normal: Array = axes[2] * np.sign(axes[2][largest]) * (-1.0 if largest == 1 else 1.0)
    return normal


def _round_about(figures: Sequence[StickFigure]) -> Array:
    """Return the direction from which no plate is seen edge-on, as far as there is one."""
    turn, rise = np.deg2rad(_AZIMUTHS), math.radians(_ELEVATION)
    level = math.cos(rise)
    eyes = np.array(
        [level * np.cos(turn), level * np.sin(turn), np.full(turn.size, math.sin(rise))]
    )
    normals = [stroke.normal for figure in figures for stroke in figure.strokes if stroke.is_plate]
    if not normals:
        return np.asarray(eyes[:, 0])
    clarity = np.abs(np.array(normals) @ eyes).min(axis=0)
    return np.asarray(eyes[:, int(np.argmax(clarity.round(6)))])


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
    figure.supxlabel(as_it_is("\n".join(footer)), fontsize=7.5, color=_DARK)
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


def _draw_figure(axes: Any, figure: StickFigure, view: Array, scale: float) -> None:
    """Draw from far to near, marks after bodies; what is behind the ground's plate before it."""
    behind = _behind_the_ground(figure, view[2])

    def order(stroke: Stroke) -> tuple[int, int, float]:
        middle = stroke.points.mean(axis=0)
        if stroke.kind == "ground":
            return 1, 0, 0.0
        return 0 if behind(middle) else 2, _LAYERS.get(stroke.kind, 2), float(middle @ view[2])

    for rank, stroke in enumerate(sorted(figure.strokes, key=order)):
        outline = (stroke.points @ view[:2].T).T
        if outline.shape[1] == 1:
            marker, size, face, edge = _MARKS[stroke.kind]
            style = {"ms": scale * size, "mfc": face, "mec": edge, "mew": scale}
            axes.plot(*outline, marker, zorder=rank, **style)
        else:
            _draw_body(axes, stroke, outline, rank, scale)
    origin, *ends = figure.tool @ view[:2].T
    for end, colour in zip(ends, _TOOL_COLOURS, strict=True):
        line = np.column_stack([origin, end])
        axes.plot(*line, color=colour, lw=1.3 * scale, zorder=len(figure.strokes))


def _behind_the_ground(figure: StickFigure, eye: Array) -> Callable[[Array], bool]:
    plates = [stroke for stroke in figure.strokes if stroke.kind == "ground" and stroke.is_plate]
    if len(plates) != 1:
        return lambda point: False
    middle, normal = plates[0].points.mean(axis=0), plates[0].normal
    normal = normal * np.sign(normal @ eye)
    depth = _IN_A_PLANE * float(np.ptp(plates[0].points, axis=0).max())
    return lambda point: bool((point - middle) @ normal < -depth)


def _draw_body(axes: Any, stroke: Stroke, outline: Array, order: int, scale: float) -> None:
    colour, width = _BARS[stroke.kind]
    round_off = {"solid_capstyle": "round", "solid_joinstyle": "round"}
    closed = outline if outline.shape[1] == 2 else np.column_stack([outline, outline[:, :1]])
    if stroke.kind != "ground":
        axes.plot(*closed, color="white", lw=scale * (width + 2.0), zorder=order, **round_off)
    if stroke.is_plate:
        axes.fill(*outline, facecolor=colour, alpha=0.18, linewidth=0, zorder=order)
    axes.plot(*closed, color=colour, lw=scale * width, zorder=order, **round_off)
