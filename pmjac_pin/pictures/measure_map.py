"""The map of a measure beneath a workspace's border: colours that grey keeps in order, contours."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from pmjac_pin.pictures.paper_axes import LETTERS, SMALL_LETTERS
from pmjac_pin.studies.workspaces.workspace import Workspace
from pmjac_pin.values.arrays import Array

_REACHED = "#DCE9F3"
_LIGHTER = 0.3  # of viridis: its darkest part would hide lines and letters
_CONTOURS = 6
_LONG_ENOUGH = 0.4  # of the map: contours with a value on them
_FROM_THE_BORDER = 3.0  # times as near as to another value
_ONE_COLOUR = 1e-9  # of the largest: a map of one colour
_UNREACHED = 2  # cells: as far as the map goes on beneath what the border cuts off


def draw_measure(figure: Any, axes: Any, found: Workspace) -> None:
    """Draw the map of a measure, or what is reached in one colour, cut off at the border."""
    outline = _border_path(found)
    values = found.values if found.measure else np.where(found.reached, 1.0, np.nan)
    if outline is not None:
        values = _continued(values)
    whole = np.ma.masked_invalid(values).T
    drawn = axes.pcolormesh(
        found.first,
        found.second,
        whole,
        cmap=_colours(found.measure),
        shading="gouraud" if found.measure and outline is not None else "nearest",
        rasterized=True,
    )
    if not whole.count():
        return
    lines = _contours(axes, found, whole) if found.measure else None
    for one in (drawn, lines):
        if outline is not None and one is not None:
            one.set_clip_path(outline, axes.transData)
    if found.measure:
        bar = figure.colorbar(drawn, ax=axes, pad=0.02, aspect=28)
        bar.set_label(_measure_label(found), fontsize=LETTERS)
        bar.ax.tick_params(labelsize=SMALL_LETTERS, width=0.6)
        bar.outline.set_linewidth(0.6)
        if lines is not None:
            bar.add_lines(lines)


def _contours(axes: Any, found: Workspace, whole: Any) -> Any:
    """Draw contours with their values; none on a map of one colour."""
    if not np.ptp(whole.compressed()) > _ONE_COLOUR * np.abs(whole).max():
        return None
    from matplotlib.ticker import MaxNLocator  # noqa: PLC0415 - heavy

    inside = np.ma.masked_where(~found.reached.T, whole)
    levels = MaxNLocator(_CONTOURS).tick_values(inside.min(), inside.max())[1:-1]
    lines = axes.contour(
        found.first, found.second, inside, levels=levels, colors="black", linewidths=0.4
    )
    size = np.array([np.ptp(found.first), np.ptp(found.second)])
    border = np.vstack([np.zeros((0, 2)), *(piece.places for piece in found.border)])
    at = list(_label_places(lines, size, border))
    if at:
        axes.clabel(lines, fontsize=SMALL_LETTERS - 1.5, inline_spacing=1.5, fmt="%g", manual=at)
    return lines


def _label_places(lines: Any, size: Array, border: Array) -> Iterator[Array]:
    """Yield where the values of contours have room: far from each other and from the border."""
    placed: list[Array] = []
    for segments in lines.allsegs:
        long = [one for one in segments if _length_of_run(one / size) >= _LONG_ENOUGH]
        if not long:
            continue
        places = np.vstack(long)
        room = _FROM_THE_BORDER * _least_gap(places / size, border / size)
        room = np.minimum(room, _least_gap(places / size, np.array(placed).reshape(-1, 2) / size))
        placed.append(places[int(np.argmax(room))])
        yield placed[-1]


def _least_gap(places: Array, others: Array) -> Array:
    """Return how far each place is from the nearest of others, (N,); 1 where there are none."""
    away = np.linalg.norm(places[:, None] - others[None], axis=-1)
    return np.asarray(away.min(axis=1, initial=1.0))


def _length_of_run(places: Array) -> float:
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def _continued(values: Array) -> Array:
    """Return a map that goes on for some cells around what is known, each as the nearest."""
    from scipy.ndimage import distance_transform_edt  # noqa: PLC0415 - heavy

    unknown = np.isnan(values)
    if unknown.all():
        return values
    away, (i, j) = distance_transform_edt(unknown, return_indices=True)
    return np.where(away <= _UNREACHED * 2**0.5, values[i, j], np.nan)


def _border_path(found: Workspace) -> Any:
    """Return the border as a path, None where it does not close."""
    if not np.isfinite(found.area):
        return None
    from matplotlib.path import Path  # noqa: PLC0415 - heavy

    rings = list(_rings([piece.places for piece in found.border]))
    if not rings:
        return None
    return Path.make_compound_path(*(Path(ring, closed=True) for ring in rings))


def _rings(pieces: Sequence[Array]) -> Iterator[Array]:
    """Yield the rings that pieces make, one after the other."""
    left = list(pieces)
    while left:
        ring = [left.pop(0)]
        while left:
            gaps = [float(np.abs(one[0] - ring[-1][-1]).max()) for one in left]
            next_one = int(np.argmin(gaps))
            if gaps[next_one] > float(np.abs(ring[0][0] - ring[-1][-1]).max()):
                break
            ring.append(left.pop(next_one))
        places = np.vstack(ring)
        yield np.vstack([places, places[:1]])


def _colours(measure: str) -> Any:
    from matplotlib import colormaps  # noqa: PLC0415 - heavy
    from matplotlib.colors import ListedColormap  # noqa: PLC0415

    if not measure:
        return ListedColormap([_REACHED])
    return ListedColormap(colormaps["viridis"](np.linspace(_LIGHTER, 1.0, 256)))


def _measure_label(found: Workspace) -> str:
    """Return what is measured, as a paper says it, with its unit."""
    units = {found.at.mechanism.units[name] for name in found.at.mechanism.actuated}
    motor = units.pop() if len(units) == 1 else "unit of the motors"
    effort = {"rad": "N/(N m)", "m": "N/N"}.get(motor, "N per unit effort")
    rate = {"rad": "m/rad", "m": "m/m"}.get(motor, f"m per {motor}")
    labels = {
        "smallest singular value": r"$\sigma_{\min}(K^*)$",
        "conditioning": r"$1/\kappa(K^*)$",
        "dexterity": r"dexterity $\sigma_{\min}/\sigma_{\max}$",
        "gear ratio": f"least speed ({rate})",
        "speed": f"greatest speed ({rate})",
        "force": f"least force ({effort})",
    }
    return labels[found.measure]
