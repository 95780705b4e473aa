"""Curves of singular poses and what is special on them, as lines and marks that do not overlap."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pmjac_pin.pictures.paper_axes import DrawnPlane
from pmjac_pin.studies.singularities.locus import LocusMark, SingularityLocus
from pmjac_pin.studies.singularities.singular_equations import Freed
from pmjac_pin.studies.workspaces.workspace import Workspace
from pmjac_pin.values.arrays import Array

_BLUE, _VERMILION, _BLACK, _GREY = "#0072B2", "#D55E00", "#000000", "#555555"
HALO = 0.9  #: points, of white around what is drawn on a map
_LINE_WIDTH = 1.0  # points


class _Line(NamedTuple):
    colour: str
    dashes: Any
    label: str


_LINE_STYLES: dict[Freed, _Line] = {
    "gain": _Line(_VERMILION, "-", "Type 2 (parallel) singularity"),
    "loss": _Line(_BLUE, (0, (4.0, 1.5)), "Type 1 (serial) singularity"),
}
_BORDERS = {
    "gain": _Line(_BLACK, "-", "boundary: Type 2 singularity"),
    "loss": _Line(_BLACK, "-", "boundary: Type 1 singularity"),
    "window": _Line(_GREY, (0, (1.0, 1.5)), "end of the window"),
    "limit": _Line(_BLACK, (0, (4.0, 1.5)), "boundary: joint limit"),
}


class _Mark(NamedTuple):
    symbol: str
    size: float
    face: str
    label: str


# Those that say most come first, and hide others at their place.
_POINT_MARKS: dict[LocusMark, _Mark] = {
    "cusp": _Mark("*", 6.5, "#F0E442", "cusp"),
    "isolated point": _Mark("o", 4.0, _BLACK, "isolated singular point"),
    "branch point": _Mark("D", 3.4, "white", "branch point"),
    "touching": _Mark("s", 3.4, "white", "curves touch"),
    "crossing": _Mark("o", 3.0, "white", "curves cross"),
}
_SEPARATE = 0.055  # inches, between the middles of marks


def locus_entries(locus: SingularityLocus) -> int:
    """Return how many entries of a legend a locus has."""
    return len({curve.kind for curve in locus.curves}) + len({one.mark for one in locus.points})


def draw_locus(
    axes: Any, locus: SingularityLocus, drawn: DrawnPlane, width: float, halo: float = 0.0
) -> None:
    """Draw curves and marks.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
    locus : SingularityLocus
    drawn : DrawnPlane
    width : float
        Of the axes, inches.
    halo : float
        Points of white around lines, which a map beneath would hide.
    """
    for kind, line in _LINE_STYLES.items():
        curves = [curve.places for curve in locus.curves if curve.kind == kind]
        _draw_runs(axes, curves, line, halo, 4)
    scale = width / (drawn.upper - drawn.lower) * [1.0, drawn.height]
    taken: list[Array] = []
    for mark, style in _POINT_MARKS.items():
        places = [one.place for one in locus.marked(mark)]
        shown = [place for place in places if _is_free(place * scale, taken)]
        if shown:
            _draw_marks(axes, np.array(shown), style)


def draw_border(axes: Any, found: Workspace) -> None:
    """Draw the border, by what keeps the machine within."""
    for reason, line in _BORDERS.items():
        pieces = [one.places for one in found.border if _end_in_words(one.reason) == reason]
        _draw_runs(axes, pieces, line, 0.0, 3)


def border_entries(found: Workspace) -> int:
    """Return how many entries of a legend a border has."""
    return len({_end_in_words(piece.reason) for piece in found.border})


def _end_in_words(told: str) -> str:
    return told if told in _BORDERS else "limit"


def _draw_runs(axes: Any, curves: list[Array], line: _Line, halo: float, order: int) -> None:
    for number, places in enumerate(curves):
        if halo:
            width = _LINE_WIDTH + 2.0 * halo
            axes.plot(*places.T, color="white", alpha=0.7, linewidth=width, zorder=order - 0.5)
        axes.plot(
            *places.T,
            linestyle=line.dashes,
            color=line.colour,
            linewidth=_LINE_WIDTH,
            label=None if number else line.label,
            solid_capstyle="round",
            zorder=order,
        )


def _draw_marks(axes: Any, places: Array, style: _Mark) -> None:
    axes.plot(
        *places.T,
        style.symbol,
        color=_BLACK,
        markersize=style.size,
        markerfacecolor=style.face,
        markeredgewidth=0.6,
        label=style.label,
        clip_on=False,
        zorder=5,
    )


def _is_free(place: Array, taken: list[Array]) -> bool:
    """Tell whether no mark is at a place, inches, and take it."""
    if any(np.linalg.norm(place - one) < _SEPARATE for one in taken):
        return False
    taken.append(place)
    return True
