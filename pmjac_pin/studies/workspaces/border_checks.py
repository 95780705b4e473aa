"""Whether a workspace's border is one: it closes, is where the cells end, and encloses as many."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from pmjac_pin.studies.workspaces.border_pieces import SmoothPiece
from pmjac_pin.values.arrays import Array

_ENDS_MEET = 1e-6  # of the largest extent: ends of pieces that meet
_CELLS_OFF = 2.0  # cells: from the border to a cell beside it
_AT_ENDS = 4.0  # cells: by which areas differ at a border of hardly any length


def what_is_open(
    found: Sequence[SmoothPiece],
    beside: Array,
    reached: float,
    cell: Array,
    in_world: Callable[[Array], Array],
) -> str:
    """Return what is wrong with a border, with what and where; empty where nothing is.

    Parameters
    ----------
    found : sequence of SmoothPiece
    beside : ndarray, shape (k, 2)
        The cells that are reached beside one that is not.
    reached : float
        How many cells are reached.
    cell : ndarray, shape (2,)
    in_world : callable
        Places as they are told.
    """
    if not found:
        return "no piece of it was traced"
    return (
        _open_end(found, in_world)
        or _uncovered(found, beside, cell, in_world)
        or _otherwise_than_cells(found, reached, cell)
    )


def _open_end(found: Sequence[SmoothPiece], in_world: Callable[[Array], Array]) -> str:
    """Tell of an end of a piece where no other one begins, or of a beginning without an end."""
    begins = np.array([one.places[0] for one in found])
    ends = np.array([one.places[-1] for one in found])
    size = float(np.ptp(np.vstack([one.places for one in found]), axis=0).max())
    apart = np.abs(begins[:, None] - ends[None]).max(axis=-1)
    for away, places, does, other in (
        (apart.min(axis=0), ends, "ends", "begins"),
        (apart.min(axis=1), begins, "begins", "ends"),
    ):
        k = int(np.argmax(away))
        if away[k] > _ENDS_MEET * size:
            at = f"{found[k].what!r} {does} at {_place_told(in_world(places[k]))}"
            return f"{at}, and the nearest that {other} is {away[k]:.2g} off"
    return ""


def _uncovered(
    found: Sequence[SmoothPiece], beside: Array, cell: Array, in_world: Callable[[Array], Array]
) -> str:
    """Tell of a cell beside one that is not reached and has no piece of the border near it."""
    along = np.vstack([_with_places_between(one.places / cell) for one in found])
    for place in beside:
        if np.abs(along - place / cell).max(axis=1).min() > _CELLS_OFF:
            at = _place_told(in_world(place))
            return f"no piece is near the cell at {at}, the last one reached there"
    return ""


def _otherwise_than_cells(found: Sequence[SmoothPiece], reached: float, cell: Array) -> str:
    """Tell of an area that is not that of the cells, by more than one for each that it cuts."""
    inside = sum(one.area() for one in found) / float(np.prod(cell))
    cut = sum(np.abs(np.diff(one.places / cell, axis=0)).sum() for one in found)
    if abs(inside - reached) <= cut + _AT_ENDS:
        return ""
    return f"it encloses {inside:.4g} cells, and {reached:.4g} are reached"


def _place_told(place: Array) -> str:
    return f"({place[0]:.4g}, {place[1]:.4g})"


def _with_places_between(places: Array) -> Array:
    """Return places in cells with more between, at most one cell apart."""
    rows = [places]
    for k in range(len(places) - 1):
        count = int(np.abs(places[k + 1] - places[k]).max())
        rows.append(np.linspace(places[k], places[k + 1], count + 2))
    return np.vstack(rows)
