"""A slice as a figure for a paper: the map of a workspace, its border, and the locus on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pmjac_pin.errors import ArgumentError
from pmjac_pin.pictures.figures import as_it_is, new_figure
from pmjac_pin.studies.singularities.locus import LocusMark, SingularityLocus
from pmjac_pin.studies.workspaces.workspace import Workspace
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import check_kind

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BLUE, _VERMILION, _BLACK, _REACHED = "#0072B2", "#D55E00", "#222222", "#CFE3F1"
_CURVE_STYLES = {
    "gain": (_VERMILION, "-", "gain (type II)"),
    "loss": (_BLUE, "--", "loss (type I)"),
}
_POINT_STYLES: dict[LocusMark, tuple[str, float]] = {
    "cusp": ("*", 9.0),
    "crossing": ("x", 5.0),
    "branch point": ("D", 4.5),
    "isolated point": ("o", 4.5),
}
_SIZE = (6.4, 5.6)
_ONE_COLOUR = 1e-9  # of the largest: a map of one colour


def plot_locus(locus: SingularityLocus) -> Figure:
    """Draw the curves of singular poses in a slice, with what is special on them.

    Parameters
    ----------
    locus : SingularityLocus

    Returns
    -------
    matplotlib.figure.Figure
        Save it as .pdf or .svg for print: its lines are vectors.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> bar = pj.load("five_bar")
    >>> locus = pj.singularity_locus(bar, ("theta1", "theta2"), kinds=["gain"], cells=21)
    >>> pj.plot_locus(locus).axes[0].get_xlabel()
    'theta1 [rad]'
    """
    check_kind(locus, SingularityLocus)
    figure, axes = _empty(locus, f"Singularities of {locus.at.mechanism.name}")
    _draw_locus(axes, locus)
    _add_legend(axes)
    return figure


def plot_workspace(found: Workspace, locus: SingularityLocus | None = None) -> Figure:
    """Draw what a mode reaches in a slice: a map of a measure, the border, and a locus on it.

    Parameters
    ----------
    found : Workspace
    locus : SingularityLocus, optional
        Of the same plane.

    Returns
    -------
    matplotlib.figure.Figure
        Save it as .pdf or .svg for print: its lines are vectors.

    Raises
    ------
    ArgumentError
        A locus of another plane.
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import pmjac_pin as pj
    >>> bar = pj.load("five_bar")
    >>> found = pj.workspace(bar, ("x", "y"), cells=21, measure="dexterity", trace=False)
    >>> [axes.get_ylabel() for axes in pj.plot_workspace(found).axes]
    ['y [m]', 'dexterity']
    """
    check_kind(found, Workspace)
    if locus is not None and locus.plane != found.plane:
        raise ArgumentError(f"the locus is of {locus.plane}, the workspace of {found.plane}")
    figure, axes = _empty(found, f"Workspace of {found.at.mechanism.name}")
    axes.set_title(as_it_is(f"{found.mode}{_held_in_words(found)}"), fontsize=8)
    _draw_measure(figure, axes, found)
    for number, piece in enumerate(found.border):
        label = "border" if not number else None
        axes.plot(*piece.places.T, color=_BLACK, linewidth=1.4, label=label, zorder=3)
    if locus is not None:
        _draw_locus(axes, locus)
    _add_legend(axes)
    return figure


def _empty(found: SingularityLocus | Workspace, title: str) -> tuple[Figure, Any]:
    figure: Figure = new_figure(title, _SIZE, 12.0)
    axes: Any = figure.subplots()
    for name, unit, put in zip(
        found.plane, found.units, (axes.set_xlabel, axes.set_ylabel), strict=True
    ):
        put(as_it_is(f"{name} [{unit}]"))
    if found.units[0] == found.units[1]:
        axes.set_aspect("equal")
    if isinstance(found, SingularityLocus):
        axes.set_title(as_it_is(_held_in_words(found).removeprefix(", ")), fontsize=8)
        axes.set(xlim=_ends(found, 0), ylim=_ends(found, 1))
    return figure, axes


def _ends(locus: SingularityLocus, k: int) -> tuple[float, float]:
    return float(locus.lower[k]), float(locus.upper[k])


def _held_in_words(found: SingularityLocus | Workspace) -> str:
    return "".join(f", {name} = {value:.4g}" for name, value in found.held.items())


def _draw_measure(figure: Any, axes: Any, found: Workspace) -> None:
    if not found.measure:
        reached = np.ma.masked_equal(found.reached.astype(float), 0.0).T
        axes.pcolormesh(
            found.first,
            found.second,
            reached,
            cmap=_one_colour(),
            shading="nearest",
            rasterized=True,
        )
        return
    values = np.ma.masked_invalid(found.values).T
    drawn = axes.pcolormesh(
        found.first, found.second, values, cmap="viridis", shading="nearest", rasterized=True
    )
    bar = figure.colorbar(drawn, ax=axes, shrink=0.85)
    bar.set_label(found.measure)
    spread = float(np.ptp(values.compressed())) if values.count() else 0.0
    if spread > _ONE_COLOUR * float(np.abs(values).max() if values.count() else 1.0):
        axes.contour(found.first, found.second, values, levels=6, colors="white", linewidths=0.4)


def _one_colour() -> Any:
    from matplotlib.colors import ListedColormap  # noqa: PLC0415 - heavy

    return ListedColormap([_REACHED])


def _draw_locus(axes: Any, locus: SingularityLocus) -> None:
    named: set[str] = set()
    for curve in locus.curves:
        colour, style, label = _CURVE_STYLES[curve.kind]
        shown = label if label not in named else None
        named.add(label)
        axes.plot(*curve.places.T, style, color=colour, linewidth=1.3, label=shown, zorder=4)
    for mark, (symbol, size) in _POINT_STYLES.items():
        places = np.array([point.place for point in locus.marked(mark)])
        if len(places):
            _draw_marks(axes, _each_place_once(places), mark, symbol, size)


def _draw_marks(axes: Any, places: Array, mark: str, symbol: str, size: float) -> None:
    axes.plot(
        *places.T,
        symbol,
        color=_BLACK,
        markersize=size,
        markerfacecolor="white",
        label=mark,
        zorder=5,
    )


def _each_place_once(places: Array) -> Array:
    """Return places, those of two poses that are one place only once."""
    kept: list[Array] = []
    for place in places:
        if all(np.abs(place - one).max() > 1e-9 for one in kept):
            kept.append(place)
    return np.array(kept)


def _add_legend(axes: Any) -> None:
    handles: Sequence[Any] = axes.get_legend_handles_labels()[0]
    if handles:
        axes.legend(loc="best", fontsize=7, framealpha=0.9)
