"""A slice as a figure for a paper: the map of a workspace, its border, and the locus on it.

Of one column's width, without a title: what it shows stands in its caption.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pmjac_pin.errors import ArgumentError
from pmjac_pin.pictures.curve_lines import (
    HALO,
    border_entries,
    draw_border,
    draw_locus,
    locus_entries,
)
from pmjac_pin.pictures.measure_map import draw_measure
from pmjac_pin.pictures.paper_axes import COLUMN, DrawnPlane, add_legend, around, paper_axes, symbol
from pmjac_pin.studies.singularities.locus import SingularityLocus
from pmjac_pin.studies.workspaces.workspace import Workspace
from pmjac_pin.values.arrays import Array
from pmjac_pin.values.checks import check_kind

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plot_locus(locus: SingularityLocus) -> Figure:
    r"""Draw the curves of singular poses in a slice, with what is special on them.

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
    '$\\theta_{1}$ (rad)'
    """
    check_kind(locus, SingularityLocus)
    places = [curve.places for curve in locus.curves]
    lower, upper = around(places, locus.lower, locus.upper, locus.units)
    drawn = DrawnPlane(locus.plane, locus.units, lower, upper)
    figure, axes = paper_axes(drawn, locus_entries(locus), colour_bar=False)
    draw_locus(axes, locus, drawn, COLUMN)
    add_legend(figure, axes, _held_values(locus))
    return figure


def plot_workspace(found: Workspace, locus: SingularityLocus | None = None) -> Figure:
    r"""Draw what a mode reaches in a slice: a map of a measure, the border, and a locus on it.

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
    ['$y$ (m)', 'dexterity $\\sigma_{\\min}/\\sigma_{\\max}$']
    """
    check_kind(found, Workspace)
    if locus is not None and locus.plane != found.plane:
        raise ArgumentError(f"the locus is of {locus.plane}, the workspace of {found.plane}")
    lower, upper = around(
        [piece.places for piece in found.border] or [_reached(found)],
        np.array([found.first[0], found.second[0]]),
        np.array([found.first[-1], found.second[-1]]),
        found.units,
    )
    drawn = DrawnPlane(found.plane, found.units, lower, upper)
    entries = border_entries(found) + (0 if locus is None else locus_entries(locus))
    figure, axes = paper_axes(drawn, entries, colour_bar=bool(found.measure))
    draw_measure(figure, axes, found)
    draw_border(axes, found)
    if locus is not None:
        draw_locus(axes, locus, drawn, COLUMN, HALO)
    add_legend(figure, axes, _held_values(found))
    return figure


def _reached(found: Workspace) -> Array:
    """Return the places (N, 2) of all cells that are reached."""
    first, second = np.nonzero(found.reached)
    return np.column_stack([found.first[first], found.second[second]])


def _held_values(found: SingularityLocus | Workspace) -> str:
    """Return what is held, for the legend's title."""
    units = found.at.mechanism.units
    held = found.held.items()
    return ", ".join(f"{symbol(name)} = {value:.4g} {units.get(name, 'm')}" for name, value in held)
